#pragma once
#include <Eigen/Geometry>

namespace klang::rigid::detail {

/// A body in the world's inner units (length U, time sqrt(U / m) s; mass in kg).
struct BodyState {
  bool there = true;
  double mass = 0.0, inverse_mass = 0.0;                  ///< inverse_mass = 0: fixed
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity();  ///< about the centre, body axes
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of mass, in the world
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin = Eigen::Vector3d::Zero();  ///< angular velocity, world axes
  double clock = 0.0;                              ///< how far into the step the body has moved

  Eigen::Matrix3d world_inverse_inertia() const {
    const Eigen::Matrix3d r = turn.toRotationMatrix();
    return r * inverse_inertia * r.transpose();
  }
  Eigen::Vector3d angular_momentum() const {
    const Eigen::Matrix3d r = turn.toRotationMatrix();
    return r * (inertia * (r.transpose() * spin));
  }
  bool fixed() const { return inverse_mass == 0; }
  double kinetic() const {
    return fixed() ? 0.0 : 0.5 * (mass * velocity.squaredNorm() + spin.dot(angular_momentum()));
  }
};

/// Into lists of bodies; the floor has none, and gives that of any.
inline std::size_t body_index(int body) { return body > 0 ? static_cast<std::size_t>(body) : 0; }

/// The end of a torque-free rotation over h: Euler's equations dL/dt = L x w in body axes by implicit midpoint steps, whose Cayley
/// turn keeps the angular momentum in the world and whose quadratic invariants keep the energy, composed to order 4
/// (Suzuki 1990, five steps).
void rotate_freely(BodyState& body, double h);

/// Flies on, without contacts, to a time in the step; nothing if it is there or beyond, or does not move.
void fly_to(BodyState& body, double time, const Eigen::Vector3d& gravity);

}  // namespace klang::rigid::detail
