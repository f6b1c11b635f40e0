#include "core/physics/fracture/dynamic/step_limit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace klang::fracture {

double element_omega_sq(const Eigen::Matrix3d& gradients, double lame_lambda, double lame_mu, double density_kg_m3) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Eigen::Matrix<double, 6, 12> b = Eigen::Matrix<double, 6, 12>::Zero();
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d g = k == 0 ? Eigen::Vector3d(-gradients.colwise().sum().transpose())
                                     : Eigen::Vector3d(gradients.row(k - 1).transpose());
    for (int axis = 0; axis < 3; ++axis) b(axis, 3 * k + axis) = g[axis];
    b(3, 3 * k) = b(5, 3 * k + 2) = g.y();
    b(3, 3 * k + 1) = b(4, 3 * k + 2) = g.x();
    b(4, 3 * k) = b(5, 3 * k + 1) = g.z();
  }
  // Square root of C: on the first three strains a + b I with eigenvalues 3 lambda + 2 mu along (1,1,1) and 2 mu.
  Matrix6 root = Matrix6::Zero();
  const double shear = std::sqrt(std::max(0.0, 2.0 * lame_mu));
  const double bulk = std::sqrt(std::max(0.0, 3.0 * lame_lambda + 2.0 * lame_mu));
  root.topLeftCorner<3, 3>().setConstant((bulk - shear) / 3.0);
  root.topLeftCorner<3, 3>().diagonal().array() += shear;
  root.bottomRightCorner<3, 3>().diagonal().setConstant(std::sqrt(std::max(0.0, lame_mu)));
  const Eigen::Matrix<double, 6, 12> weighted = root * b;
  const Matrix6 product = weighted * weighted.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver(product, Eigen::EigenvaluesOnly);
  return 4.0 / density_kg_m3 * solver.eigenvalues()[5];
}

double largest_step_s(Integrator integrator, double omega_rad_s, double damping_ratio) {
  const double z = damping_ratio;
  switch (integrator) {
    case Integrator::kLeapfrog:
      return 2.0 / (std::sqrt(1.0 + z * z) + z) / omega_rad_s;
    case Integrator::kEuler:
      return (z <= 1.0 ? 2.0 * z : 2.0 / (z + std::sqrt(z * z - 1.0))) / omega_rad_s;
    case Integrator::kTaylor:
      return z > 0.0 ? std::min(4.0 * z, 1.0 / z) / omega_rad_s : 0.0;
  }
  return 0.0;
}

}  // namespace klang::fracture
