#include "core/sound/scene/scene_modal.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/scene/detail/held_damping.hpp"
#include "core/sound/scene/detail/held_nodes.hpp"
#include "core/sound/scene/detail/modal_body.hpp"
#include "core/sound/scene/detail/modal_contacts.hpp"
#include "core/sound/scene/detail/rigid_push.hpp"
#include "core/sound/scene/detail/shape_keeper.hpp"
#include "core/sound/scene/detail/strangers.hpp"
#include "core/sound/scene/scene_cracking.hpp"

namespace klang::scene {

using detail::ModalBody;
using detail::PressedBody;

namespace {

constexpr double kFarOff = 3.0;  ///< of a body's reach
constexpr double kLongEnough =
    1.6;  ///< periods of the highest mode in a touch of a ball: Zener's restitution within 5 %
constexpr double kMostGiven = 1e-9;  ///< of the energy: what touches may give unsaid

/// Joints of the scene between places of its modal bodies: of the first its nearest corner, of the other what lies there.
std::vector<detail::JointPlace> joints_of(const Scene& scene, const std::vector<ModalBody>& bodies) {
  std::vector<detail::JointPlace> joints;
  const auto number_of = [&](int row) {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (bodies[i].row == row) return static_cast<int>(i);
    return -1;
  };
  for (const SceneJoint& joint : scene.joints) {
    detail::JointPlace made;
    made.body = number_of(joint.body);
    const ModalBody& body = bodies[static_cast<std::size_t>(made.body)];
    double least_m = HUGE_VAL;
    for (const detail::ModalPlace& place : body.places)
      if (const double far = (place.rest_m + body.rest_centre_m - joint.at_m).norm(); far < least_m) {
        least_m = far;
        made.place = place;
      }
    detail::require_near(joint, least_m, (body.high_m - body.low_m).norm());
    made.world_m = body.centre_m + body.arm(made.place);
    made.other = number_of(joint.other);
    if (made.other >= 0) {
      const ModalBody& other = bodies[static_cast<std::size_t>(made.other)];
      const Eigen::Vector3d own = other.turn.conjugate() * (made.world_m - other.centre_m);
      Eigen::Vector3d normal;
      made.other_place = other.nearest(own, normal);
      if (const double far = (made.other_place.rest_m - own).norm(); !(far <= 0.1 * other.reach_m))
        throw InputError(joint.place, "is away from the other body", to_text(far) + " m", "a place where both are");
      made.other_place.rest_m = own;
    }
    joints.push_back(std::move(made));
  }
  return joints;
}

/// Says where holds keep more than a fifth of a body's elastic motions still: what is left is stiffer than the body.
void warn_of_stiff_holds(const ModalBody& body, const SceneBody& scene_body, const SceneNotes& notes) {
  const Eigen::Index n_modes = body.modes.z.size();
  if (body.held.size() < 2 || n_modes == 0 || !notes.warning) return;
  Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(body.held.size()), 6 + n_modes);
  const Eigen::Matrix3d turning = body.inertia.inverse().llt().matrixL();
  for (std::size_t i = 0; i < body.held.size(); ++i) {
    const detail::ModalPlace& place = body.held[i].place;
    Eigen::Matrix3d across;  // spin x arm
    across << 0.0, place.rest_m.z(), -place.rest_m.y(), -place.rest_m.z(), 0.0, place.rest_m.x(), place.rest_m.y(),
        -place.rest_m.x(), 0.0;
    rows.middleRows(3 * static_cast<Eigen::Index>(i), 3) << Eigen::Matrix3d::Identity() / std::sqrt(body.mass_kg),
        across * turning, place.shape;
  }
  const Eigen::VectorXd mobility =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(rows.transpose() * rows, Eigen::EigenvaluesOnly).eigenvalues();
  // Slow motions of holds that move apart are there to be kept (held_basis.hpp).
  const Eigen::Index n_slow = n_modes - scene_body.modal.n_modes;
  const auto kept_still = (mobility.array() > detail::kDependentHolds * mobility.maxCoeff()).count() - 6 - n_slow;
  if (5 * kept_still > n_modes)
    notes.warning("body " + scene_body.name + ": its " + std::to_string(body.held.size()) + " held places keep " +
                  std::to_string(kept_still) + " of the motions of its " + std::to_string(n_modes) +
                  " modes still, so that it is stiffer than it should be: hold fewer places, or keep more modes");
}

/// Damping by the frequencies of the body as it is held; its own modes then have none. Null: nothing holds it, or nothing damps it.
std::unique_ptr<detail::HeldDamping> held_damping_of(const Scene& scene, ModalBody& body, int number,
                                                     const std::vector<detail::JointPlace>& joints) {
  const SceneMaterial& material = scene.material_of(scene.bodies[static_cast<std::size_t>(body.row)]);
  std::vector<detail::ModalPlace> held;
  for (const detail::HeldPlace& place : body.held) held.push_back(place.place);
  for (const detail::JointPlace& joint : joints)
    if (joint.body == number && joint.other < 0) held.push_back(joint.place);
  if (held.empty() || !material.damping || body.modes.z.size() == 0) return nullptr;
  auto damping = std::make_unique<detail::HeldDamping>(body, held, [&](double omega_rad_s) {
    return material.damping->law->decay_per_s(omega_rad_s, material.damping->parameters.data());
  });
  body.modes = modal::ModalState(body.modes.lambda(), Eigen::VectorXd::Zero(body.modes.z.size()));
  body.modes.set_step(body.dt_s);
  return damping;
}

/// Of its held places now, those that joints tie to the world last.
Eigen::VectorXd held_m_s(const ModalBody& body, std::size_t n_places) {
  Eigen::VectorXd speeds = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * n_places));
  for (std::size_t i = 0; i < body.held.size(); ++i)
    speeds.segment<3>(static_cast<Eigen::Index>(3 * i)) = body.held[i].path->velocity_m_s(body.time_s);
  return speeds;
}

