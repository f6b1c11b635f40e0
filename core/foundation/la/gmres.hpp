#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>

namespace klang::la {

/// y = A x, for all columns of x at once.
using Product = std::function<Eigen::MatrixXcd(const Eigen::MatrixXcd&)>;

struct KrylovSolution {
  bool solved = false;
  Eigen::MatrixXcd x;
  std::optional<double> relative_residual;  ///< largest of the columns, ||b - A x|| / ||b||, from a product with x
  int n_products = 0;                       ///< with A, each of all columns
};

/// A x = b by GMRES, preconditioned from the right, so that its residual is that of x. Columns have a space each and take their
/// products together; those of b that are zero give zero. After max_steps, or where rounding has spoilt the residual, it starts again
/// from what it has, as long as that halves the residual.
/// @param inverse  roughly A^-1
/// @param stopped  when true, it ends unsolved
/// Source: Saad and Schultz 1986 (SIAM J. Sci. Stat. Comput. 7, 856-869).
KrylovSolution gmres(const Product& matrix, const Product& inverse, const Eigen::MatrixXcd& b, double tolerance,
                     int max_steps, const std::function<bool()>& stopped = {});

}  // namespace klang::la
