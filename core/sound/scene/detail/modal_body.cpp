#include "core/sound/scene/detail/modal_body.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/hanging_nodes.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/rigid/convex_parts.hpp"
#include "core/sound/scene/detail/held_basis.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kMostSubsteps = 500;

ModalPlace place_of(const modal::ModalModel& model, Eigen::Index n_modes, int node, const Vector3d& centre_m) {
  ModalPlace place;
  place.rest_m = model.mesh.nodes_m.row(node).transpose() - centre_m;
  place.shape = model.shapes.block(3 * node, 0, 3, n_modes);
  return place;
}

constexpr double kMeshErrorToSay = 0.04;

/// Elastic motions of a body.
struct Elastic {
  modal::ModalModel model;  ///< as meshed
  Eigen::VectorXd lambda;   ///< without what the mesh adds, by its estimate
};

void warn_of_mesh(const SceneBody& body, const std::optional<Eigen::VectorXd>& error, const SceneNotes& notes) {
  if (!notes.warning || !error || error->size() == 0 || !(error->maxCoeff() > kMeshErrorToSay)) return;
  const auto percent = [](double share) { return std::to_string(std::lround(100.0 * share)) + " %"; };
  notes.warning("body " + body.name + ": its mesh makes modes that it moves by too high, by up to " +
                percent(error->maxCoeff()) + " and by " + percent(error->mean()) + " in the mean, by its estimate" +
                "; that is taken off their frequencies, not off their shapes");
}

Elastic elastic_of(const Scene& scene, int row, const SceneNotes& notes, Monitor& monitor) {
  const SceneBody& body = scene.bodies[static_cast<std::size_t>(row)];
  Elastic elastic;
  modal::ModalModel& model = elastic.model;
  model.mesh = mesh_of(body, notes, monitor);
  model.shapes = Eigen::MatrixXd(3 * model.mesh.n_nodes(), 0);
  if (body.modal.n_modes == 0) return elastic;
  const std::vector<HeldNodes> holds = held_nodes_of(scene, row, model.mesh);
  const solid::Material& material = scene.material_of(body).elastic;
  if (holds_a_face(holds, model.mesh)) {
    HeldBasis basis =
        located(body.place, [&] { return held_basis(model.mesh, material, holds, body.modal.n_modes, true, monitor); });
    warn_of_mesh(body, basis.mesh_error, notes);
    elastic.lambda = std::move(basis.lambda);
    model.angular_frequency_rad_s = elastic.lambda.cwiseSqrt();
    model.shapes = std::move(basis.shapes);
    return elastic;
  }
  modal::ModesBody what;
  what.shape = body.shape;
  modal::ModesOptions options;
  options.eigen.count = body.modal.n_modes;
  options.eigen.estimate_mesh_error = true;
  options.mesh_is_wanted = body.max_edge_m > 0.0 && body.shape;
  modal::EigenResult found =
      located(body.place, [&] { return modal::modes_of(what, model.mesh, material, options, monitor); });
  if (!found.usable()) throw NumericalError("modes of " + body.name + ": " + found.message);
  if (found.model.n_modes() < body.modal.n_modes)
    throw InputError(body.place, "has fewer modes than n_modes", std::to_string(found.model.n_modes()));
  Eigen::VectorXd omega = found.model.angular_frequency_rad_s;
  warn_of_mesh(body, found.mesh_relative_error, notes);
  if (found.mesh_relative_error) omega.array() /= 1.0 + found.mesh_relative_error->array();
  elastic.lambda = omega.cwiseAbs2();
  elastic.model = std::move(found.model);
  return elastic;
}

