#include "core/physics/rigid/detail/step_impacts.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/physics/rigid/detail/tied_bodies.hpp"

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

constexpr int kMostOfPair = 5;

Vector3d velocity_at(const BodyState& body, const Vector3d& arm) { return body.velocity + body.spin.cross(arm); }

/// When a gap that shrinks at that speed, and is pulled on, is nothing; from now.
double time_to_touch(double gap, double approach, double pull) {
  const double square = approach * approach - 2 * pull * gap;
  return square > 0 ? 2 * gap / (approach + std::sqrt(square)) : gap / approach;
}

}  // namespace

StepImpacts::StepImpacts(const TouchFinder& finder, const ImpactRules& rules, std::vector<BodyState>& bodies,
                         std::vector<BodyState>& there, std::vector<Contact> at_end)
    : finder_(finder), rules_(rules), bodies_(bodies), view_{bodies, {}}, there_(there) {
  for (const BodyState& b : bodies) view_.inverse_inertia.push_back(b.world_inverse_inertia());
  partners_.resize(bodies.size());
  for (std::size_t first = 0, last = 0; first < at_end.size(); first = last) {
    const Pair pair(at_end[first].a, at_end[first].b);
    while (last < at_end.size() && Pair(at_end[last].a, at_end[last].b) == pair) ++last;
    keep(pair,
         {at_end.begin() + static_cast<std::ptrdiff_t>(first), at_end.begin() + static_cast<std::ptrdiff_t>(last)});
  }
}

StepImpacts::Striking StepImpacts::striking(const std::vector<Contact>& contacts, const BodyState& a,
                                            const BodyState& b) const {
  Striking deepest;
  for (const Contact& c : contacts) {
    Vector3d speed = velocity_at(a, c.arm_a), pull = Vector3d::Zero();
    if (c.b >= 0) speed -= velocity_at(b, c.arm_b);
    const double approach = -c.normal.dot(speed);
    if (!(approach > rules_.rest_speed) || !(c.gap < deepest.gap)) continue;
    if (!a.fixed()) pull += rules_.gravity;
    if (c.b >= 0 && !b.fixed()) pull -= rules_.gravity;
    deepest = {c.gap, approach, pull.dot(c.normal)};
  }
  return deepest;
}

/// When a pair that strikes before the step's end does so; HUGE_VAL: it is pressed, and strikes nowhere. Newton's steps within bounds.
double StepImpacts::touch_of(const Pair& pair, const Striking& at_end) const {
  constexpr double kTouching = 1e-14, kNoTime = 1e-15, kPressed = 1.01;
  const BodyState &a = bodies_[body_index(pair.first)], &b = bodies_[body_index(pair.second)];
  const double start = pair.second < 0 ? a.clock : std::max(a.clock, b.clock), left = rules_.dt - start;
  double reach = rules_.slop;
  for (const int body : {pair.first, pair.second}) {
    if (body < 0 || bodies_[body_index(body)].fixed()) continue;
    const BodyState& moves = bodies_[body_index(body)];
    reach +=
        2 * left *
        (moves.velocity.norm() + left * rules_.gravity.norm() + moves.spin.norm() * finder_.radius[body_index(body)]);
  }
  const auto when = [&](double time) {
    BodyState at_a = a, at_b = b;
    fly_to(at_a, time, rules_.gravity);
    if (pair.second >= 0) fly_to(at_b, time, rules_.gravity);
    return striking(finder_.of_pair(pair.first, pair.second, at_a, at_b, reach), at_a, at_b);
  };
  double before = start, after = rules_.dt, time = after + time_to_touch(at_end.gap, at_end.approach, at_end.pull);
  Striking first = when(start), last = at_end;
  if (!(first.gap > 0)) return start;
  for (int i = 0; i < 60 && after - before > kNoTime * rules_.dt; ++i) {
    if (!(before < time && time < after) || i % 8 == 7) time = 0.5 * (before + after);
    const Striking now = when(time);
    if (std::abs(now.gap) <= kTouching) return time;
    if (now.gap > 0)
      before = time, first = now;
    else
      after = time, last = now;
    if (first.gap == HUGE_VAL && last.approach < kPressed * rules_.rest_speed) return HUGE_VAL;
    time = now.gap == HUGE_VAL ? after : time + time_to_touch(now.gap, now.approach, now.pull);
  }
  return before;
}

