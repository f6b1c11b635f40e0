#include "core/physics/liquid/frames.hpp"

#include <algorithm>

#include "core/foundation/base/check.hpp"

namespace klang::liquid {

bool LiquidFrames::in_outlet(const Eigen::Vector3d&) const { return false; }
std::shared_ptr<const LiquidFrames> LiquidFrames::held(std::size_t, std::size_t) const { return nullptr; }

FrameTime frame_time(const LiquidFrames& frames, double time_s) {
  const std::span<const double> times = frames.time_s();
  KLANG_CHECK(!times.empty(), "frames of a liquid have at least one time");
  const auto later = std::upper_bound(times.begin(), times.end(), time_s);
  if (later == times.begin()) return {0, 0, 0.0};
  const auto before = static_cast<std::size_t>(later - times.begin()) - 1;
  if (later == times.end()) return {before, before, 0.0};
  return {before, before + 1, (time_s - times[before]) / (times[before + 1] - times[before])};
}

double phi_m(const LiquidFrames& frames, double time_s, const Eigen::Vector3d& x_m) {
  const FrameTime at = frame_time(frames, time_s);
  const double before = frames.phi_m(at.before, x_m);
  return at.share == 0.0 ? before : (1.0 - at.share) * before + at.share * frames.phi_m(at.after, x_m);
}

std::optional<Eigen::Vector3d> velocity_m_s(const LiquidFrames& frames, double time_s, const Eigen::Vector3d& x_m) {
  const FrameTime at = frame_time(frames, time_s);
  const std::optional<Eigen::Vector3d> before = frames.velocity_m_s(at.before, x_m);
  if (at.share == 0.0 || !before) return before;
  const std::optional<Eigen::Vector3d> after = frames.velocity_m_s(at.after, x_m);
  if (!after) return std::nullopt;
  return Eigen::Vector3d((1.0 - at.share) * *before + at.share * *after);
}

}  // namespace klang::liquid
