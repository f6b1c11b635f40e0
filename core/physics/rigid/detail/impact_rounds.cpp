#include "core/physics/rigid/detail/impact_rounds.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace klang::rigid::detail {

using Eigen::Vector3d;

namespace {

constexpr int kRounds = 5;
constexpr int kSweeps = 2000;
constexpr double kTolerance = 1e-14;  // of the fastest approach

using Group = std::vector<Contact*>;

/// What a group's impulses took: -J . (u- + u+) / 2, along the normal and across.
ImpactLosses losses_of(const Group& group, const std::vector<Vector3d>& before, const Bodies& bodies) {
  ImpactLosses losses;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const Vector3d mean = 0.5 * (before[i] + relative_velocity(*group[i], bodies));
    const Vector3d& impulse = group[i]->impact;
    losses.normal -= impulse[0] * mean[0];
    losses.friction -= impulse.tail<2>().dot(mean.tail<2>());
  }
  return losses;
}

/// Motions of a group's bodies, to go back to.
class Before {
 public:
  Before(const Group& group, Bodies& bodies) : bodies_(bodies) {
    for (const Contact* c : group)
      for (const int body : {c->a, c->b})
        if (body >= 0) was_.emplace(body, bodies.all[static_cast<std::size_t>(body)]);
  }
  void again() {
    for (const auto& [body, state] : was_) bodies_.all[static_cast<std::size_t>(body)] = state;
  }

 private:
  Bodies& bodies_;
  std::map<int, BodyState> was_;
};

/// One group of points at once. The impulse that is solved for starts anew (friction's cone is that of this impact) and is added.
ImpactLosses solve_group(const Group& group, double rebound, Bodies& bodies) {
  constexpr double kUnsolved = 1e-3;  // of the fastest approach
  Before state(group, bodies);
  std::vector<Vector3d> before, sums;
  double fastest = 0.0;
  for (Contact* c : group) {
    const Vector3d u = relative_velocity(*c, bodies);
    c->target = std::max(0.0, -rebound * c->restitution * u[0]);
    fastest = std::max(fastest, -u[0]);
    sums.push_back(c->impact);
    c->impact.setZero();
    before.push_back(u);
  }
  const double left = solve_contacts(group, &Contact::impact, kSweeps, kTolerance * fastest, bodies);
  const ImpactLosses losses = losses_of(group, before, bodies);
  double scale = 0.0;
  for (const Contact* c : group) scale += c->impact[0] * fastest;
  // Points on two sides of a body that is caught between parts of another cannot all rebound: then none does.
  const bool unsolved = !(left <= kUnsolved * fastest);
  if ((unsolved || losses.normal + losses.friction < -1e-10 * scale) && rebound > 0) {
    state.again();
    for (std::size_t i = 0; i < group.size(); ++i) group[i]->impact = sums[i];
    return solve_group(group, !unsolved && rebound > 0.01 ? 0.9 * rebound : 0.0, bodies);
  }
  for (std::size_t i = 0; i < group.size(); ++i) group[i]->impact += sums[i];
  return losses;
}

}  // namespace

void fly_to(BodyState& body, double time, const Vector3d& gravity) {
  const double h = time - body.clock;
  if (body.fixed() || !(h > 0)) return;
  body.centre += h * (body.velocity + 0.5 * h * gravity);
  body.velocity += h * gravity;
  body.clock = time;
}

ImpactLosses solve_impacts(std::vector<Contact>& contacts, const ImpactRules& rules, Bodies& bodies) {
  const auto key = [&](const Contact& c) { return rules.simultaneous ? std::pair(0, 0) : std::pair(c.a, c.b); };
  std::map<std::pair<int, int>, Group> by_pair;
  for (const Contact& c : contacts) {
    if (c.gap <= 0) by_pair[key(c)];
  }
  for (Contact& c : contacts) {  // of a face that lands flat, some corners are a last digit above the ground
    if (const auto pair = by_pair.find(key(c)); pair != by_pair.end()) pair->second.push_back(&c);
  }
  std::vector<std::pair<double, Group>> groups;
  for (auto& [pair, group] : by_pair) {
    double first = HUGE_VAL;
    for (const Contact* c : group) first = std::min(first, c->touch);
    groups.emplace_back(first, std::move(group));
  }
  std::stable_sort(groups.begin(), groups.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  ImpactLosses sum;
  for (int round = 0; round < kRounds; ++round) {
    bool any = false;
    for (auto& [touch, group] : groups) {
      double fastest = 0.0;
      for (const Contact* c : group) {
        fly_to(bodies.all[static_cast<std::size_t>(c->a)], touch, rules.gravity);
        if (c->b >= 0) fly_to(bodies.all[static_cast<std::size_t>(c->b)], touch, rules.gravity);
      }
      for (const Contact* c : group) fastest = std::max(fastest, -relative_velocity(*c, bodies)[0]);
      if (!(fastest > rules.rest_speed)) continue;
      any = true;
      for (Contact* c : group) {
        if (c->approach == 0) c->approach = std::max(0.0, -relative_velocity(*c, bodies)[0]);
      }
      const ImpactLosses losses = solve_group(group, 1.0, bodies);
      sum.normal += losses.normal;
      sum.friction += losses.friction;
    }
    if (!any || rules.simultaneous) break;
  }
  return sum;
}

}  // namespace klang::rigid::detail
