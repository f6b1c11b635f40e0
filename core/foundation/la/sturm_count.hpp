#pragma once
#include <optional>
#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

/// Number of negative eigenvalues of a symmetric matrix given by its lower triangle, from the inertia of its
/// L D L^T factor (MUMPS, 2 x 2 pivots; Sylvester's law). Empty when the factorisation fails or meets a null
/// pivot. order: a fill-reducing order, order[k] = row that comes k-th.
std::optional<long> n_negative_eigenvalues(const SparseMatrix& lower, const std::vector<int>& order);

}  // namespace klang::la
