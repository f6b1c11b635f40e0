#include "core/physics/rigid/detail/impact_group.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace klang::rigid::detail {

using Eigen::Vector3d;

namespace {

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

ImpactLosses settle_ties(const std::vector<Contact*>& group, Bodies& bodies) {
  Group ties;
  for (Contact* c : group)
    if (c->link >= 0) ties.push_back(c);
  return ties.empty() ? ImpactLosses() : solve_group(ties, 0.0, bodies);
}

ImpactLosses solve_impacts(const std::vector<Contact*>& group, Bodies& bodies) {
  return solve_group(group, 1.0, bodies);
}

}  // namespace klang::rigid::detail
