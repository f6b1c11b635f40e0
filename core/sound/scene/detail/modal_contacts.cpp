#include "core/sound/scene/detail/modal_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Vector3d;

constexpr int kWorld = -1;
constexpr double kFinePeriods = 2.0;
constexpr int kFineParts = 6;
constexpr double kNear = 1.5;  ///< of reaches: what may touch

std::size_t nth(int i) { return static_cast<std::size_t>(i); }

TouchSide side(int member, const Vector3d& x) {
  TouchSide made;
  made.member = member;
  made.x = x;
  return made;
}
TouchSide side(int member, const Vector3d& x, const ModalPlace& place) {
  TouchSide made = side(member, x);
  made.place = place;
  return made;
}
ModalTouching touching(const TouchSide& a, const TouchSide& b, const Vector3d& out, double gap_m, int b_row) {
  ModalTouching made;
  made.a = a;
  made.b = b;
  made.out = out;
  made.gap_m = gap_m;
  made.b_row = b_row;
  return made;
}

}  // namespace

ModalContacts::ModalContacts(const Scene& scene, std::vector<ModalBody>& bodies, std::vector<JointPlace> joints)
    : scene_(scene), bodies_(bodies), joints_(std::move(joints)) {}

std::vector<ModalTouching> ModalContacts::find(std::vector<PressedBody>& others) {
  for (ModalBody& body : bodies_) body.swell_m = body.bent_m();
  for (std::size_t a = 0; a < bodies_.size(); ++a) {
    ModalBody& body = bodies_[a];
    const double reach = kNear * body.reach_m;
    const Vector3d ones = Vector3d::Constant(reach);
    const bool floor = scene_.solver.floor && body.centre_m.z() - reach <= 0.0;
    std::vector<const ModalBody*> modal;
    for (std::size_t b = 0; b < bodies_.size(); ++b)
      if (b != a && (bodies_[b].centre_m - body.centre_m).norm() < reach + kNear * bodies_[b].reach_m)
        modal.push_back(&bodies_[b]);
    std::vector<const PressedBody*> rigid;
    for (const PressedBody& other : others)
      if (other.is_near(body.centre_m - ones, body.centre_m + ones)) rigid.push_back(&other);
    if (!floor && modal.empty() && rigid.empty()) {
      body.corners_m.resize(3, 0);
      continue;
    }
    body.refresh_where([&](const Vector3d& x, double radius_m) {
      const auto holds = [&](const auto* other) { return other->may_hold(x, radius_m); };
      return (floor && x.z() <= radius_m) || std::any_of(modal.begin(), modal.end(), holds) ||
             std::any_of(rigid.begin(), rigid.end(), holds);
    });
  }
  std::vector<ModalTouching> found;
  std::set<Key> now;
  for (std::size_t a = 0; a < bodies_.size(); ++a)
    if (bodies_[a].corners_m.cols() > 0) find_corners(a, others, found, now);
  was_down_ = std::move(now);
  return found;
}

void ModalContacts::find_corners(std::size_t a, std::vector<PressedBody>& others, std::vector<ModalTouching>& found,
                                 std::set<Key>& now) {
  const ModalBody& body = bodies_[a];
  const auto add = [&](ModalTouching touch, const Key& key, const rigid::Skin& skin) {
    touch.restitution = rigid::pair_restitution(body.skin, skin);
    touch.friction = rigid::pair_friction(body.skin, skin);
    touch.a_row = body.row;
    touch.is_new = was_down_.count(key) == 0;
    touch.key = key;
    if (const auto last = last_n_s_.find(key); last != last_n_s_.end()) touch.last_n_s = last->second;
    now.insert(key);
    found.push_back(std::move(touch));
  };
  const int n_bodies = static_cast<int>(bodies_.size()), own = static_cast<int>(a);
  for (const int corner : body.looked_at) {
    const Vector3d x = body.corners_m.col(corner);
    const ModalPlace& place = body.places[nth(corner)];
    const TouchSide mine = side(own, x, place);
    if (scene_.solver.floor && x.z() <= 0.0)
      add(touching(mine, side(kWorld, x), Vector3d::UnitZ(), x.z(), -1), {own, corner, -1}, *scene_.solver.floor);
    for (int b = 0; b < n_bodies; ++b) {
      const ModalBody& other = bodies_[nth(b)];
      if (b == own || other.corners_m.cols() == 0 || !other.is_near(x, 0.0)) continue;
      if (const auto depth = other.depth_of(x))
        add(touching(mine, side(b, x, depth->place), depth->out, -depth->depth_m, other.row), {own, corner, b},
            other.skin);
    }
    for (std::size_t k = 0; k < others.size(); ++k) {
      if (others[k].ball_radius_m() > 0.0) continue;
      if (const auto depth = others[k].depth_of(x))
        add(touching(mine, side(n_bodies + static_cast<int>(k), x), depth->out, -depth->depth_m, others[k].body()),
            {own, corner, -2 - others[k].body()}, others[k].skin());
    }
  }
  for (std::size_t k = 0; k < others.size(); ++k) {
    if (others[k].ball_radius_m() > 0.0) continue;
    const std::vector<Vector3d> corners = others[k].corners_m();
    for (std::size_t c = 0; c < corners.size(); ++c) {
      const Vector3d& x = corners[c];
      if (!body.is_near(x, 0.0)) continue;
      if (const auto depth = body.depth_of(x))
        add(touching(side(own, x, depth->place), side(n_bodies + static_cast<int>(k), x), -depth->out, -depth->depth_m,
                     others[k].body()),
            {own, -1 - static_cast<int>(c), -2 - others[k].body()}, others[k].skin());
    }
  }
}

