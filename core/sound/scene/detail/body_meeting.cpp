#include "core/sound/scene/detail/body_meeting.hpp"

#include <algorithm>
#include <cmath>

namespace klang::scene::detail {
namespace {

using Eigen::Vector3d;

/// Of the way that the fastest node goes: contacts can make nodes faster within a step of the world.
constexpr double kReach = 3.0;
constexpr double kMargin = 1e-3;  ///< of a body's size

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double shortest_step_s(const std::vector<DeformingBody*>& bodies) {
  double least_s = HUGE_VAL;
  for (const DeformingBody* body : bodies) least_s = std::min(least_s, body->step_limit_s());
  return least_s;
}

}  // namespace

BodyMeeting::BodyMeeting(std::vector<DeformingBody*> bodies)
    : bodies_(std::move(bodies)),
      contact_(fracture::ElementContact::Pairs::kOfOthers,
               fracture::kElementContactRate / (shortest_step_s(bodies_) * shortest_step_s(bodies_)),
               [this](int a, int b) { return rigid::pair_friction(bodies_[at(a)]->skin(), bodies_[at(b)]->skin()); }),
      together_(bodies_.size(), 1),
      dt_s_(shortest_step_s(bodies_)) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    meshes_.push_back(&bodies_[i]->solid().mesh());
    bodies_[i]->solid().set_mutual_forces(
        [this, i]() -> const fracture::NodeForces& { return together_[i] != 0 ? forces().of[i] : none_; });
  }
  forces();
  for (DeformingBody* body : bodies_) body->solid().refresh();
}

const fracture::ElementContact::Forces& BodyMeeting::forces() {
  bool is_new = is_stale_ || changes_seen_.empty();
  for (std::size_t i = 0; !is_new && i < meshes_.size(); ++i) is_new = changes_seen_[i] != meshes_[i]->n_changes();
  if (!is_new) return contact_.last();
  is_stale_ = false;
  changes_seen_.clear();
  for (const fracture::CrackMesh* mesh : meshes_) changes_seen_.push_back(mesh->n_changes());
  return contact_.forces(meshes_, dt_s_);
}

const std::vector<char>& BodyMeeting::choose(double dt_s) {
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const DeformingBody* body : bodies_) {
    const fracture::ExplicitSolid& solid = body->solid();
    Eigen::AlignedBox3d box = body->box();
    double fastest_sq = 0.0;
    for (const Vector3d& velocity : solid.mesh().velocity_m_s)
      fastest_sq = std::max(fastest_sq, velocity.squaredNorm());
    const double reach_m = kReach * dt_s * (std::sqrt(fastest_sq) + dt_s * solid.options().gravity_m_s2.norm()) +
                           kMargin * box.diagonal().norm();
    box.min().array() -= reach_m;
    box.max().array() += reach_m;
    boxes.push_back(box);
  }
  together_.assign(bodies_.size(), 0);
  for (std::size_t a = 0; a < boxes.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (boxes[a].intersects(boxes[b])) together_[a] = together_[b] = 1;
  return together_;
}

void BodyMeeting::note_pushes(double dt_s) {
  for (const fracture::ElementTouch& touch : contact_.last().touches)
    pushes_.try_emplace({touch.meshes[0], touch.meshes[1], touch.elements[0], touch.elements[1]}, Vector3d::Zero())
        .first->second += dt_s * touch.force_n;
}

void BodyMeeting::advance(double until_s, std::vector<PressedBody>& pressed) {
  std::vector<DeformingBody*> members;
  for (std::size_t i = 0; i < bodies_.size(); ++i)
    if (together_[i] != 0) members.push_back(bodies_[i]);
  const double begin_s = members.front()->solid().time_s();
  pushes_.clear();
  for (DeformingBody* body : members) body->begin(until_s, pressed);
  for (double now_s = begin_s; until_s - now_s > 1e-12 * std::max(1.0, until_s);
       now_s = members.front()->solid().time_s()) {
    const double left = until_s - now_s, limit = shortest_step_s(members);
    dt_s_ = left <= limit ? left : left / std::ceil(left / limit);
    note_pushes(0.5 * dt_s_);
    for (DeformingBody* body : members) body->go(dt_s_);
    for (PressedBody& body : pressed) body.advance(dt_s_);
    is_stale_ = true;
    for (DeformingBody* body : members) body->arrive();
    note_pushes(0.5 * dt_s_);
    const double before_j = stored_j();
    bool any_open = false;
    for (DeformingBody* body : members) any_open = body->open() || any_open;
    // What was cut has other contacts: all get their forces anew, so that each push has its opposite.
    if (any_open) {
      for (DeformingBody* body : members) body->solid().refresh();
      lost_j_ += before_j - stored_j();
    }
  }
  for (DeformingBody* body : members) body->end();
  note_contacts(begin_s, until_s);
}

/// One contact for each pair of pieces, where the elements are that push most.
void BodyMeeting::note_contacts(double begin_s, double until_s) {
  struct Pushing {
    Met met;
    double largest = -1.0;
  };
  std::map<std::array<int, 4>, Pushing> of_pieces;
  for (const auto& [key, impulse] : pushes_) {
    const auto& [a, b, e, f] = key;
    const int i = meshes_[at(a)]->nodes_of(e)[0], j = meshes_[at(b)]->nodes_of(f)[0];
    Pushing& pushing = of_pieces[{a, b, bodies_[at(a)]->piece_of(i), bodies_[at(b)]->piece_of(j)}];
    pushing.met.bodies = {a, b};
    auto& [mine, theirs] = pushing.met.contacts;
    mine.impulse_n_s += impulse;
    if (!(impulse.norm() > pushing.largest)) continue;
    pushing.largest = impulse.norm();
    mine.node = i;
    theirs.node = j;
  }
  std::set<std::array<int, 4>> touched;
  for (auto& [key, pushing] : of_pieces) {
    auto& [mine, theirs] = pushing.met.contacts;
    mine.time_s = begin_s;
    mine.duration_s = until_s - begin_s;
    mine.is_new = touched_.count(key) == 0;
    const int node = theirs.node;
    theirs = mine;
    theirs.node = node;
    theirs.impulse_n_s = -mine.impulse_n_s;
    met_.push_back(pushing.met);
    for (const int body : pushing.met.bodies) bodies_[at(body)]->note_pressed();
    touched.insert(key);
  }
  touched_ = std::move(touched);
}

void BodyMeeting::add_to(SceneMotion& motion, const std::vector<std::vector<int>>& rows) const {
  for (const Met& met : met_) {
    std::array<std::optional<events::Impulse>, 2> impulses;
    for (std::size_t side = 0; side < 2; ++side) {
      const int body = met.bodies[side];
      impulses[side] = bodies_[at(body)]->impulse_of(met.contacts[side], rows[at(body)]);
    }
    if (!impulses[0] || !impulses[1]) continue;
    impulses[0]->other = impulses[1]->body;
    impulses[1]->other = impulses[0]->body;
    for (const auto& impulse : impulses) motion.log.impulses.push_back(*impulse);
  }
}

}  // namespace klang::scene::detail
