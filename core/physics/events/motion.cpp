#include "core/physics/events/motion.hpp"

#include <algorithm>

#include "core/foundation/base/check.hpp"

namespace klang::events {

Motion::Motion(std::vector<Pose> poses) : poses_(std::move(poses)) {
  for (std::size_t i = 1; i < poses_.size(); ++i) {
    KLANG_CHECK(poses_[i - 1].time_s < poses_[i].time_s && poses_[i - 1].body == poses_[i].body,
                "poses of one body, times rising");
  }
}

Pose Motion::at(double time_s) const {
  if (poses_.empty()) return {};
  const auto after = std::upper_bound(poses_.begin(), poses_.end(), time_s,
                                      [](double t, const Pose& pose) { return t < pose.time_s; });
  if (after == poses_.begin()) return poses_.front();
  if (after == poses_.end()) return poses_.back();
  const Pose &a = *(after - 1), &b = *after;
  const double part = (time_s - a.time_s) / (b.time_s - a.time_s);
  const Eigen::Quaterniond turned = a.orientation().slerp(part, b.orientation());
  return {a.body, time_s, a.position_m + part * (b.position_m - a.position_m),
          Eigen::Vector4d(turned.w(), turned.x(), turned.y(), turned.z())};
}

}  // namespace klang::events
