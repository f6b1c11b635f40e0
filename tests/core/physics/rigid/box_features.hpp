#pragma once
#include "core/physics/rigid/detail/hull_axis.hpp"

namespace klang::rigid::detail {

inline Eigen::Matrix3Xd box_corners(double x, double y, double z) {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i) corners.col(i) = 0.5 * Eigen::Vector3d(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
  return corners;
}

inline std::vector<std::vector<int>> box_faces() {
  return {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
}

inline HullFeatures box(double x, double y, double z) { return {box_corners(x, y, z), box_faces()}; }

}  // namespace klang::rigid::detail
