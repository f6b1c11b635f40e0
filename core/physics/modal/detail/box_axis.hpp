#pragma once
#include <Eigen/Core>
#include <vector>

namespace klang::modal::detail {

/// Values of the orthonormal Legendre polynomials p_k = sqrt(k + 1/2) P_k, k = 0 to degree, at xi in [-1, 1]: n x (degree + 1).
Eigen::MatrixXd legendre_values(int degree, const Eigen::VectorXd& xi);

/// Orthonormal polynomials on [-1, 1] that vanish at the held ends: phi_i of degree i, i + 1 or i + 2.
struct BoxAxis {
  BoxAxis(int degree, bool low_held, bool high_held);
  int degree = 0;              ///< highest
  bool has_parity = true;      ///< phi_i(-xi) = (-1)^i phi_i(xi)
  Eigen::MatrixXd legendre;    ///< (degree + 1) x n: column i has the coefficients of phi_i in p_k
  Eigen::MatrixXd derivative;  ///< (degree + 1) x n: those of phi_i'
  Eigen::MatrixXd slope;       ///< n x n, int phi_i' phi_j'
  Eigen::MatrixXd coupling;    ///< n x n, int phi_i phi_j'
  int size() const { return static_cast<int>(legendre.cols()); }
};

/// The products phi_i(x) phi_j(y) phi_k(z) of one displacement.
using BoxProducts = std::vector<Eigen::Vector3i>;

}  // namespace klang::modal::detail
