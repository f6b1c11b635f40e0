#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>

#include "core/physics/rigid/detail/hull_features.hpp"

namespace klang::rigid::detail {

/// The axis along which two hulls overlap least.
struct HullAxis {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, from b to a, in the frame of the call
  double gap = 0.0;                                   ///< along it; negative: overlap
  std::optional<std::array<std::size_t, 2>> edges;    ///< of a and of b, where they cross; nothing: a face's normal
};

/// What is known of two hulls that touched a step ago, and spares work. The result is the same without, whatever it says.
struct HullHint {
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero();  ///< a point of a, near where they touch, in a's frame
  Eigen::Vector3d on_b = Eigen::Vector3d::Zero();  ///< a point of b, in b's frame
  double gap = -HUGE_VAL;                          ///< along any axis
};

/// By the faces of the Minkowski difference: faces of either hull, and pairs of edges whose arcs of normals cross (Gregorius 2013,
/// "The separating axis test between convex polyhedra"). Ends at the first axis along which the two
/// are farther apart than near.
/// @param b_to_a  place of b in a's frame; the result is in a's frame
HullAxis hull_axis(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a, double near = 0.0,
                   const HullHint* hint = nullptr);

}  // namespace klang::rigid::detail