/// Whether the pair strikes on its way to what is known of the step's end.
void StepImpacts::expect(const Pair& pair) {
  const auto struck = struck_.find(pair);
  if (struck != struck_.end() && struck->second >= kMostOfPair) return;
  const Striking at_end = striking(at_end_.at(pair), there_[body_index(pair.first)], there_[body_index(pair.second)]);
  if (!(at_end.gap <= 0)) return;
  const double time = touch_of(pair, at_end);
  if (time <= rules_.dt) due_[pair] = time;
}

void StepImpacts::keep(const Pair& pair, std::vector<Contact> contacts) {
  at_end_[pair] = std::move(contacts);
  partners_[body_index(pair.first)].push_back(pair.second);
  if (pair.second >= 0) partners_[body_index(pair.second)].push_back(pair.first);
}

/// What was expected of a body on another way.
void StepImpacts::forget(int body) {
  for (const int other : partners_[body_index(body)]) {
    const Pair pair = other < 0 || body < other ? Pair(body, other) : Pair(other, body);
    at_end_.erase(pair);
    due_.erase(pair);
    if (other >= 0) std::erase(partners_[body_index(other)], body);
  }
  partners_[body_index(body)].clear();
}

void StepImpacts::fly(int body, double time) {
  if (body < 0 || bodies_[body_index(body)].fixed()) return;
  fly_to(bodies_[body_index(body)], time, rules_.gravity);
  view_.inverse_inertia[body_index(body)] = bodies_[body_index(body)].world_inverse_inertia();
}

/// Where bodies are to be now, and whom they meet on the way.
void StepImpacts::go_on(const std::vector<int>& changed) {
  for (const int body : changed) {
    forget(body);
    there_[body_index(body)] = bodies_[body_index(body)];
    fly_to(there_[body_index(body)], rules_.dt, rules_.gravity);
    finder_.collisions.move(body, there_[body_index(body)]);
  }
  std::vector<int> looked;
  for (const int body : changed) {
    const std::vector<Contact> met = finder_.of_body(body, looked, there_, rules_.slop);
    looked.push_back(body);
    for (std::size_t first = 0, last = 0; first < met.size(); first = last) {
      const Pair pair(met[first].a, met[first].b);
      while (last < met.size() && Pair(met[last].a, met[last].b) == pair) ++last;
      keep(pair, {met.begin() + static_cast<std::ptrdiff_t>(first), met.begin() + static_cast<std::ptrdiff_t>(last)});
      expect(pair);
    }
  }
}

/// The links of a pair's bodies, and of those that they tie to them: they pass a blow on at once.
void StepImpacts::add_tied(const Pair& pair, double time, std::vector<Contact>& points) {
  if (finder_.links.empty()) return;
  std::set<Pair> known{pair};
  std::vector<int> to_look{pair.first, pair.second};
  for (std::size_t i = 0; i < to_look.size(); ++i) {
    const int body = to_look[i];
    if (body < 0 || bodies_[body_index(body)].fixed()) continue;
    for (const Link& link : finder_.links) {
      const Pair next(link.a, link.b);
      const int other = link.a == body ? link.b : link.a;
      if ((link.a != body && link.b != body) || (other >= 0 && !bodies_[body_index(other)].there)) continue;
      if (!known.insert(next).second) continue;
      fly(other, time);
      const std::vector<Contact> its = finder_.ties(next.first, next.second, bodies_, rules_.slop);
      if (its.empty()) continue;
      points.insert(points.end(), its.begin(), its.end());
      to_look.push_back(other);
    }
  }
}