double ModalContacts::next_step_s(const std::vector<ModalTouching>& touches, double dt_s, bool ends) {
  // Springs of discarded modes keep their energy over equal steps alone.
  if (std::any_of(bodies_.begin(), bodies_.end(), [](const ModalBody& body) { return body.discarded != nullptr; }))
    return dt_s;
  for (const ModalTouching& touch : touches) {
    if (!touch.is_new) continue;
    for (const int member : {touch.a.member, touch.b.member}) {
      if (member < 0 || nth(member) >= bodies_.size()) continue;
      const ModalBody& body = bodies_[nth(member)];
      if (body.modes.z.size() == 0) continue;
      const double slowest_s = 2.0 * kPi / std::sqrt(body.modes.lambda().minCoeff());
      fine_until_s_ = std::max(fine_until_s_, body.time_s + kFinePeriods * slowest_s);
    }
  }
  if (ends) fine_ = bodies_.front().time_s < fine_until_s_;
  return fine_ ? dt_s / kFineParts : dt_s;
}

double ModalContacts::solve(std::vector<PressedBody>& others, double step_s, bool ends) {
  ahead_rigid_j_ = 0.0;
  std::vector<ModalTouching> touches = find(others);
  const double dt_s = next_step_s(touches, step_s, ends);
  for (ModalBody& body : bodies_) body.modes.set_step(dt_s);
  for (ModalTouching& touch : touches)
    if (last_dt_s_ > 0.0) touch.last_n_s *= dt_s / last_dt_s_;
  last_dt_s_ = dt_s;
  last_n_s_.clear();
  const std::size_t n_all = bodies_.size() + others.size();
  std::vector<int> root(n_all);
  std::iota(root.begin(), root.end(), 0);
  const auto root_of = [&](int i) {
    while (root[nth(i)] != i) i = root[nth(i)];
    return i;
  };
  const auto join = [&](int i, int j) {
    const int a = root_of(i), b = root_of(j);
    root[nth(std::max(a, b))] = std::min(a, b);
  };
  const auto moves = [&](int member) {
    return member >= 0 &&
           (nth(member) < bodies_.size() || others[nth(member) - bodies_.size()].inverse_mass_per_kg() > 0.0);
  };
  for (const ModalTouching& touch : touches)
    if (touch.b.member >= 0 && moves(touch.b.member)) join(touch.a.member, touch.b.member);
  for (const JointPlace& joint : joints_)
    if (joint.other >= 0) join(joint.body, joint.other);
  std::map<int, std::vector<int>> islands;
  for (std::size_t i = 0; i < n_all; ++i)
    if (moves(static_cast<int>(i))) islands[root_of(static_cast<int>(i))].push_back(static_cast<int>(i));
  for (const auto& [first, members] : islands) {
    if (nth(first) >= bodies_.size()) continue;  // a rigid body that touches none
    std::vector<ModalTouching> own;
    for (const ModalTouching& touch : touches)
      if (root_of(touch.a.member) == first) own.push_back(touch);
    ModalIsland island({bodies_, others, scene_.solver.gravity_m_s2, dt_s}, members, std::move(own), joints_);
    island.solve();
    island.note_held();
    given_j_ += island.given_j();
    ahead_rigid_j_ += island.ahead_rigid_j();
    joint_error_m_ = std::max(joint_error_m_, island.missed_m());
    for (std::size_t k = 0; k < island.impulses_n_s().size(); ++k)
      last_n_s_[island.touches()[k].key] = island.impulses_n_s()[k];
    for (std::size_t k = 0; k < island.impulses_n_s().size(); ++k)
      if (island.impulses_n_s()[k].squaredNorm() > 0.0) apply(island.touches()[k], island.impulses_n_s()[k], others);
  }
  return dt_s;
}

/// What a touch did, to the lists of both; a rigid body is pushed.
void ModalContacts::apply(const ModalTouching& touch, const Vector3d& impulse_n_s, std::vector<PressedBody>& others) {
  ModalBody& body = bodies_[nth(touch.a.member)];
  const Span span = body.between_steps(last_dt_s_);
  body.note(touch.a.place, touch.b.member >= 0 ? touch.b_row : -1, touch.is_new, impulse_n_s, span);
  if (touch.b.member < 0) return;
  if (nth(touch.b.member) < bodies_.size()) {
    bodies_[nth(touch.b.member)].note(touch.b.place, touch.a_row, touch.is_new, -impulse_n_s, span);
    return;
  }
  PressedBody& other = others[nth(touch.b.member) - bodies_.size()];
  other.push(touch.b.x, -impulse_n_s);
  note_rigid(body, other, touch.b.x, -impulse_n_s, touch.is_new, span);
}

void ModalContacts::note_rigid(const ModalBody& from, const PressedBody& other, const Vector3d& x,
                               const Vector3d& impulse_n_s, bool is_new, const Span& span) {
  if (other.inverse_mass_per_kg() == 0.0) return;
  events::Impulse impulse;
  impulse.time_s = span.begin_s;
  impulse.duration_s = span.duration_s;
  impulse.shape = events::PulseShape::kHeld;
  impulse.kind = is_new ? events::ImpulseKind::kImpact : events::ImpulseKind::kLasting;
  impulse.body = other.body();
  impulse.other = from.row;
  impulse.point_m = other.to_body(x);
  impulse.impulse_n_s = other.turned_to_body(impulse_n_s);
  on_rigid_.push_back(impulse);
}

}  // namespace klang::scene::detail
