#pragma once
#include <Eigen/Core>

#include "core/physics/rigid/detail/hull_axis.hpp"

namespace klang::rigid::detail {

/// Where a hull is nearest to a point, or least deep about one inside.
struct NearestPlace {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< on its surface
  Eigen::Vector3d outward =
      Eigen::Vector3d::UnitZ();  ///< unit, from there to a point outside; inside: the face's normal
  double distance = 0.0;         ///< negative inside
};

/// Exact, by the hull's faces. @param point  in the hull's frame
NearestPlace nearest_place(const HullFeatures& hull, const Eigen::Vector3d& point);

}  // namespace klang::rigid::detail