/// Points that are solved at once; their bodies are there.
std::vector<Contact> StepImpacts::touching(const Pair& pair, double time) {
  fly(pair.first, time);
  fly(pair.second, time);
  if (!rules_.simultaneous) {
    std::vector<Contact> points = finder_.of_pair(pair.first, pair.second, bodies_, rules_.slop);
    if (!points.empty()) add_tied(pair, time, points);
    return points;
  }
  std::vector<Contact> all;
  std::set<Pair> known;
  std::vector<int> to_look{pair.first, pair.second};
  for (std::size_t i = 0; i < to_look.size(); ++i) {
    const int body = to_look[i];
    if (body < 0 || bodies_[body_index(body)].fixed()) continue;  // what does not move passes nothing on
    for (const int other : finder_.neighbours(body)) {
      if (other >= 0 && !bodies_[body_index(other)].there) continue;
      const Pair next = other < 0 || body < other ? Pair(body, other) : Pair(other, body);
      if (!known.insert(next).second) continue;
      fly(other, time);
      std::vector<Contact> its = finder_.of_pair(next.first, next.second, bodies_, rules_.slop);
      if (its.empty()) continue;
      all.insert(all.end(), its.begin(), its.end());
      to_look.push_back(other);
    }
  }
  return all;
}

/// How far the pair's bodies give way along the normals of its points, with what is tied to them.
void StepImpacts::find_gives(std::vector<Contact>& points) const {
  TiedBodies tied(view_);
  std::vector<PairPush> pushes;
  std::vector<Contact*> pushed;
  std::vector<double> impulses;
  for (Contact& c : points) {
    if (c.link >= 0) {  // the nearest first
      if (tied.ties.size() < kMostTies) tied.add_tie(c);
      continue;
    }
    c.give = mobility(c, view_)[0];
    pushes.push_back(tied.push_of(c));
    pushed.push_back(&c);
    impulses.push_back(c.impact[0]);
  }
  if (tied.ties.empty() || pushes.empty()) return;
  const auto n = static_cast<Eigen::Index>(pushes.size());
  const Eigen::VectorXd held =
      held_gives(pushes, Eigen::Map<const Eigen::VectorXd>(impulses.data(), n), tied.ties, tied.bodies);
  for (Eigen::Index i = 0; i < n; ++i) pushed[static_cast<std::size_t>(i)]->give = held[i];
}

void StepImpacts::collide(const Pair& pair, double time) {
  due_.erase(pair);
  ++struck_[pair];
  std::vector<Contact> points = touching(pair, time);
  std::vector<Contact*> group;
  std::vector<int> changed;
  for (Contact& c : points) group.push_back(&c);
  const ImpactLosses by_ties = settle_ties(group, view_);
  for (Contact& c : points) {
    c.touch = time;
    c.approach = std::max(0.0, -relative_velocity(c, view_)[0]);
    for (const int body : {c.a, c.b})
      if (body >= 0 && !bodies_[body_index(body)].fixed() &&
          std::find(changed.begin(), changed.end(), body) == changed.end())
        changed.push_back(body);
  }
  if (group.empty()) return;
  const ImpactLosses losses = solve_impacts(group, view_);
  find_gives(points);
  losses_.normal += by_ties.normal + losses.normal;
  losses_.friction += by_ties.friction + losses.friction;
  for (const Contact& c : points)
    if (c.impact.squaredNorm() > 0) impacts_.push_back(c);
  go_on(changed);
}

void StepImpacts::solve() {
  for (const auto& [pair, contacts] : at_end_) expect(pair);
  while (!due_.empty()) {
    const auto first =
        std::min_element(due_.begin(), due_.end(), [](const auto& x, const auto& y) { return x.second < y.second; });
    const auto [pair, time] = *first;
    collide(pair, time);
  }
}

std::vector<Contact> StepImpacts::at_end() const {
  std::vector<Contact> contacts;
  for (const auto& [pair, its] : at_end_) contacts.insert(contacts.end(), its.begin(), its.end());
  return contacts;
}

}  // namespace klang::rigid::detail
