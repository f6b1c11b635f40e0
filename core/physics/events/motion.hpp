#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "core/physics/events/impulse.hpp"

namespace klang::events {

/// Where a body's frame is in the world at one time: x_world = position_m + R x_body.
struct Pose {
  int body = 0;
  double time_s = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector4d orientation_wxyz = Eigen::Vector4d(1.0, 0.0, 0.0, 0.0);

  Eigen::Quaterniond orientation() const {
    return {orientation_wxyz[0], orientation_wxyz[1], orientation_wxyz[2], orientation_wxyz[3]};
  }
  Eigen::Vector3d to_world(const Eigen::Vector3d& point_m) const { return position_m + orientation() * point_m; }
  Eigen::Vector3d to_body(const Eigen::Vector3d& world_m) const {
    return orientation().conjugate() * (world_m - position_m);
  }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"body", "a row of bodies", kBodyNumbers, true}, self.body);
    visit({"time_s", "rising within a body", kTimesS, true}, self.time_s);
    visit({"position_m", "of the origin of the body's frame, in the world", kPlacesM, true}, self.position_m);
    visit({"orientation_wxyz", "unit quaternion that turns the body's frame into the world's; default 1 0 0 0"},
          self.orientation_wxyz);
  }
};

/// How one body moves: straight lines and the shortest turns (slerp) between its poses, at rest before the first and
/// after the last. A body without poses has the world's frame for its own.
class Motion {
 public:
  Motion() = default;
  /// @param poses  of one body, times rising
  explicit Motion(std::vector<Pose> poses);
  bool moves() const { return poses_.size() > 1; }
  Pose at(double time_s) const;
  const std::vector<Pose>& poses() const { return poses_; }

 private:
  std::vector<Pose> poses_;
};

}  // namespace klang::events
