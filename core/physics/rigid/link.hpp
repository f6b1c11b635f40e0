#pragma once
#include <Eigen/Core>
#include <optional>

#include "core/physics/rigid/contact.hpp"

namespace klang::rigid {

/// What two bodies, or a body and the world, are tied by. It pulls without friction and without rebound, and its impulses stand in
/// no record: it is not heard. What it takes is booked as lost in contacts.
struct Link {
  int a = 0, b = kFloor;                             ///< kFloor: the world, in which b's place then is
  Eigen::Vector3d at_a_m = Eigen::Vector3d::Zero();  ///< in a's frame
  Eigen::Vector3d at_b_m = Eigen::Vector3d::Zero();  ///< in b's frame
  std::optional<double> length_m;  ///< a cord: the two places are never farther apart; none: they stay together
};

}  // namespace klang::rigid
