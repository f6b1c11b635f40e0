#pragma once
#include "core/foundation/la/detail/front_tree.hpp"

namespace klang::la::detail {

/// L of P A P^T = L L^T, each supernode's n_rows x n_columns entries at values[tree.value_begin[s]], column-major (as CHOLMOD has
/// it). Multifrontal: disjoint subtrees run side by side, large fronts by all threads; the same bits on any number of threads while BLAS
/// runs on one. False when a pivot is not positive.
/// @param value  of A's lower triangle, in the order of the matrix that the tree was made of
bool tree_cholesky(const FrontTree& tree, const double* value, double* l);

}  // namespace klang::la::detail