/// @throws NumericalError where what was computed is no motion of that body any more
void check_sane(const ModalBody& body, const Scene& scene) {
  double held_m = 0.0;
  for (const detail::HeldPlace& held : body.held)
    held_m = std::max(held_m, (held.origin_m + held.path->displacement_m(body.time_s) - body.centre_m).norm());
  const double bent_m = body.bent_m();
  if (held_m <= kFarOff * body.reach_m && bent_m <= kFarOff * body.reach_m && body.centre_m.allFinite()) return;
  throw NumericalError("body " + scene.bodies[static_cast<std::size_t>(body.row)].name + " at " + to_text(body.time_s) +
                       " s: it is " + to_text(held_m) + " m from where it is held and its modes bend it by up to " +
                       to_text(bent_m) + " m, with " + to_text(body.reach_m) +
                       " m from its middle to its farthest corner: linear modes do not bend so far, or holds ask of "
                       "them what they cannot do");
}

/// How rows of small steps are heard. Steps of one force follow one another: what lasts longer than the slowest mode that is bent bends it along, and
/// that much is not heard (PulseShape::kHeld). A shock is no such force, nor is what is over before a mode has swung once: those are pulses as
/// short as the step, as Hertz' are of rigid bodies. As held forces they would leave their own shape in whatever sample they fall into.
void shape_steps(std::vector<events::Impulse>& rows, const std::map<int, double>& period_s_of) {
  std::map<std::pair<int, int>, std::vector<events::Impulse*>> pairs;
  for (events::Impulse& row : rows) pairs[{row.body, row.other}].push_back(&row);
  for (auto& [pair, own] : pairs) {
    std::stable_sort(own.begin(), own.end(), [](const auto* a, const auto* b) { return a->time_s < b->time_s; });
    double period_s = 0.0;
    for (const int body : {pair.first, pair.second})
      if (const auto found = period_s_of.find(body); found != period_s_of.end())
        period_s = std::max(period_s, found->second);
    for (std::size_t first = 0, last = 0; first < own.size(); first = last) {
      double end_s = own[first]->time_s + own[first]->duration_s;
      for (last = first; last < own.size() && own[last]->time_s <= end_s + 0.1 * own[last]->duration_s; ++last)
        end_s = std::max(end_s, own[last]->time_s + own[last]->duration_s);
      const bool is_short = end_s - own[first]->time_s < period_s;
      for (std::size_t k = first; k < last; ++k) {
        events::Impulse& row = *own[k];
        if (!is_short && row.kind != events::ImpulseKind::kImpact) continue;
        row.shape = events::PulseShape::kGaussian;
        row.time_s += 0.5 * row.duration_s;
        row.duration_s /= std::sqrt(12.0);  // as wide as the step
      }
    }
  }
}

}  // namespace

