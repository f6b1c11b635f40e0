#include "core/physics/rigid/recording.hpp"

#include <algorithm>
#include <set>
#include <utility>

#include "core/foundation/base/errors.hpp"

namespace klang::rigid {
namespace {

using Eigen::Vector3d;

// A touch at the very end of a step belongs before the pose there: who reads the log takes the first pose after a row.
constexpr double kBeforeEndS = 1e-9;

bool rests(const RigidWorld& world, double speed_m_s) {
  for (int i = 0; i < world.n_bodies(); ++i) {
    if (!world.is_there(i) || world.spec(i).fixed) continue;
    const double rim = 0.5 * world.spec(i).size_m() * world.angular_velocity_rad_s(i).norm();
    if (!(world.velocity_m_s(i).norm() + rim <= speed_m_s)) return false;
  }
  return true;
}

/// Bodies that are struck in a step and whatever is tied to them; nothing where there are no links.
std::set<int> struck_and_tied(const RigidWorld& world, const StepRecord& step, const std::vector<Breakage>& broken) {
  std::set<int> bodies;
  const auto was_there = [&](int body) {
    return world.is_there(body) ||
           std::any_of(broken.begin(), broken.end(), [&](const Breakage& breakage) { return breakage.body == body; });
  };
  if (world.links().empty()) return bodies;
  for (const ContactImpulse& contact : step.contacts)
    for (const int body : {contact.a, contact.b})
      if (contact.kind != events::ImpulseKind::kLasting && body >= 0 && !world.spec(body).fixed) bodies.insert(body);
  for (std::size_t before = 0; before < bodies.size();) {
    before = bodies.size();
    for (const Link& link : world.links())
      for (const auto& [from, to] : {std::pair(link.a, link.b), std::pair(link.b, link.a)})
        if (to >= 0 && bodies.count(from) != 0 && was_there(from) && was_there(to) && !world.spec(to).fixed)
          bodies.insert(to);
  }
  return bodies;
}

}  // namespace

events::Impulse impulse_on(const ContactImpulse& contact, int body, const events::Pose& pose) {
  const bool first = body == contact.a;
  events::Impulse row;
  row.time_s = std::min(contact.time_s, pose.time_s - kBeforeEndS);
  row.duration_s = contact.duration_s;
  row.shape = contact.kind == events::ImpulseKind::kLasting ? events::PulseShape::kHeld : events::PulseShape::kHertz;
  row.kind = contact.kind;
  row.body = body;
  row.other = first ? contact.b : contact.a;
  row.point_m = first ? contact.place_a_m : contact.place_b_m;
  row.impulse_n_s = pose.orientation().conjugate() * (first ? contact.impulse_n_s : Vector3d(-contact.impulse_n_s));
  return row;
}

void RecordingOptions::validate() const { checked("recording", "pose_rate_hz", pose_rate_hz, 1, 1e6); }

Recording::Recording(const RigidWorld& world, const RecordingOptions& options) : options_(options) {
  options_.validate();
  for (int i = 0; i < world.n_bodies(); ++i) {
    events::Body body;
    body.name = world.spec(i).name;
    log_.bodies.push_back(body);
  }
  ledger_.push_back(world.ledger());
  keep_poses(world);
}

void Recording::keep(const events::Pose& pose) {
  const auto [kept, is_first] = kept_s_.try_emplace(pose.body, pose.time_s);
  if (!is_first && !(kept->second < pose.time_s)) return;
  kept->second = pose.time_s;
  log_.poses.push_back(pose);
}

void Recording::keep_poses(const RigidWorld& world) {
  for (int i = 0; i < world.n_bodies(); ++i)
    if (world.is_there(i)) keep(world.pose(i));
  next_pose_s_ = world.time_s() + 1 / options_.pose_rate_hz;
}

void Recording::add(const RigidWorld& world, const StepRecord& step, const std::vector<Breakage>& broken) {
  std::set<int> pushed;
  for (const ContactImpulse& contact : step.contacts) {
    for (const int body : {contact.a, contact.b}) {
      if (body < 0) continue;
      log_.impulses.push_back(impulse_on(contact, body, world.pose(body)));
      if (!world.spec(body).fixed) pushed.insert(body);
    }
  }
  for (const int body : struck_and_tied(world, step, broken)) {
    if (const auto before = before_.find(body); before != before_.end()) keep(before->second);
    pushed.insert(body);
  }
  worst_solver_residual_m_s_ = std::max(worst_solver_residual_m_s_, step.solver_residual_m_s);
  deepest_m_ = std::max(deepest_m_, step.deepest_m);
  ledger_.push_back(world.ledger());
  for (const Breakage& breakage : broken) {
    for (const int piece : breakage.pieces) log_.bodies.push_back({world.spec(piece).name, breakage.body});
    log_.fractures.push_back({breakage.time_s.value_or(world.time_s()), breakage.body});
    log_.impulses.insert(log_.impulses.end(), breakage.impulses.begin(), breakage.impulses.end());
    keep(world.pose(breakage.body));  // its last
    pushed.erase(breakage.body);
    pushed.insert(breakage.pieces.begin(), breakage.pieces.end());
  }
  if (world.time_s() >= next_pose_s_ - 1e-12) {
    keep_poses(world);
  } else {
    for (const int body : pushed) keep(world.pose(body));
  }
  for (const Link& link : world.links())
    for (const int body : {link.a, link.b})
      if (body >= 0 && world.is_there(body)) before_[body] = world.pose(body);
}

void run(RigidWorld& world, Recording& recording, const RunOptions& options, Monitor& monitor) {
  constexpr double kQuietS = 0.1;
  const double end_s = options.end_s.value_or(options.longest_s);
  double quiet_since_s = world.time_s();
  while (world.time_s() < end_s) {
    monitor.throw_if_stopped();
    monitor.progress("rigid bodies", world.time_s() / end_s);
    StepRecord step = world.step();
    const std::vector<Breakage> broken = options.after_step ? options.after_step(world, step) : std::vector<Breakage>();
    recording.add(world, step, broken);
    if (!broken.empty() || !rests(world, options.rest_speed_m_s)) quiet_since_s = world.time_s();
    if (!options.end_s && world.time_s() - quiet_since_s >= kQuietS) return;
  }
  if (!options.end_s) {
    throw InputError("scene", "does not come to rest", "moves after " + to_text(options.longest_s) + " s",
                     "a duration, or a scene that rests");
  }
}

}  // namespace klang::rigid
