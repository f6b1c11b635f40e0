#pragma once
#include <Eigen/SparseCore>

namespace klang::la {

/// Compressed columns. Symmetric matrices are kept as their lower triangle where a docstring says so.
using SparseMatrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;

}  // namespace klang::la