struct ModalBodies::State {
  const Scene& scene;
  const SceneNotes& notes;
  std::vector<ModalBody> bodies;
  std::vector<std::unique_ptr<detail::HeldDamping>> held_damping;  ///< of bodies; null: free ones, and without damping
  std::vector<rigid::EnergyLedger> rows;
  std::unique_ptr<detail::ModalContacts> contacts;
  std::vector<PressedBody> others;
  std::vector<detail::ShapeKeeper> shapes;  ///< of bodies
  double small_step_s = 0.0, next_step_s = 0.0;

  void add_row(double time_s) {
    rigid::EnergyLedger row;
    row.time_s = time_s;
    for (const ModalBody& body : bodies) {
      const double ahead_j = body.ahead_j();
      row.kinetic_j += body.moving_j() - ahead_j;
      (body.held.empty() ? row.correction_j : row.work_j) += body.held.empty() ? ahead_j : -ahead_j;
      row.strain_j += body.strain_j();
      row.potential_j -= body.mass_kg * scene.solver.gravity_m_s2.dot(body.centre_m);
      row.viscous_j += body.ledger.viscous_j;
      row.contact_j += body.ledger.contact_j;
      row.friction_j += body.ledger.friction_j;
      row.correction_j += body.ledger.correction_j;
      row.work_j += body.ledger.work_j;
    }
    if (contacts) {
      row.strain_j += contacts->ball_springs_j();
      row.kinetic_j -= contacts->ahead_rigid_j();
      row.correction_j += contacts->ahead_rigid_j();
    }
    row.work_j += rows.empty() ? row.sum_j() : rows.front().work_j;
    row.residual_j = row.sum_j();
    rows.push_back(row);
  }
};

ModalBodies::ModalBodies(const Scene& scene, rigid::RigidWorld& world, const SceneNotes& notes, Monitor& monitor)
    : state_(std::make_unique<State>(State{scene, notes, {}, {}, {}, {}, {}, {}, 0.0, 0.0})) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].model != BodyModel::kModal) continue;
    const int row = static_cast<int>(i);
    state_->bodies.push_back(detail::modal_body_of(scene, row, world.spec(row), notes, monitor));
    world.remove(row);
  }
  if (!any()) return;
  // One small step for all: that of the highest mode.
  double least_s = HUGE_VAL;
  for (const ModalBody& body : state_->bodies) least_s = std::min(least_s, body.dt_s);
  state_->small_step_s = state_->next_step_s = least_s;
  for (ModalBody& body : state_->bodies) {
    body.dt_s = least_s;
    body.modes.set_step(least_s);
    warn_of_stiff_holds(body, scene.bodies[static_cast<std::size_t>(body.row)], notes);
  }
  for (int i = 0; i < world.n_bodies(); ++i)
    if (world.is_there(i)) state_->others.emplace_back(world, i, PressedBody::Way::kStruck);
  std::vector<detail::JointPlace> joints = joints_of(scene, state_->bodies);
  for (std::size_t i = 0; i < state_->bodies.size(); ++i)
    state_->held_damping.push_back(held_damping_of(scene, state_->bodies[i], static_cast<int>(i), joints));
  state_->contacts = std::make_unique<detail::ModalContacts>(scene, state_->bodies, std::move(joints));
  state_->add_row(world.time_s());
  for (const ModalBody& body : state_->bodies) {
    const bool kept = scene.frames.wanted() && body.modes.z.size() > 0;
    state_->shapes.emplace_back(body.row, kept ? scene.frames.rate_hz : 0.0).keep(body, world.time_s());
  }
}
ModalBodies::~ModalBodies() = default;

