#include "core/sound/scene/detail/modal_island.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/physics/modal/constraints/contact_problem.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostCorrections = 20, kMostSweeps = 20000, kFineSweeps = 1000;
constexpr double kFineTolerance = 1e-9, kSweepTolerance = 1e-7;
constexpr double kNotMet = 1e-6;     ///< a residual that is no more is the solver's last digits
constexpr double kHeldShare = 1e-6;  ///< of its mobility: less is left to a touch that is held

std::size_t number(int i) { return static_cast<std::size_t>(i); }

Eigen::Matrix3d frame_of(const Vector3d& out) {
  const Vector3d other = std::abs(out.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  Eigen::Matrix3d frame;
  frame.col(0) = out;
  frame.col(1) = (other - other.dot(out) * out).normalized();
  frame.col(2) = out.cross(frame.col(1));
  return frame;
}

}  // namespace

ModalIsland::ModalIsland(const World& world, std::vector<int> members, std::vector<ModalTouching> touches,
                         const std::vector<JointPlace>& joints)
    : world_(world), members_(std::move(members)), touches_(std::move(touches)) {
  for (const int member : members_) {
    offset_[member] = n_unknowns_;
    n_unknowns_ += 6;
    if (!is_modal(member)) continue;
    ModalBody& body = world_.bodies[number(member)];
    n_unknowns_ += body.modes.z.size();
    linear_program_ = linear_program_ || body.linear_program;
    flexible_ = flexible_ || body.discarded != nullptr;
    for (const HeldPlace& hold : body.held) holds_.emplace_back(member, &hold);
    for (const JointPlace& joint : joints)
      if (joint.body == member) joints_.push_back(&joint);
  }
  const bool slides = !linear_program_ && std::any_of(touches_.begin(), touches_.end(),
                                                      [](const ModalTouching& t) { return t.friction > 0.0; });
  per_ = slides ? 3 : 1;
  n_held_ = static_cast<Index>(3 * (holds_.size() + joints_.size()));
  n_down_ = per_ * static_cast<Index>(touches_.size());
}

bool ModalIsland::is_modal(int member) const { return number(member) < world_.bodies.size(); }

TouchSide ModalIsland::side_of(int member, const ModalPlace& place) const {
  const ModalBody& body = world_.bodies[number(member)];
  return {member, body.centre_m + body.arm(place), place};
}

void ModalIsland::set(Index row, const TouchSide& side, const Vector3d& along, double sign) {
  const auto found = offset_.find(side.member);
  if (found == offset_.end()) return;  // the floor, or what is fixed
  const Vector3d centre = is_modal(side.member) ? world_.bodies[number(side.member)].centre_m
                                                : world_.others[number(side.member) - world_.bodies.size()].centre_m();
  rows_.block<1, 3>(row, found->second) += sign * along.transpose();
  rows_.block<1, 3>(row, found->second + 3) += sign * (side.x - centre).cross(along).transpose();
  if (!is_modal(side.member)) return;
  const ModalBody& body = world_.bodies[number(side.member)];
  if (const Index n_modes = body.modes.z.size(); n_modes > 0)
    rows_.block(row, found->second + 6, 1, n_modes) +=
        sign * (body.turn.conjugate() * along).transpose() * side.place.shape;
}

void ModalIsland::set_rows() {
  rows_ = MatrixXd::Zero(n_held_ + n_down_, n_unknowns_);
  Index row = 0;
  for (const auto& [member, hold] : holds_) {
    for (int axis = 0; axis < 3; ++axis) set(row + axis, side_of(member, hold->place), Vector3d::Unit(axis), 1.0);
    row += 3;
  }
  for (const JointPlace* joint : joints_) {
    for (int axis = 0; axis < 3; ++axis) {
      set(row + axis, side_of(joint->body, joint->place), Vector3d::Unit(axis), 1.0);
      if (joint->other >= 0) set(row + axis, side_of(joint->other, joint->other_place), Vector3d::Unit(axis), -1.0);
    }
    row += 3;
  }
  for (const ModalTouching& touch : touches_) {
    frames_.push_back(frame_of(touch.out));
    for (Index k = 0; k < per_; ++k) {
      set(row + k, touch.a, frames_.back().col(k), 1.0);
      if (touch.b.member >= 0) set(row + k, touch.b, frames_.back().col(k), -1.0);
    }
    row += per_;
  }
}

