#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/physics/rigid/contact.hpp"

namespace klang::rigid {

/// How a body answers pushes, in the frame of all and in any units that go together. Zeros: it does not move.
struct PushedBody {
  double inverse_mass = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  ///< about the centre
};

/// A push on body a along a unit direction, its opposite on body b, each at its own place.
struct PairPush {
  int a = 0, b = kFloor;  ///< into a list of bodies; kFloor: none
  Eigen::Vector3d at_a = Eigen::Vector3d::Zero(), at_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  bool only_pulls = false;  ///< of a tie: a cord, whose direction is from a to b; else it holds both ways
};

/// Relative speeds (of a's place against b's) along pushes by unit pushes, n x n: J M^-1 J^T of the free bodies.
Eigen::MatrixXd free_mobility(std::span<const PairPush> pushes, std::span<const PushedBody> bodies);

/// The same of bodies whose ties hold meanwhile: A_nn - A_nt A_tt^+ A_tn, t the ties. Of cords those count that these impulses pull. A
/// place that ties hold all but fast keeps a thousandth of its free mobility.
/// @param impulses  n: of the pushes
Eigen::MatrixXd held_mobility(std::span<const PairPush> pushes, const Eigen::VectorXd& impulses,
                              std::vector<PairPush> ties, std::span<const PushedBody> bodies);

}  // namespace klang::rigid