void add_surface(ModalBody& made, const modal::ModalModel& model, const rigid::RigidBodySpec& spec) {
  const Eigen::Index n_modes = made.modes.z.size();
  made.surface = mesh::boundary_surface(model.mesh);
  made.surface.vertices_m.rowwise() -= spec.centre_m.transpose();
  made.surface_shapes = model.shapes.leftCols(n_modes);
  std::vector<bool> is_corner(static_cast<std::size_t>(model.mesh.n_nodes()), false);
  for (Eigen::Index t = 0; t < made.surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) is_corner[static_cast<std::size_t>(made.surface.triangles(t, c))] = true;
  for (int i = 0; i < model.mesh.n_nodes(); ++i) {
    if (!is_corner[static_cast<std::size_t>(i)]) continue;
    made.places.push_back(place_of(model, n_modes, i, spec.centre_m));
    made.places.back().nodes = {{i, 1.0}};
  }
  made.corner_shapes.resize(static_cast<Eigen::Index>(3 * made.places.size()), n_modes);
  made.low_m = made.high_m = made.places.front().rest_m;
  for (std::size_t i = 0; i < made.places.size(); ++i) {
    made.corner_shapes.middleRows(static_cast<Eigen::Index>(3 * i), 3) = made.places[i].shape;
    made.low_m = made.low_m.cwiseMin(made.places[i].rest_m);
    made.high_m = made.high_m.cwiseMax(made.places[i].rest_m);
    made.reach_m = std::max(made.reach_m, made.places[i].rest_m.norm());
  }
  made.groups = corner_groups(made.places);
  made.surface_groups = SurfaceGroups(made.surface);
  for (const rigid::ConvexPart& part : spec.parts) {
    const mesh::SurfaceMesh hull = rigid::hull_of(part);
    std::vector<Eigen::Vector4d> planes;
    for (Eigen::Index t = 0; t < hull.triangles.rows(); ++t) {
      const auto corner = [&](int c) -> Vector3d {
        return hull.vertices_m.row(hull.triangles(t, c)).transpose() - spec.centre_m;
      };
      const Vector3d across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
      if (!(across.norm() > 0.0)) continue;
      const Vector3d normal = across.normalized();
      planes.emplace_back(normal.x(), normal.y(), normal.z(), normal.dot(corner(0)));
    }
    made.parts.push_back(std::move(planes));
  }
}

void add_holds(ModalBody& made, const Scene& scene, const modal::ModalModel& model, const Vector3d& centre_m) {
  const std::vector<HeldNodes> holds = held_nodes_of(scene, made.row, model.mesh);
  const bool rigid = holds_a_face(holds, model.mesh);
  for (const HeldNodes& hold : holds) {
    fracture::HoldPath from_its_speed = hold.hold->path;
    const ModalPlace first = place_of(model, made.modes.z.size(), hold.nodes.front(), centre_m);
    from_its_speed.set_start_velocity(made.velocity_m_s + made.spin().cross(made.arm(first)));
    const auto path = std::make_shared<const fracture::HoldPath>(std::move(from_its_speed));
    for (const int node : rigid ? three_apart(hold.nodes, model.mesh) : hold.nodes) {
      HeldPlace held{place_of(model, made.modes.z.size(), node, centre_m), path, Vector3d::Zero()};
      held.origin_m = made.centre_m + made.arm(held.place);
      made.held.push_back(std::move(held));
    }
  }
}

}  // namespace

namespace {

Eigen::Quaterniond turned(const Eigen::Quaterniond& from, const Vector3d& by) {
  const double angle = by.norm();
  if (!(angle > 0.0)) return from;
  return (Eigen::Quaterniond(Eigen::AngleAxisd(angle, by / angle)) * from).normalized();
}

/// Free rotation by the spin of the step's middle.
Eigen::Quaterniond turn_after(const ModalBody& body, double dt) {
  const auto spin_at = [&](const Eigen::Quaterniond& turn) -> Vector3d {
    return turn * (body.inertia.inverse() * (turn.conjugate() * body.angular_momentum));
  };
  return turned(body.turn, dt * spin_at(turned(body.turn, 0.5 * dt * spin_at(body.turn))));
}

}  // namespace

void ModalBody::fly(double dt, const Vector3d& gravity) {
  centre_m += dt * velocity_m_s + 0.5 * dt * dt * gravity;
  velocity_m_s += dt * gravity;
  const double turning = 0.5 * angular_momentum.dot(spin());
  turn = turn_after(*this, dt);
  ledger.correction_j += turning - 0.5 * angular_momentum.dot(spin());
  if (modes.z.size() == 0) return;
  modes.set_step(dt);
  const double before = modes.energy_j();
  modes.advance(Eigen::VectorXd::Zero(modes.z.size()));
  ledger.viscous_j += before - modes.energy_j();
}

