#include "core/physics/events/world_impulses.hpp"

#include <algorithm>

namespace klang::events {

std::vector<WorldImpulse> world_impulses(const EventLog& log) {
  std::vector<std::vector<Pose>> poses(log.bodies.size());
  for (const Pose& pose : log.poses) poses[static_cast<std::size_t>(pose.body)].push_back(pose);
  std::vector<WorldImpulse> rows;
  rows.reserve(log.impulses.size());
  for (const Impulse& impulse : log.impulses) {
    const std::vector<Pose>& own = poses[static_cast<std::size_t>(impulse.body)];
    Eigen::Vector3d j = impulse.impulse_n_s;
    if (!own.empty()) {
      // A contact's row lies within the step that ends with that pose. A crack's is at a step's end, or is of the breakage that made
      // the piece, whose first pose is at the end of the step in which its parent was struck.
      const bool at_end = impulse.kind == ImpulseKind::kFracture;
      const int parent = log.bodies[static_cast<std::size_t>(impulse.body)].parent;
      const bool at_birth = at_end && parent >= 0 && log.broken_s(parent) == impulse.time_s;
      auto pose = std::partition_point(own.begin(), own.end(), [&](const Pose& p) {
        return at_end ? p.time_s < impulse.time_s : p.time_s <= impulse.time_s;
      });
      if (pose == own.end()) --pose;
      if (at_birth) pose = own.begin();
      j = pose->orientation() * j;
    }
    WorldImpulse row;
    row.time_s = impulse.time_s;
    row.body = log.bodies[static_cast<std::size_t>(impulse.body)].name;
    row.other = impulse.other < 0 ? "floor" : log.bodies[static_cast<std::size_t>(impulse.other)].name;
    row.x_m = impulse.point_m.x();
    row.y_m = impulse.point_m.y();
    row.z_m = impulse.point_m.z();
    row.jx_n_s = j.x();
    row.jy_n_s = j.y();
    row.jz_n_s = j.z();
    row.duration_s = impulse.duration_s;
    row.kind = impulse.kind;
    rows.push_back(row);
  }
  return rows;
}

}  // namespace klang::events
