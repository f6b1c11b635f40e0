#include "core/sound/scene/scene_modal.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/modal/constraints/contact_problem.hpp"
#include "core/physics/modal/constraints/modal_step.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::scene {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kHighestModeHz = 1e7;
constexpr int kMostSubsteps = 500;
constexpr std::array<int, 3> kAxes = {2, 0, 1};  // of a contact: its normal, then along the floor
constexpr std::size_t kMostFlexiblePlaces = 700;

std::size_t index(Eigen::Index i) { return static_cast<std::size_t>(i); }

/// A place of a modal body: in the frame of the centre of mass, with its rows of the modes.
struct ModalPlace {
  Vector3d rest_m;
  Eigen::Matrix3Xd shape;
};

struct HeldPlace {
  ModalPlace place;
  const fracture::HoldPath* path = nullptr;
  Vector3d origin_m;  ///< in the world, at the start
};

struct Touch {
  double time_s = 0.0, duration_s = 0.0;
  std::size_t place = 0;
  bool is_new = false;
  Vector3d impulse_n_s;
};

/// One modal body.
struct ModalBody {
  int row = 0;
  double mass_kg = 0.0, restitution = 0.0, friction = 0.0, dt_s = 0.0, time_s = 0.0, residual = 0.0;
  bool linear_program = false;
  Vector3d rest_centre_m, centre_m, velocity_m_s, angular_momentum;
  Matrix3d inertia;
  Eigen::Quaterniond turn;
  modal::ModalState modes{Eigen::VectorXd(), Eigen::VectorXd()};
  std::vector<ModalPlace> places;    ///< corners of the surface
  Eigen::MatrixXd residual_m_per_n;  ///< of the discarded modes between places, body's frame; empty: they are stiff
  double spring_j = 0.0;             ///< in the discarded modes
  std::vector<HeldPlace> held;
  std::vector<char> was_down;
  rigid::EnergyLedger ledger;  ///< losses alone
  std::vector<Touch> touches;
  std::vector<events::Pose> poses;

  Matrix3d inverse_inertia() const {
    const Matrix3d r = turn.toRotationMatrix();
    return r * inertia.inverse() * r.transpose();
  }
  Vector3d spin() const { return inverse_inertia() * angular_momentum; }
  double moving_j() const {
    return 0.5 * mass_kg * velocity_m_s.squaredNorm() + 0.5 * angular_momentum.dot(spin()) +
           0.5 * modes.v.squaredNorm();
  }
  double strain_j() const { return 0.5 * modes.z.dot(modes.lambda().cwiseProduct(modes.z)) + spring_j; }
  Eigen::MatrixXd flexibility(const std::vector<std::size_t>& down) const;
  Eigen::MatrixXd rows_of(const std::vector<std::size_t>& down, Eigen::Index per) const;
  Vector3d arm(const ModalPlace& p) const { return turn * (p.rest_m + p.shape * modes.z); }
  void aim(Eigen::VectorXd& b, const Vector3d& gravity) const;
  void fly(double dt, const Vector3d& gravity);
  void push(bool has_floor, const Vector3d& gravity);
  void keep_pose();
};

void ModalBody::fly(double dt, const Vector3d& gravity) {
  centre_m += dt * velocity_m_s + 0.5 * dt * dt * gravity;
  velocity_m_s += dt * gravity;
  const double turning = 0.5 * angular_momentum.dot(spin());
  const auto turned = [&](const Eigen::Quaterniond& from, const Vector3d& by) {
    const double angle = by.norm();
    if (!(angle > 0.0)) return from;
    return (Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle)) * from).normalized();
  };
  const Eigen::Quaterniond start = turn;
  turn = turned(start, 0.5 * dt * spin());
  turn = turned(start, dt * spin());
  ledger.correction_j += turning - 0.5 * angular_momentum.dot(spin());
  if (modes.z.size() == 0) return;
  modes.set_step(dt);
  const double before = modes.energy_j();
  modes.advance(Eigen::VectorXd::Zero(modes.z.size()));
  ledger.viscous_j += before - modes.energy_j();
}

