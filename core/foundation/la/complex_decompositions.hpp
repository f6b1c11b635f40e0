#pragma once
#include <Eigen/Core>

/// Dense complex decompositions by LAPACK: Eigen's own take a compiler half a minute per place that uses them.
namespace klang::la {

/// Of a square matrix, in LAPACK's order. @throws NumericalError where the QR iteration does not converge
Eigen::VectorXcd eigenvalues(Eigen::MatrixXcd a);

/// a = u diag(s) v^H: m x r, r, n x r with r = min(m, n), s falling.
struct SingularValues {
  Eigen::MatrixXcd u, v;
  Eigen::VectorXd s;
};
/// @throws NumericalError where the iteration does not converge
SingularValues singular_values(Eigen::MatrixXcd a);

}  // namespace klang::la
