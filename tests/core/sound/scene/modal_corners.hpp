#pragma once
#include <cmath>
#include <random>

#include "core/sound/scene/detail/modal_body.hpp"

namespace klang::test {

/// A ball of 9 cm with n corners and modes whose shapes are smooth, without a mesh: as much of a modal body as moves and touches the floor.
inline scene::detail::ModalBody ball_of_corners(int n, int n_modes, unsigned seed = 1) {
  scene::detail::ModalBody body;
  constexpr double kRadius = 0.09;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  Eigen::VectorXd lambda(n_modes), damping = Eigen::VectorXd::Zero(n_modes);
  std::vector<Eigen::Matrix<double, 3, 10>> of_mode(static_cast<std::size_t>(n_modes));
  for (int k = 0; k < n_modes; ++k) {
    lambda[k] = std::pow(2.0 * M_PI * (20.0 + 4.0 * k), 2);
    for (double& value : of_mode[static_cast<std::size_t>(k)].reshaped()) value = part(random);
  }
  for (int i = 0; i < n; ++i) {
    scene::detail::ModalPlace place;
    const double z = 1.0 - (2.0 * i + 1.0) / n, angle = i * M_PI * (3.0 - std::sqrt(5.0)), r = std::sqrt(1.0 - z * z);
    const Eigen::Vector3d u(r * std::cos(angle), r * std::sin(angle), z);
    place.rest_m = kRadius * u;
    Eigen::Matrix<double, 10, 1> powers;
    powers << 1.0, u, u.cwiseProduct(u), u.x() * u.y(), u.y() * u.z(), u.z() * u.x();
    place.shape.resize(3, n_modes);
    for (int k = 0; k < n_modes; ++k) place.shape.col(k) = of_mode[static_cast<std::size_t>(k)] * powers;
    body.places.push_back(std::move(place));
  }
  body.corner_shapes.resize(3 * n, n_modes);
  for (int i = 0; i < n; ++i) body.corner_shapes.middleRows(3 * i, 3) = body.places[static_cast<std::size_t>(i)].shape;
  body.groups = scene::detail::corner_groups(body.places);
  body.modes = modal::ModalState(lambda, damping);
  for (int k = 0; k < n_modes; ++k) body.modes.z[k] = 1e-4 * part(random);
  body.mass_kg = 1.6;
  body.inertia = 0.4 * 1.6 * kRadius * kRadius * Eigen::Matrix3d::Identity();
  body.rest_centre_m = Eigen::Vector3d::Zero();
  body.centre_m = {0.0, 0.0, kRadius};
  body.velocity_m_s = body.angular_momentum = Eigen::Vector3d::Zero();
  body.turn = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 3.0).normalized()));
  body.high_m = Eigen::Vector3d::Constant(kRadius);
  body.low_m = -body.high_m;
  body.reach_m = kRadius;
  body.dt_s = 5e-4;
  return body;
}

}  // namespace klang::test