/// Of the discarded modes along the floor's normal, between places that are down.
Eigen::MatrixXd ModalBody::flexibility(const std::vector<std::size_t>& down) const {
  const Vector3d up = turn.conjugate() * Vector3d::UnitZ();
  Eigen::MatrixXd c(down.size(), down.size());
  for (std::size_t i = 0; i < down.size(); ++i)
    for (std::size_t j = 0; j < down.size(); ++j)
      c(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = up.dot(
          residual_m_per_n.block<3, 3>(3 * static_cast<Eigen::Index>(down[i]), 3 * static_cast<Eigen::Index>(down[j])) *
          up);
  return c;
}

/// Speeds of places over those of the centre, the spin and the modes: held places along x, y, z; then places that are down along
/// kAxes.
Eigen::MatrixXd ModalBody::rows_of(const std::vector<std::size_t>& down, Eigen::Index per) const {
  const Eigen::Index n_held = static_cast<Eigen::Index>(3 * held.size()), n_modes = modes.z.size(),
                     n = n_held + per * static_cast<Eigen::Index>(down.size());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n, 6 + n_modes);
  const Matrix3d r = turn.toRotationMatrix();
  const auto set = [&](Eigen::Index row, const ModalPlace& place, const Vector3d& along) {
    rows.block<1, 3>(row, 0) = along.transpose();
    rows.block<1, 3>(row, 3) = arm(place).cross(along).transpose();
    if (n_modes > 0) rows.block(row, 6, 1, n_modes) = (r.transpose() * along).transpose() * place.shape;
  };
  for (std::size_t h = 0; h < held.size(); ++h)
    for (int axis = 0; axis < 3; ++axis)
      set(static_cast<Eigen::Index>(3 * h) + axis, held[h].place, Vector3d::Unit(axis));
  for (std::size_t k = 0; k < down.size(); ++k)
    for (Eigen::Index a = 0; a < per; ++a)
      set(n_held + per * static_cast<Eigen::Index>(k) + a, places[down[k]], Vector3d::Unit(kAxes[index(a)]));
  return rows;
}

/// Takes from the speeds of held places those that bring them to their paths at the end of the next small step.
void ModalBody::aim(Eigen::VectorXd& b, const Vector3d& gravity) const {
  for (std::size_t h = 0; h < held.size(); ++h) {
    const HeldPlace& hold = held[h];
    const Vector3d wanted =
        (hold.origin_m + hold.path->displacement_m(time_s + dt_s) - centre_m - arm(hold.place)) / dt_s -
        0.5 * dt_s * gravity;
    b.segment<3>(static_cast<Eigen::Index>(3 * h)) -= wanted;
  }
}