Vector3d ModalBody::place_after(const ModalPlace& place, double dt, const Vector3d& gravity) const {
  Vector3d own = place.rest_m;
  if (modes.z.size() > 0) own += place.shape * modes.free_z();
  return centre_m + dt * velocity_m_s + 0.5 * dt * dt * gravity + turn_after(*this, dt) * own;
}

void ModalBody::refresh() {
  const Eigen::Index n = static_cast<Eigen::Index>(places.size());
  Eigen::VectorXd moved = Eigen::VectorXd::Zero(3 * n);
  if (modes.z.size() > 0) moved.noalias() = corner_shapes * modes.z;
  const Eigen::Map<const Eigen::Matrix3Xd> by(moved.data(), 3, n);
  swell_m = std::sqrt(by.colwise().squaredNorm().maxCoeff());
  corners_m.resize(3, n);
  const Matrix3d r = turn.toRotationMatrix();
  for (Eigen::Index i = 0; i < n; ++i)
    corners_m.col(i) = centre_m + r * (places[static_cast<std::size_t>(i)].rest_m + by.col(i));
  looked_at.resize(places.size());
  std::iota(looked_at.begin(), looked_at.end(), 0);
}

void ModalBody::refresh_where(const MayTouch& may_touch) {
  corners_m.resize(3, static_cast<Eigen::Index>(places.size()));
  looked_at.clear();
  swell_m = 0.0;
  const Eigen::VectorXd size = modes.z.cwiseAbs();
  const Matrix3d r = turn.toRotationMatrix();
  const double slack_m = 1e-9 * reach_m;  // round-off
  for (const CornerGroup& group : groups) {
    const double swell = size.size() > 0 ? group.most.dot(size) : 0.0;
    swell_m = std::max(swell_m, swell);
    if (!may_touch(centre_m + r * group.centre_m, group.reach_m + swell + slack_m)) continue;
    looked_at.insert(looked_at.end(), group.corners.begin(), group.corners.end());
  }
  std::sort(looked_at.begin(), looked_at.end());
  for (const int i : looked_at) {
    const ModalPlace& place = places[static_cast<std::size_t>(i)];
    Vector3d own = place.rest_m;
    if (size.size() > 0) own += place.shape * modes.z;
    corners_m.col(i) = centre_m + r * own;
  }
}

bool ModalBody::may_hold(const Vector3d& centre, double radius_m) const {
  const Vector3d own = turn.conjugate() * (centre - centre_m);
  const double within = radius_m + swell_m;
  if (!(((own - high_m).array() <= within).all() && ((low_m - own).array() <= within).all())) return false;
  if (ball_radius_m > 0.0) return own.norm() <= ball_radius_m + within;
  return parts.empty() || std::any_of(parts.begin(), parts.end(), [&](const std::vector<Eigen::Vector4d>& planes) {
           return std::all_of(planes.begin(), planes.end(), [&](const Eigen::Vector4d& plane) {
             return plane.head<3>().dot(own) - plane[3] <= within;
           });
         });
}

double ModalBody::ahead_j() const {
  if (ahead_modes.size() != modes.v.size()) return 0.0;
  const Vector3d momentum = angular_momentum - ahead_momentum;
  return moving_j() - 0.5 * mass_kg * (velocity_m_s - ahead_m_s).squaredNorm() -
         0.5 * momentum.dot(inverse_inertia() * momentum) - 0.5 * (modes.v - ahead_modes).squaredNorm();
}

double ModalBody::bent_m() const {
  double most_m = 0.0;
  if (modes.z.size() == 0) return most_m;
  const Eigen::VectorXd size = modes.z.cwiseAbs();
  for (const CornerGroup& group : groups) most_m = std::max(most_m, group.most.dot(size));
  return most_m;
}

