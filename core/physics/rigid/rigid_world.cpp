#include "core/physics/rigid/rigid_world.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/rigid/detail/step_impacts.hpp"
#include "core/physics/rigid/detail/tied_bodies.hpp"
#include "core/physics/rigid/impact_pulse.hpp"

namespace klang::rigid {
namespace {

using detail::BodyState;
using detail::Contact;
using Eigen::Vector3d;

constexpr double kSlop = 2e-5;  // inner lengths: bodies this near touch

}  // namespace

void RigidWorldOptions::validate() const {
  checked("solver", "rate_hz", rate_hz, 100, 1e6);
  checked("solver", "iterations", iterations, 1, 100000);
  for (int i = 0; i < 3; ++i) checked("world", "gravity_m_s2", gravity_m_s2[i], -1e3, 1e3);
}

struct RigidWorld::State {
  RigidWorldOptions options;
  int exponent = 0;  // inner length = 4^exponent m, inner time = 2^exponent s
  bool has_unit = false;
  double length = 1.0, time = 1.0;
  long long n_steps = 0;
  std::vector<RigidBodySpec> specs;
  std::vector<double> half_width;  // smallest of each body, inner length
  std::vector<double> radius;      // of its farthest point from its centre
  std::vector<BodyState> bodies;
  std::vector<Link> links;
  std::vector<Contact> held;  // lasting contacts of the last step, to start from
  detail::Collisions collisions;
  EnergyLedger ledger;
  double start_j = 0.0;

  double dt() const { return time / options.rate_hz; }
  /// Slower touches are held, not bounced: a body at rest reaches half of it in a step.
  double rest_speed() const { return std::max(2 * options.gravity_m_s2.norm() * dt(), 1e-9); }
  double joules(double inner) const { return inner / length; }
  double energy() const;
  void take_unit_from(const RigidBodySpec& body);
  void book();
  std::vector<BodyState> flown() const;
  detail::TouchFinder finder() { return {options, specs, links, collisions, radius, length}; }
  std::vector<double> gaps_before(const std::vector<Contact>& contacts, const std::vector<BodyState>& there) const;
  double hold(std::vector<Contact>& contacts, detail::Bodies& view);
  double push_apart(const std::vector<Contact>& contacts, const std::vector<double>& gaps);
  void warm_start(std::vector<Contact>& contacts, detail::Bodies& view) const;
  ContactImpulse row_of(const Contact& contact) const;
  void record(const detail::StepImpacts& impacts, const std::vector<Contact>& contacts,
              const std::vector<BodyState>& begin, StepRecord& record) const;
  void lose(detail::ImpactLosses losses);
};

/// One of the two can be negative where an impulse turns speed along the normal into speed across; both together where a solve
/// was not finished.
void RigidWorld::State::lose(detail::ImpactLosses losses) {
  const double sum = losses.normal + losses.friction;
  if (losses.normal < 0) losses = {0.0, sum};
  if (losses.friction < 0) losses = {std::max(sum, 0.0), 0.0};
  ledger.contact_j += joules(losses.normal);
  ledger.friction_j += joules(losses.friction);
  ledger.correction_j += joules(std::min(sum, 0.0));
}

double RigidWorld::State::energy() const {
  double sum = 0.0;
  for (const BodyState& b : bodies) {
    if (b.there && !b.fixed()) sum += b.kinetic() - b.mass * options.gravity_m_s2.dot(b.centre);
  }
  return sum;
}

void RigidWorld::State::take_unit_from(const RigidBodySpec& body) {
  exponent = static_cast<int>(std::lround(-std::log2(body.size_m()) / 2));
  length = std::ldexp(1.0, 2 * exponent);
  time = std::ldexp(1.0, exponent);
  has_unit = true;
}

void RigidWorld::State::book() {
  ledger.time_s = static_cast<double>(n_steps) / options.rate_hz;
  ledger.kinetic_j = ledger.potential_j = 0.0;
  for (const BodyState& b : bodies) {
    if (!b.there || b.fixed()) continue;
    ledger.kinetic_j += joules(b.kinetic());
    ledger.potential_j -= joules(b.mass * options.gravity_m_s2.dot(b.centre));
  }
  ledger.residual_j = ledger.sum_j() - start_j;
}

/// Where the bodies would be at the step's end without contacts.
std::vector<BodyState> RigidWorld::State::flown() const {
  std::vector<BodyState> there = bodies;
  constexpr std::size_t kGrain = 256;
  parallel_for(there.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (bodies[i].spin.norm() * dt() <= kMostTurnPerStep) detail::fly_to(there[i], dt(), options.gravity_m_s2);
  });
  for (std::size_t i = 0; i < there.size(); ++i) {
    const BodyState& b = there[i];
    if (!b.there || b.fixed()) continue;
    const double turned = bodies[i].spin.norm() * dt();
    if (!(turned <= kMostTurnPerStep))
      throw InputError("body " + specs[i].name, "turns too far in one step: rate_hz is too low",
                       to_text(turned) + " rad", "at most " + to_text(kMostTurnPerStep) + " rad");
    const double way = (b.centre - bodies[i].centre).norm();
    if (!(way <= half_width[i])) {
      throw InputError("body " + specs[i].name,
                       "moves farther than its smallest half-width in one step: rate_hz is too low",
                       to_text(way / length) + " m", "at most " + to_text(half_width[i] / length) + " m");
    }
  }
  return there;
}