/// Impulses of the floor and of holds, at the end of a small step.
void ModalBody::push(bool has_floor, const Vector3d& gravity) {
  std::vector<std::size_t> down;
  std::vector<char> now(places.size(), 0);
  if (has_floor)
    for (std::size_t i = 0; i < places.size(); ++i)
      if (centre_m.z() + arm(places[i]).z() <= 0.0) {
        down.push_back(i);
        now[i] = 1;
      }
  const Eigen::Index n_held = static_cast<Eigen::Index>(3 * held.size());
  const bool slides = friction > 0.0 && !linear_program;
  const Eigen::Index per = slides ? 3 : 1, n_down = per * static_cast<Eigen::Index>(down.size());
  if (n_held + n_down == 0) {
    ledger.contact_j += spring_j;
    spring_j = 0.0;
    was_down = std::move(now);
    return;
  }
  const Eigen::Index n = n_held + n_down, n_modes = modes.z.size();
  const Eigen::MatrixXd rows = rows_of(down, per);
  Eigen::VectorXd speed(6 + n_modes);
  speed << velocity_m_s, spin(), modes.v;
  Eigen::MatrixXd mobile = rows.transpose();  // M^-1 J^T
  mobile.topRows(3) /= mass_kg;
  mobile.middleRows(3, 3) = inverse_inertia() * mobile.middleRows(3, 3).eval();
  const Eigen::MatrixXd a = rows * mobile;
  const Eigen::VectorXd before = rows * speed;
  Eigen::VectorXd b = before;
  aim(b, gravity);
  const double slow = 2.0 * gravity.norm() * dt_s;
  for (std::size_t k = 0; k < down.size(); ++k) {
    const Eigen::Index row = n_held + per * static_cast<Eigen::Index>(k);
    if (residual_m_per_n.size() > 0) {
      b[row] += (centre_m.z() + arm(places[down[k]]).z()) / dt_s;
    } else if (was_down[down[k]] == 0 && before[row] < -slow) {
      b[row] += restitution * before[row];
    }
  }
  // Holds are met whatever the contacts exert: they are taken out of the contact problem.
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> holds;
  holds.setThreshold(1e-10);
  Eigen::MatrixXd inner = a.bottomRightCorner(n_down, n_down);
  Eigen::VectorXd right = b.tail(n_down);
  Eigen::MatrixXd springs;
  if (residual_m_per_n.size() > 0 && n_down > 0) {
    springs = flexibility(down) / (dt_s * dt_s);
    for (std::size_t i = 0; i < down.size(); ++i)
      for (std::size_t j = 0; j < down.size(); ++j)
        inner(per * static_cast<Eigen::Index>(i), per * static_cast<Eigen::Index>(j)) +=
            springs(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
  }
  if (n_held > 0) {
    holds.compute(a.topLeftCorner(n_held, n_held));
    inner -= a.bottomLeftCorner(n_down, n_held) * Eigen::MatrixXd(holds.solve(a.topRightCorner(n_held, n_down)));
    right -= a.bottomLeftCorner(n_down, n_held) * Eigen::VectorXd(holds.solve(b.head(n_held)));
  }
  Eigen::VectorXd impulses = Eigen::VectorXd::Zero(n);
  if (n_down > 0) {
    const modal::ContactForces solved =
        linear_program ? modal::solve_contact_lp(inner, right)
        : slides       ? modal::solve_friction(inner, right,
                                               Eigen::VectorXd::Constant(static_cast<Eigen::Index>(down.size()), friction),
                                               20000, 1e-9)
                       : modal::solve_lcp(inner, right);
    residual = std::max(residual, solved.residual);
    impulses.tail(n_down) = solved.forces;
  }
  if (n_held > 0)
    impulses.head(n_held) = holds.solve(-b.head(n_held) - a.topRightCorner(n_held, n_down) * impulses.tail(n_down));
  const double start_j = moving_j();
  const Eigen::VectorXd gained = mobile * impulses;
  velocity_m_s += gained.head<3>();
  angular_momentum += (rows.middleCols(3, 3).transpose() * impulses);
  modes.v += gained.tail(n_modes);
  const Eigen::VectorXd mean = before + 0.5 * a * impulses;
  const double held_j = impulses.head(n_held).dot(mean.head(n_held));
  double sliding_j = 0.0;
  for (std::size_t k = 0; k < down.size(); ++k) {
    const Eigen::Index row = n_held + per * static_cast<Eigen::Index>(k);
    Vector3d impulse(0.0, 0.0, impulses[row]);
    for (Eigen::Index along = 1; along < per; ++along) {
      impulse[kAxes[index(along)]] = impulses[row + along];
      sliding_j -= impulses[row + along] * mean[row + along];
    }
    if (impulse.squaredNorm() > 0.0) touches.push_back({time_s, dt_s, down[k], was_down[down[k]] == 0, impulse});
  }
  const double spring_before_j = spring_j;
  spring_j = 0.0;
  if (springs.size() > 0) {
    Eigen::VectorXd normal(static_cast<Eigen::Index>(down.size()));
    for (Eigen::Index k = 0; k < normal.size(); ++k) normal[k] = impulses[n_held + per * k];
    spring_j = 0.5 * normal.dot(springs * normal);
  }
  ledger.contact_j += spring_before_j - spring_j;
  ledger.work_j += held_j;
  ledger.friction_j += sliding_j;
  ledger.contact_j += start_j + held_j - sliding_j - moving_j();
  was_down = std::move(now);
}

void ModalBody::keep_pose() {
  events::Pose pose;
  pose.body = row;
  pose.time_s = time_s;
  pose.position_m = centre_m - turn * rest_centre_m;
  pose.orientation_wxyz = {turn.w(), turn.x(), turn.y(), turn.z()};
  poses.push_back(pose);
}

ModalPlace place_of(const modal::ModalModel& model, Eigen::Index n_modes, int node, const Vector3d& centre_m) {
  ModalPlace place;
  place.rest_m = model.mesh.nodes_m.row(node).transpose() - centre_m;
  place.shape = model.shapes.block(3 * node, 0, 3, n_modes);
  return place;
}

/// Flexibility of all elastic modes between the surface's corners, from statics of the free body, less that of the kept ones.
Eigen::MatrixXd residual_flexibility(const ModalBody& body, const std::vector<int>& nodes, const mesh::TetMesh& mesh,
                                     const solid::Material& material) {
  if (nodes.size() > kMostFlexiblePlaces)
    throw InputError("residual_flexibility", "has too many corners of the surface", std::to_string(nodes.size()),
                     "up to " + std::to_string(kMostFlexiblePlaces) + ": a larger max_edge_m");
  fracture::FreeBodySolver solver(mesh, material);
  if (!solver.usable()) throw NumericalError("residual flexibility: " + solver.message());
  const Eigen::Index n = static_cast<Eigen::Index>(3 * nodes.size());
  Eigen::MatrixXd loads = Eigen::MatrixXd::Zero(3 * mesh.n_nodes(), n);
  std::vector<Eigen::Index> rows;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      loads(3 * nodes[i] + axis, static_cast<Eigen::Index>(3 * i) + axis) = 1.0;
      rows.push_back(3 * nodes[i] + axis);
    }
  Eigen::MatrixXd flexible = solver.solve(loads).displacement_m(rows, Eigen::all);
  Eigen::MatrixXd shapes(n, body.modes.z.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    shapes.middleRows(static_cast<Eigen::Index>(3 * i), 3) = body.places[i].shape;
  if (body.modes.z.size() > 0)
    flexible -= shapes * body.modes.lambda().cwiseInverse().asDiagonal() * shapes.transpose();
  return 0.5 * (flexible + flexible.transpose());
}

ModalBody body_of(const Scene& scene, int row, const rigid::RigidBodySpec& spec, const SceneNotes& notes,
                  Monitor& monitor) {
  const SceneBody& body = scene.bodies[static_cast<std::size_t>(row)];
  const SceneMaterial& material = scene.material_of(body);
  ModalBody made;
  made.row = row;
  modal::ModalModel model;
  model.mesh = mesh_of(body, notes, monitor);
  model.shapes = Eigen::MatrixXd(3 * model.mesh.n_nodes(), 0);
  if (body.modal.n_modes > 0) {
    modal::ModesBody what;
    what.shape = body.shape;
    modal::ModesOptions options;
    options.eigen.band = {0.0, kHighestModeHz};
    options.eigen.most = body.modal.n_modes;
    options.mesh_is_wanted = body.max_edge_m > 0.0 && body.shape;
    modal::EigenResult found = modal::modes_of(what, model.mesh, material.elastic, options, monitor);
    if (!found.usable()) throw NumericalError("modes of " + body.name + ": " + found.message);
    if (found.model.n_modes() < body.modal.n_modes)
      throw InputError(body.place, "has fewer modes than n_modes", std::to_string(found.model.n_modes()));
    model = std::move(found.model);
  }
  const Eigen::Index n_modes = body.modal.n_modes;
  Eigen::VectorXd lambda(n_modes), damping(n_modes);
  for (Eigen::Index k = 0; k < n_modes; ++k) {
    const double omega = model.angular_frequency_rad_s[k];
    lambda[k] = omega * omega;
    damping[k] =
        material.damping ? 2.0 * material.damping->law->decay_per_s(omega, material.damping->parameters.data()) : 0.0;
  }
  made.modes = modal::ModalState(lambda, damping);
  made.mass_kg = spec.mass_kg;
  made.inertia = spec.inertia_kg_m2;
  made.rest_centre_m = spec.centre_m;
  made.turn = spec.orientation;
  made.centre_m = spec.position_m + spec.orientation * spec.centre_m;
  made.velocity_m_s = spec.velocity_m_s;
  const Matrix3d r = spec.orientation.toRotationMatrix();
  made.angular_momentum = r * spec.inertia_kg_m2 * r.transpose() * spec.angular_velocity_rad_s;
  if (scene.solver.floor) {
    made.restitution = rigid::pair_restitution(spec.skin, *scene.solver.floor);
    made.friction = rigid::pair_friction(spec.skin, *scene.solver.floor);
  }
  made.linear_program = body.modal.linear_program;
  std::vector<bool> corner(static_cast<std::size_t>(model.mesh.n_nodes()), false);
  const mesh::SurfaceMesh surface = mesh::boundary_surface(model.mesh);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) corner[static_cast<std::size_t>(surface.triangles(t, c))] = true;
  std::vector<int> corners;
  for (int i = 0; i < model.mesh.n_nodes(); ++i)
    if (corner[static_cast<std::size_t>(i)]) {
      made.places.push_back(place_of(model, n_modes, i, spec.centre_m));
      corners.push_back(i);
    }
  if (body.modal.residual_flexibility)
    made.residual_m_per_n =
        located(body.place, [&] { return residual_flexibility(made, corners, model.mesh, material.elastic); });
  made.was_down.assign(made.places.size(), 0);
  for (const SceneHold& hold : scene.holds) {
    if (hold.body != row) continue;
    std::vector<int> nodes;
    if (hold.at_m) {
      Eigen::Index nearest = 0;
      (model.mesh.nodes_m.rowwise() - hold.at_m->transpose()).rowwise().norm().minCoeff(&nearest);
      nodes = {static_cast<int>(nearest)};
    } else {
      nodes = located(hold.place,
                      [&] { return solid::held_nodes(solid::parse_support("clamped:" + hold.where), model.mesh); });
    }
    for (const int node : nodes) {
      HeldPlace held{place_of(model, n_modes, node, spec.centre_m), &hold.path, Vector3d::Zero()};
      held.origin_m = made.centre_m + made.arm(held.place);
      for (const HeldPlace& other : made.held)
        if (other.place.rest_m == held.place.rest_m)
          throw InputError(hold.place, "contradicts another hold of the same place", body.name);
      made.held.push_back(std::move(held));
    }
  }
  const double highest_hz = n_modes > 0 ? std::sqrt(lambda.maxCoeff()) / (2.0 * kPi) : 0.0;
  const double step_s = 1.0 / scene.solver.rate_hz;
  made.dt_s = step_s / std::clamp(std::ceil(step_s * 20.0 * highest_hz), 1.0, static_cast<double>(kMostSubsteps));
  made.keep_pose();
  return made;
}

}  // namespace

