#pragma once
#include <Eigen/Core>
#include <cstddef>
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

/// Ties that count for how far a body gives way, the nearest first: far ones of a long chain do not.
inline constexpr std::size_t kMostTies = 192;

/// A push on body a along a unit direction, its opposite on body b, each at its own place.
struct PairPush {
  int a = 0, b = kFloor;  ///< into a list of bodies; kFloor: none
  Eigen::Vector3d at_a = Eigen::Vector3d::Zero(), at_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  bool only_pulls = false;  ///< of a tie: a cord, whose direction is from a to b; else it holds both ways
};

/// Of ties those that hold while bodies are pushed, of cords those that these impulses pull, and the impulses that they answer with.
/// @param impulses  n: of the pushes
struct TieAnswer {
  std::vector<PairPush> ties;
  Eigen::VectorXd impulses;
};
TieAnswer answer_of_ties(std::span<const PairPush> pushes, const Eigen::VectorXd& impulses,
                         const std::vector<PairPush>& ties, std::span<const PushedBody> bodies);

/// Relative speeds (of a's place against b's) along pushes by unit pushes, n x n, while ties hold as answer_of_ties() says: A_nn - A_nt A_tt^+ A_tn with
/// A = J M^-1 J^T of the free bodies, t the ties. A place that ties hold
/// all but fast keeps a thousandth of its free mobility.
Eigen::MatrixXd held_mobility(std::span<const PairPush> pushes, const Eigen::VectorXd& impulses,
                              const std::vector<PairPush>& ties, std::span<const PushedBody> bodies);
/// Its diagonal, of many pushes.
Eigen::VectorXd held_gives(std::span<const PairPush> pushes, const Eigen::VectorXd& impulses,
                           const std::vector<PairPush>& ties, std::span<const PushedBody> bodies);

}  // namespace klang::rigid