void ModalBody::push(const ModalPlace& place, const Vector3d& impulse_n_s) {
  const Vector3d at = arm(place);
  velocity_m_s += impulse_n_s / mass_kg;
  angular_momentum += at.cross(impulse_n_s);
  modes.v += place.shape.transpose() * (turn.conjugate() * impulse_n_s);
}

void ModalBody::note(const ModalPlace& place, int other, bool is_new, const Vector3d& impulse_n_s, const Span& span) {
  touches.push_back({span, other, is_new, rest_centre_m + place.rest_m, impulse_n_s});
}

void ModalBody::turn_touches(std::size_t from) {
  for (std::size_t i = from; i < touches.size(); ++i)
    touches[i].impulse_n_s = turn.conjugate() * touches[i].impulse_n_s;
}

ModalPlace ModalBody::nearest(const Vector3d& own, Vector3d& normal) const {
  return place_at(surface_groups.nearest(own), normal);
}

ModalPlace ModalBody::nearest(const Vector3d& own, const mesh::SurfaceMesh& among, Vector3d& normal) const {
  return place_at(mesh::nearest_surface_point(among, own), normal);
}

ModalPlace ModalBody::place_at(const mesh::SurfacePoint& found, Vector3d& normal) const {
  ModalPlace place;
  place.shape = Eigen::Matrix3Xd::Zero(3, modes.z.size());
  std::array<Vector3d, 3> corner;
  for (std::size_t k = 0; k < found.nodes.size(); ++k) {
    const int node = found.nodes[k];
    const double weight = found.weights[static_cast<Eigen::Index>(k)];
    place.shape += weight * surface_shapes.middleRows(3 * node, 3);
    if (weight != 0.0) place.nodes.emplace_back(node, weight);
    if (k >= 3) continue;
    corner[k] = surface.vertices_m.row(node).transpose();
    const double hat = found.barycentric[static_cast<Eigen::Index>(k)];
    place.rest_m += hat * corner[k];
  }
  normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
  return place;
}

bool ModalBody::is_near(const Vector3d& x, double distance_m) const {
  const Vector3d own = turn.conjugate() * (x - centre_m);
  const double reach = distance_m + swell_m;
  return ((own - high_m).array() <= reach).all() && ((low_m - own).array() <= reach).all();
}

std::optional<ModalDepth> ModalBody::depth_of(const Vector3d& x) const {
  const Vector3d own = turn.conjugate() * (x - centre_m);
  bool inside = ball_radius_m > 0.0 && own.norm() <= ball_radius_m + swell_m;
  for (std::size_t p = 0; p < parts.size() && !inside; ++p)
    inside = std::all_of(parts[p].begin(), parts[p].end(),
                         [&](const Eigen::Vector4d& plane) { return plane.head<3>().dot(own) - plane[3] <= swell_m; });
  if (!inside) return {};
  ModalDepth depth;
  Vector3d normal;
  depth.place = nearest(own, normal);
  depth.depth_m = (depth.place.rest_m + depth.place.shape * modes.z - own).dot(normal);
  if (!(depth.depth_m > 0.0)) return {};
  depth.out = turn * normal;
  return depth;
}

double ModalBody::discarded_m_per_n(const ModalPlace& a, const Vector3d& u, const ModalPlace& b,
                                    const Vector3d& w) const {
  if (!discarded) return 0.0;
  const Vector3d own_u = turn.conjugate() * u, own_w = turn.conjugate() * w;
  double sum = 0.0;
  for (const auto& [i, weight_i] : a.nodes)
    for (const auto& [j, weight_j] : b.nodes) sum += weight_i * weight_j * own_u.dot(discarded->between(i, j) * own_w);
  return sum;
}

void ModalBody::keep_pose() {
  events::Pose pose;
  pose.body = row;
  pose.time_s = time_s;
  pose.position_m = centre_m - turn * rest_centre_m;
  pose.orientation_wxyz = {turn.w(), turn.x(), turn.y(), turn.z()};
  poses.push_back(pose);
}