/// Impulses of the last step at the same place of the same pair, which a resting contact has again.
void RigidWorld::State::warm_start(std::vector<Contact>& contacts, detail::Bodies& view) const {
  constexpr double kNear = 1e-2;
  std::vector<char> used(held.size(), 0);  // each once: an impulse that is given to two pushes twice
  for (Contact& c : contacts) {
    const Contact* nearest = nullptr;
    double least = kNear * kNear;
    const auto [first, last] = std::equal_range(held.begin(), held.end(), c, [](const Contact& x, const Contact& y) {
      return std::tie(x.a, x.b) < std::tie(y.a, y.b);  // as Collisions::find sorts
    });
    for (auto old = first; old != last; ++old) {
      const double distance = (old->arm_a - c.arm_a).squaredNorm();
      if (distance < least && old->link == c.link && used[static_cast<std::size_t>(old - held.begin())] == 0)
        least = distance, nearest = &*old;
    }
    if (nearest == nullptr) continue;
    used[static_cast<std::size_t>(nearest - held.data())] = 1;
    c.lasting = c.axes.transpose() * (nearest->axes * nearest->lasting);
    if (!c.tied) c.lasting[0] = std::max(0.0, c.lasting[0]);
    push(c, c.lasting, view);
  }
}

/// Of contacts at the step's end, where each body began to fly there.
std::vector<double> RigidWorld::State::gaps_before(const std::vector<Contact>& contacts,
                                                   const std::vector<BodyState>& there) const {
  const auto way = [&](int body, const Vector3d& arm) -> Vector3d {
    if (body < 0) return Vector3d::Zero();
    const BodyState &from = bodies[static_cast<std::size_t>(body)], &to = there[static_cast<std::size_t>(body)];
    return 0.5 * (dt() - from.clock) * (from.velocity + from.spin.cross(arm) + to.velocity + to.spin.cross(arm));
  };
  std::vector<double> gaps;
  for (const Contact& c : contacts) gaps.push_back(c.gap - c.normal.dot(way(c.a, c.arm_a) - way(c.b, c.arm_b)));
  return gaps;
}

/// The rest of the step after the impacts: gravity and the forces of contacts that last. Returns what is left of their conditions.
double RigidWorld::State::hold(std::vector<Contact>& contacts, detail::Bodies& view) {
  std::vector<Vector3d> before;
  std::vector<Contact*> all;
  for (Contact& c : contacts) {
    before.push_back(relative_velocity(c, view));
    all.push_back(&c);
  }
  std::vector<Vector3d> velocity;
  for (BodyState& b : bodies) {
    velocity.push_back(b.velocity);
    if (b.there && !b.fixed()) b.velocity += (dt() - b.clock) * options.gravity_m_s2;
  }
  // What comes fast and has not touched yet is an impact of the next step.
  for (Contact& c : contacts) c.target = c.gap > 0 && relative_velocity(c, view)[0] < -rest_speed() ? -HUGE_VAL : 0.0;
  warm_start(contacts, view);
  const double tolerance = 1e-7 * options.gravity_m_s2.norm() * dt() + 1e-15;
  const double residual = solve_contacts(all, &Contact::lasting, options.iterations, tolerance, view);
  detail::ImpactLosses losses;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Vector3d mean = 0.5 * (before[i] + relative_velocity(contacts[i], view));
    losses.normal -= contacts[i].lasting[0] * mean[0];
    losses.friction -= contacts[i].lasting.tail<2>().dot(mean.tail<2>());
  }
  lose(losses);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    BodyState& b = bodies[i];
    if (!b.there || b.fixed()) continue;
    const double rest = dt() - b.clock;
    b.centre += rest * 0.5 * (velocity[i] + b.velocity);
    b.clock = 0.0;
    detail::rotate_freely(b, rest);
  }
  return residual;
}