struct ModalBodies::State {
  const Scene& scene;
  std::vector<ModalBody> bodies;
  std::vector<rigid::EnergyLedger> rows;

  void add_row(double time_s) {
    rigid::EnergyLedger row;
    row.time_s = time_s;
    for (const ModalBody& body : bodies) {
      row.kinetic_j += body.moving_j();
      row.strain_j += body.strain_j();
      row.potential_j -= body.mass_kg * scene.solver.gravity_m_s2.dot(body.centre_m);
      row.viscous_j += body.ledger.viscous_j;
      row.contact_j += body.ledger.contact_j;
      row.friction_j += body.ledger.friction_j;
      row.correction_j += body.ledger.correction_j;
      row.work_j += body.ledger.work_j;
    }
    row.work_j += rows.empty() ? row.sum_j() : rows.front().work_j;
    row.residual_j = row.sum_j();
    rows.push_back(row);
  }
};

ModalBodies::ModalBodies(const Scene& scene, rigid::RigidWorld& world, const SceneNotes& notes, Monitor& monitor)
    : state_(std::make_unique<State>(State{scene, {}, {}})) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].model != BodyModel::kModal) continue;
    const int row = static_cast<int>(i);
    state_->bodies.push_back(body_of(scene, row, world.spec(row), notes, monitor));
    world.remove(row);
  }
  if (!any()) return;
  if (scene.bodies.size() > 1 && notes.warning) notes.warning("modal bodies feel the floor and holds, no other bodies");
  state_->add_row(world.time_s());
}
ModalBodies::~ModalBodies() = default;

