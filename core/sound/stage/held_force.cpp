#include "core/sound/stage/held_force.hpp"

#include <algorithm>
#include <map>

namespace klang::stage {
namespace {

using Eigen::VectorXd;

constexpr double kGap = 0.01;  // of a step: steps that are farther apart do not join

struct Step {
  double begin_s = 0.0, duration_s = 0.0;
  VectorXd force;
  double middle_s() const { return begin_s + 0.5 * duration_s; }
  double end_s() const { return begin_s + duration_s; }
};

bool is_held(const events::Impulse& impulse) {
  return impulse.shape == events::PulseShape::kHeld && impulse.duration_s > 0.0;
}

/// What each other body does: a polygon of its own, since bodies that are moved in smaller steps have corners where others have
/// none. Points of a step that begin at the same time and last as long are one force.
std::map<int, std::vector<Step>> steps_of(const events::EventLog& log, int body, const ModalPush& push,
                                          const PushedModes& modes) {
  std::map<int, std::map<std::pair<double, double>, VectorXd>> forces;
  for (const events::Impulse& impulse : log.impulses) {
    if (impulse.body != body || !is_held(impulse)) continue;
    const VectorXd force = push(impulse.point_m, impulse.impulse_n_s)(modes.numbers) / impulse.duration_s;
    const auto [entry, is_first] = forces[impulse.other].try_emplace({impulse.time_s, impulse.duration_s}, force);
    if (!is_first) entry->second += force;
  }
  std::map<int, std::vector<Step>> steps;
  for (auto& [other, its] : forces)
    for (auto& [time, force] : its) steps[other].push_back({time.first, time.second, std::move(force)});
  return steps;
}

double last_held_s(const events::EventLog& log) {
  double end_s = 0.0;
  for (const events::Impulse& impulse : log.impulses)
    if (is_held(impulse)) end_s = std::max(end_s, impulse.time_s + impulse.duration_s);
  return end_s;
}

struct Corner {
  double time_s;
  VectorXd force;
};

void add_run(const std::vector<Corner>& corners, const PushedModes& modes, std::vector<ModalImpulse>& impulses) {
  const VectorXd scale = -modes.angular_frequency_rad_s.array().square().inverse().matrix();
  std::vector<VectorXd> change(corners.size(), VectorXd::Zero(scale.size()));
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const VectorXd rise = corners[i + 1].force - corners[i].force;
    const VectorXd slope = rise / (corners[i + 1].time_s - corners[i].time_s);
    const VectorXd drag = modes.decay_per_s.cwiseProduct(rise);
    change[i] += slope + drag;
    change[i + 1] += drag - slope;
  }
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (change[i].isZero(0.0)) continue;
    impulses.push_back({corners[i].time_s, scale.cwiseProduct(change[i]), 0.0});
  }
}

void add_contact(const std::vector<Step>& steps, double end_s, const PushedModes& modes,
                 std::vector<ModalImpulse>& impulses) {
  for (std::size_t first = 0, last = 0; first < steps.size(); first = last) {
    std::vector<Corner> corners;
    const double before_s = steps[first].duration_s;
    if (steps[first].begin_s > kGap * before_s)
      corners.push_back({steps[first].middle_s() - before_s, VectorXd::Zero(steps[first].force.size())});
    for (last = first; last < steps.size(); ++last) {
      if (last > first && steps[last].begin_s - steps[last - 1].end_s() > kGap * steps[last].duration_s) break;
      corners.push_back({steps[last].middle_s(), steps[last].force});
    }
    const Step& final = steps[last - 1];
    if (final.end_s() < end_s - kGap * final.duration_s)
      corners.push_back({final.middle_s() + final.duration_s, VectorXd::Zero(final.force.size())});
    add_run(corners, modes, impulses);
  }
}

}  // namespace

std::vector<ModalImpulse> held_impulses(const events::EventLog& log, int body, const ModalPush& push,
                                        const PushedModes& modes) {
  const double end_s = last_held_s(log);
  std::vector<ModalImpulse> impulses;
  for (const auto& [other, steps] : steps_of(log, body, push, modes)) add_contact(steps, end_s, modes, impulses);
  std::stable_sort(impulses.begin(), impulses.end(),
                   [](const ModalImpulse& x, const ModalImpulse& y) { return x.time_s < y.time_s; });
  return impulses;
}

}  // namespace klang::stage