void ModalIsland::set_mobile() {
  mobile_ = rows_.transpose();
  MatrixXd way = rows_;
  held_root_ = rows_.topRows(n_held_);
  VectorXd speed(n_unknowns_);
  for (const int member : members_) {
    const Index from = offset_[member];
    if (is_modal(member)) {
      const ModalBody& body = world_.bodies[number(member)];
      mobile_.middleRows(from, 3) /= body.mass_kg;
      mobile_.middleRows(from + 3, 3) = body.inverse_inertia() * mobile_.middleRows(from + 3, 3).eval();
      const Index n_modes = body.modes.z.size();
      speed.segment(from, 6 + n_modes) << body.velocity_m_s, body.spin(), body.modes.v;
      if (n_modes > 0) way.middleCols(from + 6, n_modes) *= (body.modes.h() / world_.dt_s).asDiagonal();
      if (n_held_ == 0) continue;
      held_root_.middleCols(from, 3) /= std::sqrt(body.mass_kg);
      const Eigen::Matrix3d turning = body.inverse_inertia().llt().matrixL();
      held_root_.middleCols(from + 3, 3) *= turning;
      if (n_modes > 0)
        held_root_.middleCols(from + 6, n_modes) *= (body.modes.h() / world_.dt_s).cwiseSqrt().asDiagonal();
    } else {
      const PressedBody& body = world_.others[number(member) - world_.bodies.size()];
      mobile_.middleRows(from, 3) *= body.inverse_mass_per_kg();
      mobile_.middleRows(from + 3, 3) = body.inverse_inertia() * mobile_.middleRows(from + 3, 3).eval();
      held_root_.middleCols(from, 6).setZero();  // neither held nor joined
      speed.segment<6>(from) << body.velocity_m_s(), body.spin_rad_s();
    }
  }
  a_ = rows_ * mobile_;
  over_step_ = way * mobile_;
  before_m_s_ = rows_ * speed;
}

/// Static compliance of discarded modes between touches, over dt^2: what an impulse of a step gives way.
void ModalIsland::set_springs() {
  const auto n = static_cast<Index>(touches_.size());
  springs_ = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      const ModalTouching &one = touches_[static_cast<std::size_t>(i)], &two = touches_[static_cast<std::size_t>(j)];
      double soft = 0.0;
      for (const auto& [side, way] : {std::pair{&one.a, 1.0}, std::pair{&one.b, -1.0}})
        for (const auto& [other, other_way] : {std::pair{&two.a, 1.0}, std::pair{&two.b, -1.0}})
          if (side->member >= 0 && side->member == other->member && is_modal(side->member))
            soft += world_.bodies[number(side->member)].discarded_m_per_n(side->place, way * one.out, other->place,
                                                                          other_way * two.out);
      springs_(i, j) = soft / (world_.dt_s * world_.dt_s);
    }
}

/// How far held places and joints would miss at the end of the next small step, over the step: what impulses have to make good.
VectorXd ModalIsland::missed_m_s() const {
  VectorXd by(n_held_);
  Index row = 0;
  const auto after = [&](int member, const ModalPlace& place) {
    return world_.bodies[number(member)].place_after(place, world_.dt_s, world_.gravity_m_s2);
  };
  for (const auto& [member, hold] : holds_) {
    const double end_s = world_.bodies[number(member)].time_s + world_.dt_s;
    by.segment<3>(row) = hold->origin_m + hold->path->displacement_m(end_s) - after(member, hold->place);
    row += 3;
  }
  for (const JointPlace* joint : joints_) {
    by.segment<3>(row) = (joint->other < 0 ? joint->world_m : after(joint->other, joint->other_place)) -
                         after(joint->body, joint->place);
    row += 3;
  }
  return by / world_.dt_s;
}

