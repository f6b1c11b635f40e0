#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "core/physics/rigid/detail/hull_axis.hpp"

namespace klang::rigid::detail {

/// Where two hulls overlap, or would: b's surface there and a's distance from it along the axis; negative: overlap.
struct HullTouch {
  Eigen::Vector3d on_b = Eigen::Vector3d::Zero();  ///< in the frame of the call
  double gap = 0.0;
};

/// Points of the two along their axis of least overlap, with gaps along it: corners of what their outermost faces share, seen along
/// the axis, and the place where edges cross, if the axis is theirs. The deepest is as deep as the axis says.
/// @param b_to_a  place of b in a's frame, in which axis and result are, too
/// @param near    largest gap
std::vector<HullTouch> hull_touches(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                                    const HullAxis& axis, double near);

}  // namespace klang::rigid::detail