/// Bodies that overlap by more than two slops go apart by a fifth of the overlap: less what other points have moved them apart
/// already, or bodies that touch at many would fly beyond. Returns the deepest overlap.
double RigidWorld::State::push_apart(const std::vector<Contact>& contacts, const std::vector<double>& gaps) {
  double deepest = 0.0;
  std::map<int, Vector3d> moved;
  const auto way_of = [&](int body) {
    const auto found = moved.find(body);
    return found != moved.end() ? found->second : Vector3d(Vector3d::Zero());
  };
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Contact& c = contacts[i];
    deepest = std::max(deepest, -gaps[i]);
    if (!(gaps[i] < -2 * kSlop)) continue;
    const double mass_a = bodies[static_cast<std::size_t>(c.a)].inverse_mass;
    const double mass_b = c.b >= 0 ? bodies[static_cast<std::size_t>(c.b)].inverse_mass : 0.0;
    const double apart = 0.2 * (-gaps[i] - kSlop) - c.normal.dot(way_of(c.a) - way_of(c.b));
    if (!(apart > 0)) continue;
    const double way = apart / (mass_a + mass_b);
    const auto move = [&](int body, double share) {
      BodyState& b = bodies[static_cast<std::size_t>(body)];
      b.centre += share * way * c.normal;
      moved[body] = way_of(body) + share * way * c.normal;
      ledger.correction_j += joules(b.mass * options.gravity_m_s2.dot(share * way * c.normal));
    };
    if (mass_a > 0) move(c.a, mass_a);
    if (mass_b > 0) move(c.b, -mass_b);
  }
  return deepest / length;
}

/// Places as the bodies lie where the contact was found; no impulse yet.
ContactImpulse RigidWorld::State::row_of(const Contact& c) const {
  const auto a = static_cast<std::size_t>(c.a), b = static_cast<std::size_t>(std::max(c.b, 0));
  ContactImpulse row;
  row.a = c.a;
  row.b = c.b;
  row.place_m = c.place / length;
  row.normal = c.normal;
  // On each body's own surface, which lie apart by the gap.
  const Vector3d apart = c.b >= 0 ? Vector3d(0.5 * c.gap * c.normal) : Vector3d::Zero();
  row.place_a_m = specs[a].centre_m + c.turn_a.conjugate() * (c.arm_a + apart) / length;
  row.place_b_m =
      c.b >= 0 ? Vector3d(specs[b].centre_m + c.turn_b.conjugate() * (c.arm_b - apart) / length) : row.place_m;
  row.turn_a = c.turn_a;
  row.turn_b = c.turn_b;
  return row;
}

/// @param contacts  those that last
/// @param begin     the bodies at the step's begin
void RigidWorld::State::record(const detail::StepImpacts& impacts, const std::vector<Contact>& contacts,
                               const std::vector<BodyState>& begin, StepRecord& record) const {
  const double begin_s = static_cast<double>(n_steps) / options.rate_hz;
  for (const Contact& c : impacts.impacts()) {
    if (c.link >= 0) continue;
    ContactImpulse& row = record.contacts.emplace_back(row_of(c));
    const RigidBodySpec &a = specs[static_cast<std::size_t>(c.a)],
                        *b = c.b >= 0 ? &specs[static_cast<std::size_t>(c.b)] : nullptr;
    row.kind = events::ImpulseKind::kImpact;
    row.time_s = begin_s + c.touch / time;
    row.approach_m_s = c.approach / time;
    row.impulse_n_s = c.axes * c.impact / time;
    // A place that others press on does not approach: it takes as long as a blow that gave it its impulse, alone.
    const double speed_m_s =
        row.approach_m_s > 0 ? row.approach_m_s : c.give * c.impact[0] / ((1 + c.restitution) * time);
    if (speed_m_s > 0) {
      const double modulus_pa = contact_modulus_pa(a.skin, b != nullptr ? b->skin : *options.floor);
      row.duration_s = hertz_duration_s(1 / c.give, touch_radius_m(a, b, row), modulus_pa, speed_m_s);
    }
  }
  for (const Contact& c : contacts) {
    if (c.link >= 0 || !(c.lasting.squaredNorm() > 0)) continue;
    ContactImpulse& row = record.contacts.emplace_back(row_of(c));
    row.turn_a = begin[static_cast<std::size_t>(c.a)].turn;
    if (c.b >= 0) row.turn_b = begin[static_cast<std::size_t>(c.b)].turn;
    row.kind = events::ImpulseKind::kLasting;
    row.time_s = begin_s;
    row.duration_s = 1 / options.rate_hz;
    row.impulse_n_s = c.axes * c.lasting / time;
  }
  std::stable_sort(record.contacts.begin(), record.contacts.end(),
                   [](const ContactImpulse& x, const ContactImpulse& y) { return x.time_s < y.time_s; });
}

