#pragma once
#include <Eigen/Core>
#include <optional>

namespace klang::la {

using RowMatrixXcd = Eigen::Matrix<std::complex<double>, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct DenseSolution {
  bool solved = false;
  Eigen::MatrixXcd x;
  std::optional<double> relative_residual;  ///< largest of the columns, ||b - A x|| / ||b||
  int n_refinements = 0;
  bool double_factor = false;
  double factor_s = 0.0, refine_s = 0.0;
};

/// A x = b by LU in single precision and iterative refinement; where that does not reach the tolerance, by LU in double
/// precision. Columns of b that are zero give zero. A is used up.
/// Source: Higham, Accuracy and Stability of Numerical Algorithms (2002), ch. 12.
DenseSolution dense_solve(RowMatrixXcd& a, const Eigen::MatrixXcd& b, double tolerance, int max_refinements);

}  // namespace klang::la
