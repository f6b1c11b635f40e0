#include "core/physics/rigid/detail/ball_touches.hpp"

#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

/// Of a face, for a point in front of it.
Vector3d nearest_on(const HullFeatures& hull, const HullFeatures::Plate& plate, const Vector3d& point, double height) {
  const Vector3d foot = point - height * plate.normal;
  Vector3d best = foot;
  double least = HUGE_VAL;
  for (std::size_t i = 0; i < plate.corners.size(); ++i) {
    const Vector3d from = hull.corners.col(plate.corners[i]);
    const Vector3d along = hull.corners.col(plate.corners[(i + 1) % plate.corners.size()]) - from;
    if (!(along.cross(plate.normal).dot(foot - from) > 0)) continue;  // inside this side
    const Vector3d on_side = from + std::clamp(along.dot(point - from) / along.squaredNorm(), 0.0, 1.0) * along;
    const double distance = (point - on_side).squaredNorm();
    if (distance < least) least = distance, best = on_side;
  }
  return best;
}

}  // namespace

NearestPlace nearest_place(const HullFeatures& hull, const Vector3d& point) {
  NearestPlace nearest;
  double least = HUGE_VAL, highest = -HUGE_VAL;
  for (const HullFeatures::Plate& plate : hull.plates) {
    const double height = plate.normal.dot(point) - plate.offset;
    if (!(height > 0)) {
      if (least == HUGE_VAL && height > highest)
        nearest = {point - height * plate.normal, plate.normal, height}, highest = height;
      continue;
    }
    const Vector3d place = nearest_on(hull, plate, point, height);
    const double distance = (point - place).norm();
    if (distance < least) nearest = {place, (point - place) / distance, distance}, least = distance;
  }
  return nearest;
}

}  // namespace klang::rigid::detail