/// Of a side of a touch over the next small step, without what is to come.
Vector3d ModalIsland::moves_by_m(const TouchSide& side) const {
  if (side.member < 0) return Vector3d::Zero();
  if (is_modal(side.member)) {
    const ModalBody& body = world_.bodies[number(side.member)];
    return body.place_after(side.place, world_.dt_s, world_.gravity_m_s2) - body.centre_m - body.arm(side.place);
  }
  const PressedBody& body = world_.others[number(side.member) - world_.bodies.size()];
  if (body.inverse_mass_per_kg() == 0.0) return Vector3d::Zero();
  return world_.dt_s * (body.velocity_at(side.x) + 0.5 * world_.dt_s * world_.gravity_m_s2);
}

/// The inverse of what held places do to one another, where they may depend on one another: of the matrix B B^T, by B^T B, which is as small as
/// what can move.
struct ModalIsland::Met {
  MatrixXd root, vectors;
  VectorXd inverse_sq;
  explicit Met(const MatrixXd& held_root) : root(held_root) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(root.transpose() * root);
    const Index n = eigen.eigenvalues().size();
    const double least = kDependentHolds * eigen.eigenvalues()[n - 1];
    const auto kept = static_cast<Index>((eigen.eigenvalues().array() > least).count());
    vectors = eigen.eigenvectors().rightCols(kept);
    inverse_sq = eigen.eigenvalues().tail(kept).cwiseAbs2().cwiseInverse();
  }
  MatrixXd solve(const MatrixXd& right) const {
    return root * (vectors * (inverse_sq.asDiagonal() * (vectors.transpose() * (root.transpose() * right))));
  }
};

void ModalIsland::find_impulses() {
  VectorXd b = before_m_s_;
  const double slow = 2.0 * world_.gravity_m_s2.norm() * world_.dt_s;
  const auto is_shock = [&](std::size_t k) {
    return !flexible_ && touches_[k].is_new && before_m_s_[n_held_ + per_ * static_cast<Index>(k)] < -slow;
  };
  // A touch that lasts is held where it is over the next small step, by an impulse half before and half after what else pushes it: one that
  // stops it now, after it has given way over the last step, would take energy at first order in the step.
  for (std::size_t k = 0; k < touches_.size(); ++k) any_shock_ = any_shock_ || is_shock(k);
  const MatrixXd& mobility = any_shock_ ? a_ : over_step_;
  MatrixXd inner = mobility.bottomRightCorner(n_down_, n_down_);
  if (flexible_) set_springs();
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const auto i = static_cast<Index>(k);
    if (is_shock(k)) {
      b[n_held_ + per_ * i] += touches_[k].restitution * before_m_s_[n_held_ + per_ * i];
    } else {
      b.segment(n_held_ + per_ * i, per_) =
          frames_[k].leftCols(per_).transpose() * (moves_by_m(touches_[k].a) - moves_by_m(touches_[k].b)) / world_.dt_s;
    }
    if (!flexible_) continue;
    // Springs push by a quarter of the gap before, a half of that now and a quarter of that after the next step, which neither takes nor gives energy.
    b[n_held_ + per_ * i] += 4.0 * touches_[k].gap_m / world_.dt_s - before_m_s_[n_held_ + per_ * i];
    for (Index j = 0; j < springs_.cols(); ++j) inner(per_ * i, per_ * j) += 4.0 * springs_(i, j);
  }
  impulses_ = VectorXd::Zero(n_held_ + n_down_);
  // Holds and joints are met whatever the contacts exert: they are taken out of the contact problem.
  VectorXd right = b.tail(n_down_);
  std::optional<Met> met;
  if (n_held_ > 0) {
    b.head(n_held_) = -missed_m_s();
    met.emplace(held_root_);
    inner -= mobility.bottomLeftCorner(n_down_, n_held_) * met->solve(mobility.topRightCorner(n_held_, n_down_));
    right -= mobility.bottomLeftCorner(n_down_, n_held_) * met->solve(b.head(n_held_));
    // What is held where it touches does not move: nothing can push it there.
    for (Index first = 0; first < n_down_; first += per_) {
      const auto own = mobility.diagonal().segment(n_held_ + first, per_);
      if (!((inner.diagonal().segment(first, per_).array() <= kHeldShare * own.array()).any())) continue;
      inner.middleRows(first, per_).setZero();
      inner.middleCols(first, per_).setZero();
      inner.diagonal().segment(first, per_) = own;
      right.segment(first, per_).setZero();
    }
  }
  if (n_down_ > 0) {
    VectorXd friction(static_cast<Index>(touches_.size()));
    for (std::size_t k = 0; k < touches_.size(); ++k) friction[static_cast<Index>(k)] = touches_[k].friction;
    modal::ContactForces solved;
    if (linear_program_) {
      solved = modal::solve_contact_lp(inner, right);
    } else if (per_ == 1) {
      solved = modal::solve_lcp(inner, right);
    } else {  // many corners that slide share what they exert in many ways: sweeps then go on and on at the last digits
      VectorXd start(n_down_);
      for (std::size_t k = 0; k < touches_.size(); ++k)
        start.segment<3>(3 * static_cast<Index>(k)) = frames_[k].transpose() * touches_[k].last_n_s;
      solved = modal::solve_friction(
          inner, right, friction,
          {kMostSweeps, any_shock_ ? kFineSweeps : 0, kFineTolerance, kSweepTolerance, std::move(start)});
    }
    impulses_.tail(n_down_) = solved.forces;
    const VectorXd apart = inner * solved.forces + right;
    if (solved.residual > kNotMet)
      for (Index i = 0; i < n_down_; i += per_) given_j_ += std::max(0.0, solved.forces[i] * apart[i]);
    for (const int member : members_)
      if (is_modal(member))
        world_.bodies[number(member)].residual = std::max(world_.bodies[number(member)].residual, solved.residual);
  }
  if (met)
    impulses_.head(n_held_) =
        met->solve(-b.head(n_held_) - mobility.topRightCorner(n_held_, n_down_) * impulses_.tail(n_down_));
}

