#pragma once
#include <optional>

#include "core/foundation/la/factor_pattern.hpp"
#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

/// Number of negative eigenvalues of a symmetric matrix given by its lower triangle, from the signs of D of its L D L^T
/// factor (Sylvester's law of inertia): without exchanges of rows where round-off grows to at most 1000 times that of a
/// Cholesky factor, which is so for K - shift M of a body; else by MUMPS with 2 x 2 pivots. Empty when both fail or meet a
/// null pivot. pattern: of `lower`, in a fill-reducing order.
std::optional<long> n_negative_eigenvalues(const SparseMatrix& lower, const FactorPattern& pattern);

}  // namespace klang::la