RigidWorld::RigidWorld(const RigidWorldOptions& options) : state_(std::make_unique<State>()) {
  options.validate();
  state_->options = options;
}
RigidWorld::~RigidWorld() = default;
RigidWorld::RigidWorld(RigidWorld&&) noexcept = default;
RigidWorld& RigidWorld::operator=(RigidWorld&&) noexcept = default;

StepRecord RigidWorld::step() {
  State& s = *state_;
  StepRecord record;
  const std::vector<BodyState> begin = s.bodies;
  std::vector<BodyState> there = s.flown();
  const detail::TouchFinder finder = s.finder();
  detail::StepImpacts impacts(
      finder,
      {s.options.gravity_m_s2, s.dt(), s.rest_speed(), kSlop, s.options.collisions == CollisionOrder::kSimultaneous},
      s.bodies, there, finder.all(there, kSlop));
  impacts.solve();
  s.lose(impacts.losses());
  std::vector<Contact> contacts = impacts.at_end();
  const std::vector<double> gaps = s.gaps_before(contacts, there);
  record.solver_residual_m_s = s.hold(contacts, impacts.view()) / s.time;
  record.deepest_m = s.push_apart(contacts, gaps);
  s.record(impacts, contacts, begin, record);
  s.held = std::move(contacts);
  ++s.n_steps;
  s.book();
  return record;
}

int RigidWorld::add(const RigidBodySpec& body) {
  body.validate();
  State& s = *state_;
  if (!s.has_unit) s.take_unit_from(body);
  BodyState b;
  b.mass = body.mass_kg;
  b.inertia = s.length * s.length * body.inertia_kg_m2;
  if (!body.fixed) {
    b.inverse_mass = 1 / body.mass_kg;
    b.inverse_inertia = b.inertia.inverse();
    b.velocity = s.time * body.velocity_m_s;  // 4^k / 2^k
    b.spin = body.angular_velocity_rad_s / s.time;
  }
  b.turn = body.orientation.normalized();
  b.centre = s.length * (body.position_m + b.turn * body.centre_m);
  const double before = s.energy();
  s.bodies.push_back(b);
  s.specs.push_back(body);
  s.half_width.push_back(s.length * body.smallest_half_width_m());
  s.radius.push_back(0.5 * s.length * body.size_m());
  const int number = static_cast<int>(s.bodies.size()) - 1;
  s.collisions.add(number, body, s.length, !body.fixed);
  s.ledger.work_j += s.joules(s.energy() - before);
  if (s.n_steps == 0) {  // what is there at the start is the scene's, not work
    s.ledger.work_j = 0.0;
    s.start_j = 0.0;
    s.book();
    s.start_j = s.ledger.sum_j();
  }
  s.book();
  return number;
}

const std::vector<Link>& RigidWorld::links() const { return state_->links; }

void RigidWorld::link(const Link& link) {
  State& s = *state_;
  const auto is_body = [&](int body) { return body >= 0 && body < n_bodies() && is_there(body); };
  KLANG_CHECK(is_body(link.a) && (link.b == kFloor || (is_body(link.b) && link.b != link.a)),
              "two bodies of the world");
  Link kept = link;
  if (kept.b >= 0 && kept.a > kept.b) {  // as pairs that touch
    std::swap(kept.a, kept.b);
    std::swap(kept.at_a_m, kept.at_b_m);
  }
  s.links.push_back(kept);
}

void RigidWorld::remove(int body) {
  State& s = *state_;
  const double before = s.energy();
  s.bodies.at(static_cast<std::size_t>(body)).there = false;
  s.collisions.remove(body);
  s.ledger.work_j += s.joules(s.energy() - before);
  s.book();
}

int RigidWorld::n_bodies() const { return static_cast<int>(state_->bodies.size()); }
bool RigidWorld::is_there(int body) const { return state_->bodies.at(static_cast<std::size_t>(body)).there; }
double RigidWorld::time_s() const { return state_->ledger.time_s; }
const RigidBodySpec& RigidWorld::spec(int body) const { return state_->specs.at(static_cast<std::size_t>(body)); }

events::Pose RigidWorld::pose(int body) const {
  const BodyState& b = state_->bodies.at(static_cast<std::size_t>(body));
  events::Pose pose;
  pose.body = body;
  pose.time_s = time_s();
  pose.position_m = b.centre / state_->length - b.turn * spec(body).centre_m;
  pose.orientation_wxyz << b.turn.w(), b.turn.x(), b.turn.y(), b.turn.z();
  return pose;
}

