#pragma once
#include <cstddef>

namespace klang::bubble::detail {

/// Rows of a matrix against pairs of vectors, all real: m holds n_rows rows of length n, n a multiple of kLane (padded with 0).
/// x, w: n_pairs pairs, each pair 2 n numbers, one vector after the other. y: n_rows x n_pairs x 2.
inline constexpr std::size_t kLane = 8;

/// y = M x.
void rows_times(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs, double* y);
/// w += M^T y.
void rows_add(const double* m, std::size_t n_rows, std::size_t n, const double* y, std::size_t n_pairs, double* w);
/// w += M^T (y - M x), and w += M^T (M x): each row is used twice while it is in the cache.
void rows_residual(const double* m, std::size_t n_rows, std::size_t n, const double* x, const double* y,
                   std::size_t n_pairs, double* w);
void rows_normal(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs, double* w);

/// Distances r and phases k r from n_padded points (multiple of kLane; x, y, z one array after the other) to at.
void distances(const double* sources, std::size_t n_padded, double k, const double* at, double* r, double* phase);

/// Slopes along normal of the 9 singular functions (wave_rows.hpp) about the first n_sources of those points, seen from at: order
/// function by function, row[2 (f n_sources + s)] weight times the real part, + 1 minus the imaginary one (conjugated).
/// cosine, sine: of the phases. square (9 x n_padded) gets the squared moduli added.
void singular_slopes(const double* sources, std::size_t n_sources, std::size_t n_padded, double k, const double* at,
                     const double* normal, const double* r, const double* cosine, const double* sine, double weight,
                     double* row, double* square);

}  // namespace klang::bubble::detail