std::vector<CornerGroup> corner_groups(const std::vector<ModalPlace>& places) {
  constexpr std::size_t kMost = 32;
  std::vector<std::vector<int>> open(1), done;
  for (std::size_t i = 0; i < places.size(); ++i) open[0].push_back(static_cast<int>(i));
  const auto rest = [&](int i) -> const Vector3d& { return places[static_cast<std::size_t>(i)].rest_m; };
  while (!open.empty()) {
    std::vector<int> corners = std::move(open.back());
    open.pop_back();
    if (corners.size() <= kMost) {
      if (!corners.empty()) done.push_back(std::move(corners));
      continue;
    }
    Eigen::AlignedBox3d box;
    for (const int i : corners) box.extend(rest(i));
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    const auto half = corners.begin() + static_cast<std::ptrdiff_t>(corners.size() / 2);
    std::nth_element(corners.begin(), half, corners.end(), [&](int i, int j) {
      return rest(i)[axis] < rest(j)[axis] || (rest(i)[axis] == rest(j)[axis] && i < j);
    });
    open.emplace_back(corners.begin(), half);
    open.emplace_back(half, corners.end());
  }
  std::vector<CornerGroup> groups;
  for (std::vector<int>& corners : done) {
    CornerGroup group;
    Eigen::AlignedBox3d box;
    group.most = Eigen::VectorXd::Zero(places.front().shape.cols());
    for (const int i : corners) {
      box.extend(rest(i));
      const Eigen::Matrix3Xd& shape = places[static_cast<std::size_t>(i)].shape;
      if (shape.cols() > 0) group.most = group.most.cwiseMax(shape.colwise().norm().transpose());
    }
    group.centre_m = box.center();
    for (const int i : corners) group.reach_m = std::max(group.reach_m, (rest(i) - group.centre_m).norm());
    group.corners = std::move(corners);
    groups.push_back(std::move(group));
  }
  return groups;
}

ModalBody modal_body_of(const Scene& scene, int row, const rigid::RigidBodySpec& spec, const SceneNotes& notes,
                        Monitor& monitor) {
  const SceneBody& body = scene.bodies[static_cast<std::size_t>(row)];
  const SceneMaterial& material = scene.material_of(body);
  ModalBody made;
  made.row = row;
  if (!body.shape)
    located(body.place, [&] {
      mesh::refuse_hanging_nodes(mesh_of(body, notes, monitor));
      return 0;
    });
  const auto [model, lambda] = elastic_of(scene, row, notes, monitor);
  const Eigen::Index n_modes = lambda.size();
  Eigen::VectorXd damping = Eigen::VectorXd::Zero(n_modes);
  for (Eigen::Index k = 0; k < n_modes && material.damping; ++k)
    damping[k] = 2.0 * material.damping->law->decay_per_s(std::sqrt(lambda[k]), material.damping->parameters.data());
  made.modes = modal::ModalState(lambda, damping);
  made.mass_kg = spec.mass_kg;
  made.inertia = spec.inertia_kg_m2;
  made.rest_centre_m = spec.centre_m;
  made.skin = spec.skin;
  made.ball_radius_m = spec.ball_radius_m;
  made.turn = spec.orientation;
  made.centre_m = spec.position_m + spec.orientation * spec.centre_m;
  made.velocity_m_s = spec.velocity_m_s;
  const Matrix3d r = spec.orientation.toRotationMatrix();
  made.angular_momentum = r * spec.inertia_kg_m2 * r.transpose() * spec.angular_velocity_rad_s;
  made.linear_program = body.modal.linear_program;
  add_surface(made, model, spec);
  made.under_balls = std::make_shared<ResidualFlexibility>(model, lambda, material.elastic);
  if (body.modal.residual_flexibility) made.discarded = made.under_balls;
  add_holds(made, scene, model, spec.centre_m);
  const double highest_hz = n_modes > 0 ? std::sqrt(lambda.maxCoeff()) / (2.0 * kPi) : 0.0;
  const double step_s = 1.0 / scene.solver.rate_hz;
  made.dt_s = step_s / std::clamp(std::ceil(step_s * 20.0 * highest_hz), 1.0, static_cast<double>(kMostSubsteps));
  made.keep_pose();
  return made;
}

}  // namespace klang::scene::detail