bool ModalBodies::any() const { return !state_->bodies.empty(); }

void ModalBodies::after_step(rigid::RigidWorld& world) {
  if (!any()) return;
  State& s = *state_;
  auto& others = s.others;
  others.erase(std::remove_if(others.begin(), others.end(),
                              [&](const PressedBody& body) { return !world.is_there(body.body()); }),
               others.end());
  for (int i = others.empty() ? 0 : others.back().body() + 1; i < world.n_bodies(); ++i)
    if (world.is_there(i)) others.emplace_back(world, i, PressedBody::Way::kStruck);  // pieces that are new
  const double start_s = s.bodies.front().time_s, step_s = world.time_s() - start_s;
  const Eigen::Vector3d gravity = s.scene.solver.gravity_m_s2;
  for (PressedBody& other : others) other.begin(world, step_s, gravity);
  const auto n = std::lround(step_s / s.small_step_s);
  std::vector<std::size_t> touches;
  for (const ModalBody& body : s.bodies) touches.push_back(body.touches.size());
  for (long k = 0, part = 0; k < n;) {
    const double dt_s = s.next_step_s;
    const bool ends = ++part == std::lround(s.small_step_s / dt_s);
    if (ends) ++k, part = 0;
    s.contacts->press_balls(others, 0.5 * dt_s, false);
    for (ModalBody& body : s.bodies) {
      body.dt_s = dt_s;
      body.fly(dt_s, gravity);
      body.time_s = k == n ? world.time_s()
                           : start_s + static_cast<double>(k) * s.small_step_s + static_cast<double>(part) * dt_s;
    }
    for (std::size_t i = 0; i < s.bodies.size(); ++i)
      if (s.held_damping[i])
        s.held_damping[i]->apply(s.bodies[i], dt_s, held_m_s(s.bodies[i], s.held_damping[i]->n_places()));
    for (PressedBody& other : others) other.advance(dt_s);
    s.contacts->press_balls(others, 0.5 * dt_s, true);
    s.next_step_s = s.contacts->solve(others, s.small_step_s, ends);
    for (std::size_t i = 0; i < s.bodies.size(); ++i) s.shapes[i].keep(s.bodies[i], s.bodies[i].time_s);
  }
  for (PressedBody& other : others)
    if (const double got_j = other.end(world); got_j != 0.0) world.book(&rigid::EnergyLedger::contact_j, -got_j);
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    ModalBody& body = s.bodies[i];
    body.turn_touches(touches[i]);
    if (body.touches.size() > touches[i] ||
        world.time_s() >= body.poses.back().time_s + 1.0 / s.scene.pose_rate_hz - 1e-12)
      body.keep_pose();
  }
  std::vector<detail::ShapeKeeper*> keepers;
  for (detail::ShapeKeeper& keeper : s.shapes) keepers.push_back(&keeper);
  detail::thin_to(s.scene.frames.most_shape_bytes, keepers);
  for (const ModalBody& body : s.bodies) check_sane(body, s.scene);
  s.add_row(world.time_s());
}

void ModalBodies::refuse_meeting(const CrackingBodies& cracking) const {
  if (!any()) return;
  for (const auto& [row, mesh] : cracking.meshes())
    for (const ModalBody& body : state_->bodies)
      if (detail::meet(body, *mesh))
        throw NumericalError("bodies " + state_->scene.bodies[static_cast<std::size_t>(body.row)].name + " and " +
                             state_->scene.bodies[static_cast<std::size_t>(row)].name + " meet at " +
                             to_text(body.time_s) +
                             " s: modal and cracking bodies do not feel one another, so that they would pass through");
}

