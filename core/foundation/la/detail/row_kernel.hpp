#pragma once
#include <cstddef>

namespace klang::la::detail {

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

}  // namespace klang::la::detail