Vector3d RigidWorld::centre_m(int body) const {
  return state_->bodies.at(static_cast<std::size_t>(body)).centre / state_->length;
}
Vector3d RigidWorld::velocity_m_s(int body) const {
  return state_->bodies.at(static_cast<std::size_t>(body)).velocity / state_->time;
}
Vector3d RigidWorld::angular_velocity_rad_s(int body) const {
  return state_->bodies.at(static_cast<std::size_t>(body)).spin * state_->time;
}

void RigidWorld::set_velocity(int body, const Vector3d& velocity_m_s, const Vector3d& angular_velocity_rad_s) {
  State& s = *state_;
  BodyState& b = s.bodies.at(static_cast<std::size_t>(body));
  if (b.fixed()) throw InputError("body " + spec(body).name, "is fixed and has no velocity");
  const double before = b.kinetic();
  b.velocity = s.time * velocity_m_s;
  b.spin = angular_velocity_rad_s / s.time;
  s.ledger.work_j += s.joules(b.kinetic() - before);
  s.book();
}

void RigidWorld::shift(int body, const Vector3d& by_m) {
  State& s = *state_;
  const double before = s.energy();
  s.bodies.at(static_cast<std::size_t>(body)).centre += s.length * by_m;
  s.ledger.work_j += s.joules(s.energy() - before);
  s.book();
}

std::vector<RigidWorld::Push> RigidWorld::answer_of_ties(const std::vector<Push>& pushes) const {
  State& s = *state_;
  if (s.links.empty() || pushes.empty()) return {};
  detail::Bodies view{s.bodies, {}};
  for (const BodyState& b : s.bodies) view.inverse_inertia.push_back(b.world_inverse_inertia());
  detail::TiedBodies tied(view);
  std::vector<PairPush> given;
  Eigen::VectorXd impulses(static_cast<Eigen::Index>(pushes.size()));
  for (const Push& push : pushes) {
    impulses[static_cast<Eigen::Index>(given.size())] = push.impulse_n_s.norm();
    given.push_back({tied.number_of(push.a), tied.number_of(push.b), s.length * push.at_a_m, s.length * push.at_b_m,
                     push.impulse_n_s.normalized()});
  }
  std::set<std::pair<int, int>> pairs;
  for (const Link& link : s.links)
    if (is_there(link.a) && (link.b < 0 || is_there(link.b))) pairs.emplace(link.a, link.b);
  std::vector<Contact> taut;
  for (const auto& [a, b] : pairs)
    for (const Contact& c : s.finder().ties(a, b, s.bodies, kSlop)) taut.push_back(c);
  std::vector<char> added(taut.size(), 0);
  for (std::size_t i = 0; i < tied.known.size(); ++i)  // bodies that are tied to these come after them
    for (std::size_t k = 0; k < taut.size(); ++k) {
      const int body = tied.known[i];
      if (added[k] != 0 || (taut[k].a != body && taut[k].b != body) || s.bodies[static_cast<std::size_t>(body)].fixed())
        continue;
      added[k] = 1;
      tied.add_tie(taut[k]);
    }
  const TieAnswer answer = rigid::answer_of_ties(given, impulses, tied.ties, tied.bodies);
  std::vector<Push> all;
  for (std::size_t i = 0; i < answer.ties.size(); ++i) {
    const PairPush& tie = answer.ties[i];
    const auto number = [&](int body) { return body < 0 ? kFloor : tied.known[static_cast<std::size_t>(body)]; };
    all.push_back({number(tie.a), number(tie.b), tie.at_a / s.length, tie.at_b / s.length,
                   answer.impulses[static_cast<Eigen::Index>(i)] * tie.along});
  }
  return all;
}

const EnergyLedger& RigidWorld::ledger() const { return state_->ledger; }

void RigidWorld::book(double EnergyLedger::*entry, double joules) {
  state_->ledger.*entry += joules;
  state_->ledger.work_j += joules;
  state_->book();
}

std::optional<RigidWorld::Overlap> RigidWorld::overlap(double tolerance_m) const {
  State& s = *state_;
  std::optional<Overlap> deepest;
  for (const Contact& c : s.finder().bodies(s.bodies, 0.0)) {
    const double depth_m = -c.gap / s.length;
    if (depth_m > tolerance_m && (!deepest || depth_m > deepest->depth_m)) deepest = Overlap{c.a, c.b, depth_m};
  }
  return deepest;
}

}  // namespace klang::rigid
