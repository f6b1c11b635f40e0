#pragma once
#include <cstddef>

namespace klang::bubble::detail {

inline constexpr std::size_t kLane = 8;  ///< sources at a time

/// Distances r and phases k r from n_padded points (multiple of kLane; x, y, z one array after the other) to at.
void distances(const double* sources, std::size_t n_padded, double k, const double* at, double* r, double* phase);

/// Slopes along normal of the 9 singular functions (wave_rows.hpp) about the first n_sources of those points, seen from at: order
/// function by function, row[2 (f n_sources + s)] weight times the real part, + 1 minus the imaginary one (conjugated).
/// cosine, sine: of the phases. square (9 x n_padded) gets the squared moduli added.
void singular_slopes(const double* sources, std::size_t n_sources, std::size_t n_padded, double k, const double* at,
                     const double* normal, const double* r, const double* cosine, const double* sine, double weight,
                     double* row, double* square);

}  // namespace klang::bubble::detail
