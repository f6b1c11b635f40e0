#include "core/sound/scene/detail/held_touch.hpp"

#include <algorithm>

#include "core/sound/scene/detail/link_reader.hpp"
#include "core/sound/scene/scene_bodies.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Vector3d;

constexpr double kTaut = 1e-4;  // of a cord's length, by which poses of a log are less than exact

/// Bodies of one touch in the world, by numbers of their own.
class PushedBodies {
 public:
  int add(int row, const rigid::PushedBody& own, const events::Pose& pose) {
    const auto [entry, is_new] = numbers_.try_emplace(row, static_cast<int>(all.size()));
    if (!is_new) return entry->second;
    const Eigen::Matrix3d turn = pose.orientation().toRotationMatrix();
    all.push_back({own.inverse_mass, pose.to_world(own.centre), turn * own.inverse_inertia * turn.transpose()});
    poses.push_back(pose);
    return entry->second;
  }
  Vector3d in_world(int number, const Vector3d& place_m) const {
    return number < 0 ? place_m : poses[static_cast<std::size_t>(number)].to_world(place_m);
  }
  std::vector<rigid::PushedBody> all;
  std::vector<events::Pose> poses;

 private:
  std::map<int, int> numbers_;
};

}  // namespace

HeldTouches::HeldTouches(const Scene& scene, const events::EventLog& log, const AnswerOf& answer_of) : log_(log) {
  if (scene.links.empty()) return;
  std::map<std::string, int> row_of;
  for (std::size_t row = 0; row < log.bodies.size(); ++row)
    if (log.bodies[row].parent < 0) row_of.emplace(log.bodies[row].name, static_cast<int>(row));
  std::vector<int> rows;  // of the scene's bodies; -1: not in the log
  for (const SceneBody& body : scene.bodies) {
    const auto found = row_of.find(body.name);
    rows.push_back(found == row_of.end() ? -1 : found->second);
  }
  const auto row = [&](int body) { return body < 0 ? -1 : rows[static_cast<std::size_t>(body)]; };
  std::vector<SceneLink> known;
  for (const SceneLink& link : scene.links) {
    if (row(link.body) < 0 || (link.other >= 0 && row(link.other) < 0)) continue;
    bool answers = true;
    for (const int body : {link.body, link.other}) {
      if (body < 0 || bodies_.count(row(body)) != 0) continue;
      const auto answer = answer_of(row(body));
      if (answer) bodies_[row(body)] = {log.motion_of(row(body)), *answer, log.broken_s(row(body))};
      answers = answers && answer.has_value();
    }
    if (answers) known.push_back(link);
  }
  const auto pose_of = [&](int body) {
    const events::Motion& motion = bodies_.at(row(body)).motion;
    return motion.poses().empty() ? events::Pose{} : motion.poses().front();
  };
  links_ = rigid_links(known, pose_of, [&](int body) {
    return rigid_body_of(scene, scene.bodies[static_cast<std::size_t>(body)]).size_m();
  });
  for (rigid::Link& link : links_) {
    link.a = row(link.a);
    link.b = row(link.b);
  }
}

/// Rows of links and -1, the world.
bool HeldTouches::is_there(int row, double time_s) const {
  if (row < 0) return true;
  const std::optional<double>& broken_s = bodies_.at(row).broken_s;
  return !broken_s || time_s < *broken_s;
}

std::optional<Eigen::MatrixXd> HeldTouches::mobility_per_kg(const PairPlaces& touch) const {
  PushedBodies bodies;
  std::vector<rigid::PairPush> pushes, ties;
  std::vector<int> to_look;
  std::vector<char> known(links_.size(), 0);
  const auto add = [&](int row) {
    if (row < 0) return rigid::kFloor;
    to_look.push_back(row);
    const auto tied = bodies_.find(row);
    if (tied != bodies_.end()) return bodies.add(row, tied->second.answer, tied->second.motion.at(touch.time_s));
    return bodies.add(row, row == touch.a ? touch.answer_a : touch.answer_b, log_.motion_of(row).at(touch.time_s));
  };
  if (std::none_of(links_.begin(), links_.end(), [&](const rigid::Link& link) {
        return link.a == touch.a || link.b == touch.a || (touch.b >= 0 && (link.a == touch.b || link.b == touch.b));
      }))
    return {};
  const int a = add(touch.a), b = add(touch.b);
  for (std::size_t i = 0; i < to_look.size(); ++i) {
    const int row = to_look[i];
    if (bodies_.count(row) == 0 || !(bodies_.at(row).answer.inverse_mass > 0.0)) continue;
    for (std::size_t l = 0; l < links_.size(); ++l) {
      const rigid::Link& link = links_[l];
      if (ties.size() >= rigid::kMostTies) break;
      if (known[l] != 0 || (link.a != row && link.b != row)) continue;
      if (!is_there(link.a, touch.time_s) || !is_there(link.b, touch.time_s)) continue;
      known[l] = 1;
      rigid::PairPush tie;
      tie.a = add(link.a);
      tie.b = add(link.b);
      tie.at_a = bodies.in_world(tie.a, link.at_a_m);
      tie.at_b = bodies.in_world(tie.b, link.at_b_m);
      const Vector3d way = tie.at_b - tie.at_a;
      tie.only_pulls = link.length_m.has_value();
      if (tie.only_pulls && !(way.norm() > (1.0 - kTaut) * *link.length_m)) continue;
      for (int axis = 0; axis < (tie.only_pulls ? 1 : 3); ++axis) {
        tie.along = tie.only_pulls ? Vector3d(way.normalized()) : Vector3d::Unit(axis);
        ties.push_back(tie);
      }
    }
  }
  if (ties.empty()) return {};
  const auto n = static_cast<Eigen::Index>(touch.at_a_m.size());
  Eigen::VectorXd impulses(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto p = static_cast<std::size_t>(i);
    const Vector3d impulse = bodies.poses[static_cast<std::size_t>(a)].orientation() * touch.impulse_n_s[p],
                   at_a = bodies.in_world(a, touch.at_a_m[p]);
    impulses[i] = impulse.norm();
    pushes.push_back({a, b, at_a, b >= 0 ? bodies.in_world(b, touch.at_b_m[p]) : at_a, impulse.normalized()});
  }
  return rigid::held_mobility(pushes, impulses, ties, bodies.all);
}

}  // namespace klang::scene::detail
