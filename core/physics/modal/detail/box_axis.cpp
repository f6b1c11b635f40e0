#include "core/physics/modal/detail/box_axis.hpp"

#include <cmath>

namespace klang::modal::detail {

Eigen::MatrixXd legendre_values(int degree, const Eigen::VectorXd& xi) {
  Eigen::MatrixXd values(xi.size(), degree + 1);
  values.col(0).setOnes();
  if (degree > 0) values.col(1) = xi;
  for (int k = 1; k < degree; ++k)
    values.col(k + 1) =
        ((2.0 * k + 1.0) * xi.cwiseProduct(values.col(k)) - static_cast<double>(k) * values.col(k - 1)) / (k + 1.0);
  for (int k = 0; k <= degree; ++k) values.col(k) *= std::sqrt(k + 0.5);
  return values;
}

BoxAxis::BoxAxis(int highest, bool low_held, bool high_held) : degree(highest), has_parity(low_held == high_held) {
  const int n_held = (low_held ? 1 : 0) + (high_held ? 1 : 0), n = degree + 1 - n_held;
  legendre = Eigen::MatrixXd::Identity(degree + 1, n);
  if (n_held > 0) {
    // p_{i+1} or p_{i+2} and what makes it vanish at the held ends: P_k(1) = 1, P_k(-1) = (-1)^k. Then Gram-Schmidt, twice.
    legendre.setZero();
    for (int i = 0; i < n; ++i) {
      const int k = i + n_held, below = n_held == 2 ? k - 2 : k - 1;
      legendre(k, i) = 1.0 / std::sqrt(k + 0.5);
      legendre(below, i) = (n_held == 1 && low_held ? 1.0 : -1.0) / std::sqrt(below + 0.5);
      for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j < i; ++j) legendre.col(i) -= legendre.col(j) * legendre.col(j).dot(legendre.col(i));
        legendre.col(i).normalize();
      }
    }
  }
  Eigen::MatrixXd differentiation = Eigen::MatrixXd::Zero(degree + 1, degree + 1);
  for (int k = 1; k <= degree; ++k)
    for (int j = k - 1; j >= 0; j -= 2) differentiation(j, k) = std::sqrt((2.0 * k + 1.0) * (2.0 * j + 1.0));
  derivative = differentiation * legendre;
  slope = derivative.transpose() * derivative;
  coupling = legendre.transpose() * derivative;
}

}  // namespace klang::modal::detail