void ModalBodies::warn_of_gain() const {
  const double given_j = state_->contacts->given_j();
  double most_j = 0.0;
  for (const rigid::EnergyLedger& row : state_->rows) most_j = std::max(most_j, row.kinetic_j + row.strain_j);
  if (state_->notes.warning && given_j > kMostGiven * most_j)
    state_->notes.warning("touches of modal bodies push bodies that part and give them " + to_text(given_j) +
                          " J (erratum 71: what contact = \"lp\" does)");
}

void ModalBodies::warn_of_short_touches() const {
  const auto [periods, number] = state_->contacts->shortest_touch();
  if (number < 0 || periods >= kLongEnough || !state_->notes.warning) return;
  const ModalBody& body = state_->bodies[static_cast<std::size_t>(number)];
  const double highest_hz = std::sqrt(body.modes.lambda().maxCoeff()) / (2.0 * kPi);
  state_->notes.warning("body " + state_->scene.bodies[static_cast<std::size_t>(body.row)].name +
                        ": a ball touches it for " + to_text(std::round(1e6 * periods / highest_hz)) +
                        " us, and its modes end at " + to_text(std::round(highest_hz)) +
                        " Hz: how the ball rebounds takes modes up to " +
                        to_text(std::round(kLongEnough * highest_hz / periods)) + " Hz (n_modes)");
}

void ModalBodies::add_to(SceneMotion& motion) const {
  add_ledger(motion, state_->rows);
  motion.contact_residual = 0.0;
  motion.joint_error_m = state_->contacts->joint_error_m();
  warn_of_gain();
  warn_of_short_touches();
  for (const detail::ShapeKeeper& keeper : state_->shapes)
    if (keeper.n_frames() > 0) motion.shapes.bodies.push_back(keeper.shapes({keeper.row()}));
  if (const int stride = state_->shapes.front().stride(); stride > 1 && state_->notes.warning)
    state_->notes.warning(detail::words_of_thinning("modal", stride, state_->scene.frames.most_shape_bytes));
  std::vector<events::Impulse> rows = state_->contacts->on_rigid();
  std::map<int, double> period_s_of;
  for (const ModalBody& body : state_->bodies) {
    if (body.modes.z.size() > 0) period_s_of[body.row] = 2.0 * kPi / std::sqrt(body.modes.lambda().minCoeff());
    motion.contact_residual = std::max(*motion.contact_residual, body.residual);
    FinalState& end = motion.final[static_cast<std::size_t>(body.row)];
    end.position_m = body.centre_m;
    end.orientation_wxyz = {body.turn.w(), body.turn.x(), body.turn.y(), body.turn.z()};  // the last pose may be older
    end.velocity_m_s = body.velocity_m_s - body.ahead_m_s;
    end.angular_velocity_rad_s = body.inverse_inertia() * (body.angular_momentum - body.ahead_momentum);
    motion.log.poses.insert(motion.log.poses.end(), body.poses.begin(), body.poses.end());
    for (const detail::ModalTouch& touch : body.touches) {
      events::Impulse impulse;
      impulse.time_s = touch.span.begin_s;
      impulse.duration_s = touch.span.duration_s;
      impulse.shape = events::PulseShape::kHeld;
      impulse.kind = touch.is_new ? events::ImpulseKind::kImpact : events::ImpulseKind::kLasting;
      impulse.body = body.row;
      impulse.other = touch.other;
      impulse.point_m = touch.point_m;
      impulse.impulse_n_s = touch.impulse_n_s;
      rows.push_back(impulse);
    }
  }
  shape_steps(rows, period_s_of);
  motion.log.impulses.insert(motion.log.impulses.end(), rows.begin(), rows.end());
  motion.log.sort();
}

}  // namespace klang::scene