void ModalIsland::give(const MatrixXd& mobile, const MatrixXd& rows, const VectorXd& impulses) {
  const VectorXd gained = mobile * impulses, turned = rows.transpose() * impulses;
  for (const int member : members_) {
    if (!is_modal(member)) continue;
    ModalBody& body = world_.bodies[number(member)];
    const Index from = offset_[member];
    body.velocity_m_s += gained.segment<3>(from);
    body.angular_momentum += turned.segment<3>(from + 3);
    body.modes.v += gained.segment(from + 6, body.modes.z.size());
  }
}

void ModalIsland::set_ahead() {
  VectorXd half = 0.5 * impulses_;
  if (any_shock_) half.tail(n_down_).setZero();
  const VectorXd gained = mobile_ * half, turned = rows_.transpose() * half;
  for (const int member : members_) {
    const Index from = offset_[member];
    if (!is_modal(member)) {
      const PressedBody& body = world_.others[number(member) - world_.bodies.size()];
      const Vector3d push = turned.segment<3>(from), turn = turned.segment<3>(from + 3);
      ahead_rigid_j_ += body.velocity_m_s().dot(push) + body.spin_rad_s().dot(turn) +
                        1.5 * (gained.segment<3>(from).dot(push) + gained.segment<3>(from + 3).dot(turn));
      continue;
    }
    ModalBody& body = world_.bodies[number(member)];
    body.ahead_m_s = gained.segment<3>(from);
    body.ahead_momentum = turned.segment<3>(from + 3);
    body.ahead_modes = gained.segment(from + 6, body.modes.v.size());
  }
}

/// Rotations and modes do not go straight: until held places hit.
void ModalIsland::hit_held_places() {
  if (n_held_ == 0) return;
  const Met met(held_root_);
  double last = HUGE_VAL;
  for (int k = 0; k < kMostCorrections; ++k) {
    const VectorXd by = missed_m_s();
    missed_m_ = world_.dt_s * by.cwiseAbs().maxCoeff();
    if (!(by.norm() < 0.5 * last)) return;
    last = by.norm();
    const VectorXd more = met.solve(by);
    impulses_.head(n_held_) += more;
    give(mobile_.leftCols(n_held_), rows_.topRows(n_held_), more);
  }
}

/// Of a place of a modal body now, as its state has it; of rigid ones and the floor nothing: what those get is booked by the world.
Vector3d ModalIsland::speed_of(const TouchSide& side) const {
  if (side.member < 0 || !is_modal(side.member)) return Vector3d::Zero();
  const ModalBody& body = world_.bodies[number(side.member)];
  return body.velocity_m_s + body.spin().cross(side.x - body.centre_m) + body.turn * (side.place.shape * body.modes.v);
}