bool ModalBodies::any() const { return !state_->bodies.empty(); }

void ModalBodies::after_step(const rigid::RigidWorld& world) {
  if (!any()) return;
  const Scene& scene = state_->scene;
  for (ModalBody& body : state_->bodies) {
    const std::size_t touches = body.touches.size();
    const auto n = std::lround((world.time_s() - body.time_s) / body.dt_s);
    const double start_s = body.time_s;
    for (long k = 0; k < n; ++k) {
      body.fly(body.dt_s, scene.solver.gravity_m_s2);
      body.time_s = k + 1 == n ? world.time_s() : start_s + static_cast<double>(k + 1) * body.dt_s;
      body.push(scene.solver.floor.has_value(), scene.solver.gravity_m_s2);
    }
    if (body.touches.size() > touches || world.time_s() >= body.poses.back().time_s + 1.0 / scene.pose_rate_hz - 1e-12)
      body.keep_pose();
  }
  state_->add_row(world.time_s());
}

void ModalBodies::add_to(SceneMotion& motion) const {
  add_ledger(motion, state_->rows);
  motion.contact_residual = 0.0;
  for (const ModalBody& body : state_->bodies) {
    motion.contact_residual = std::max(*motion.contact_residual, body.residual);
    FinalState& end = motion.final[static_cast<std::size_t>(body.row)];
    end.position_m = body.centre_m;
    end.orientation_wxyz = body.poses.back().orientation_wxyz;
    end.velocity_m_s = body.velocity_m_s;
    end.angular_velocity_rad_s = body.spin();
    motion.log.poses.insert(motion.log.poses.end(), body.poses.begin(), body.poses.end());
    for (const Touch& touch : body.touches) {
      const auto pose = std::lower_bound(body.poses.begin(), body.poses.end(), touch.time_s - 1e-12,
                                         [](const events::Pose& p, double t) { return p.time_s < t; });
      events::Impulse impulse;
      impulse.time_s = touch.time_s - touch.duration_s;
      impulse.duration_s = touch.duration_s;
      impulse.shape = events::PulseShape::kHeld;
      impulse.kind = touch.is_new ? events::ImpulseKind::kImpact : events::ImpulseKind::kLasting;
      impulse.body = body.row;
      impulse.point_m = body.rest_centre_m + body.places[touch.place].rest_m;
      impulse.impulse_n_s =
          (pose == body.poses.end() ? body.poses.back() : *pose).orientation().conjugate() * touch.impulse_n_s;
      motion.log.impulses.push_back(impulse);
    }
  }
  motion.log.sort();
}

}  // namespace klang::scene
