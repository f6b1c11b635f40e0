#pragma once
#include <optional>

#include "core/foundation/la/detail/front_tree.hpp"

namespace klang::la::detail {

struct PivotSigns {
  long n_negative = 0;
  /// sum_ij l_ij^2 |d_j| / sum_i |a_ii|: 1 for a definite matrix. The signs are those of A + E with |E_ij| <= c eps sqrt(g_i g_j),
  /// g_i = sum_j l_ij^2 |d_j|, c of the order of the number of entries in a row of L: to a smooth vector x, E matters
  /// `growth` times as much as the round-off of a Cholesky factor.
  double growth = 0;
};

/// Signs of the pivots of P A P^T = L D L^T, A symmetric, given by its lower triangle; no row is exchanged. Multifrontal: the
/// factor is not kept, so that the memory needed is that of the fronts on one path of the elimination tree. Empty where a pivot
/// vanishes or memory does not reach. tree: of a matrix of the pattern of `lower`.
/// Source: Duff and Reid, ACM TOMS 9 (1983) 302; bound: Higham, Accuracy and Stability of Numerical Algorithms, 2nd ed., (10.6).
std::optional<PivotSigns> pivot_signs(const FrontTree& tree, const SparseMatrix& lower);

}  // namespace klang::la::detail