/// Speeds of all rows by the modal bodies' states.
VectorXd ModalIsland::speeds() const {
  VectorXd speed(n_held_ + n_down_);
  Index row = 0;
  for (const auto& [member, hold] : holds_) {
    speed.segment<3>(row) = speed_of(side_of(member, hold->place));
    row += 3;
  }
  for (const JointPlace* joint : joints_) {
    speed.segment<3>(row) = speed_of(side_of(joint->body, joint->place));
    if (joint->other >= 0) speed.segment<3>(row) -= speed_of(side_of(joint->other, joint->other_place));
    row += 3;
  }
  for (std::size_t k = 0; k < touches_.size(); ++k, row += per_)
    speed.segment(row, per_) =
        frames_[k].leftCols(per_).transpose() * (speed_of(touches_[k].a) - speed_of(touches_[k].b));
  return speed;
}

/// What impulses did by the speeds that they found and left, not by the energy that is missing: an impulse that is not the one that the
/// bodies got, or a speed that does not follow from it, leaves a residual in the ledger. What touches give
/// instead of taking, by the step's size or a wrong impulse, is no contact's.
void ModalIsland::book(const VectorXd& speeds_before_m_s) {
  const VectorXd mean = before_m_s_ + 0.5 * a_ * impulses_, own = 0.5 * (speeds_before_m_s + speeds());
  const auto n_moved = static_cast<Index>(3 * holds_.size());
  const double held_j = impulses_.head(n_moved).dot(own.head(n_moved));
  double sliding_j = 0.0;
  VectorXd normal(static_cast<Index>(touches_.size()));
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Index first = n_held_ + per_ * static_cast<Index>(k);
    normal[static_cast<Index>(k)] = impulses_[first];
    on_touches_.push_back(frames_[k].leftCols(per_) * impulses_.segment(first, per_));
    for (Index along = 1; along < per_; ++along) sliding_j -= impulses_[first + along] * mean[first + along];
  }
  ModalBody& books = world_.bodies[number(members_.front())];
  if (flexible_) books.spring_j = 0.5 * normal.dot(springs_ * normal);
  const double taken_j = released_j_ - impulses_.tail(n_down_).dot(mean.tail(n_down_)) - sliding_j - books.spring_j;
  // Springs take nothing: what they seem to is the step's size.
  const double too_much_j = flexible_ ? -taken_j : std::max(0.0, -taken_j);
  books.ledger.work_j += held_j;
  books.ledger.friction_j += sliding_j;
  books.ledger.correction_j -= too_much_j;
  books.ledger.contact_j += held_j - impulses_.dot(own) - sliding_j - books.spring_j + too_much_j;
}

void ModalIsland::note_held() {
  if (impulses_.size() == 0) return;
  Index row = 0;
  for (const auto& [member, hold] : holds_) {
    ModalBody& body = world_.bodies[number(member)];
    body.note(hold->place, body.row, false, impulses_.segment<3>(row), body.between_steps(world_.dt_s));
    row += 3;
  }
  for (const JointPlace* joint : joints_) {
    ModalBody& body = world_.bodies[number(joint->body)];
    const Vector3d impulse = impulses_.segment<3>(row);
    const Span span = body.between_steps(world_.dt_s);
    body.note(joint->place, joint->other < 0 ? body.row : world_.bodies[number(joint->other)].row, false, impulse,
              span);
    if (joint->other >= 0)
      world_.bodies[number(joint->other)].note(joint->other_place, body.row, false, -impulse, span);
    row += 3;
  }
}

void ModalIsland::solve() {
  for (const int member : members_)
    if (is_modal(member)) {
      ModalBody& body = world_.bodies[number(member)];
      body.ledger.contact_j += body.spring_j;
      released_j_ += body.spring_j;
      body.spring_j = 0.0;
      body.ahead_m_s = body.ahead_momentum = Vector3d::Zero();
      body.ahead_modes = VectorXd::Zero(body.modes.v.size());
    }
  if (n_held_ + n_down_ == 0) return;
  set_rows();
  set_mobile();
  find_impulses();
  const VectorXd before = speeds();
  give(mobile_, rows_, impulses_);
  hit_held_places();
  set_ahead();
  book(before);
}

}  // namespace klang::scene::detail
