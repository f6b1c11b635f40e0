#include "core/physics/fracture/quasistatic/free_body_solver.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/face_parts.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/node_ends.hpp"

namespace klang::fracture {
namespace {

constexpr double kBackwardErrorToRefine = 1e-14;

mesh::TetMesh one_body(mesh::TetMesh mesh, const solid::Material& material) {
  solid::validate(material);
  if (mesh.n_elements() == 0) throw InputError("mesh", "has no elements");
  std::vector<char> used(static_cast<std::size_t>(mesh.n_nodes()), 0);
  for (Eigen::Index k = 0; k < mesh.elements.size(); ++k) {
    const int node = mesh.elements.data()[k];
    if (node < 0 || node >= mesh.n_nodes()) throw InputError("mesh", "names a node that is not there");
    used[static_cast<std::size_t>(node)] = 1;
  }
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (used[static_cast<std::size_t>(i)] == 0)
      throw InputError("mesh", "node " + std::to_string(i) + " belongs to no element");
  const int n_parts = mesh::face_parts(mesh).n_parts;
  if (n_parts != 1)
    throw InputError("mesh", "is not one body: its elements fall apart into pieces that share no face",
                     std::to_string(n_parts) + " pieces",
                     "one; pieces that touch by an edge or a node alone are free to turn about it");
  return mesh;
}

Eigen::MatrixXd times(const la::SparseMatrix& lower, const Eigen::MatrixXd& x) {
  return lower.selfadjointView<Eigen::Lower>() * x;
}

int largest_component(const Eigen::Vector3d& v) {
  Eigen::Index most = 0;
  v.cwiseAbs().maxCoeff(&most);
  return static_cast<int>(most);
}

/// The node for which measure(place) is largest, the first of equal ones.
template <class Measure>
int farthest_node(const mesh::TetMesh& mesh, const Measure& measure) {
  int found = 0;
  double most = -1.0;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const double here = measure(Eigen::Vector3d(mesh.nodes_m.row(i).transpose()));
    if (here > most) most = here, found = i;
  }
  return found;
}

}  // namespace

FreeBodySolver::FreeBodySolver(mesh::TetMesh mesh, const solid::Material& material, Relief relief)
    : mesh_(one_body(std::move(mesh), material)), stresses_(mesh_, material), relief_(relief) {
  const solid::AssembledSolid solid = solid::assemble(
      mesh_, {}, relief == Relief::kLumpedMass ? solid::MassKind::kLumped : solid::MassKind::kConsistent);
  stiffness_ = solid::stiffness(solid, material.lame_lambda_pa, material.lame_mu_pa);
  largest_diagonal_ = stiffness_.diagonal().maxCoeff();
  const mesh::MassProperties body = mesh::mass_properties(mesh_);
  mass_kg_ = material.density_kg_m3 * body.volume_m3;
  centre_m_ = body.centre_m;
  la::SparseMatrix mass = solid.mass_unit_density;
  mass *= material.density_kg_m3;
  set_rigid_motions(mass, relief);
  choose_pins();

  la::SparseMatrix pinned = stiffness_;
  std::vector<char> is_pin(static_cast<std::size_t>(pinned.rows()), 0);
  for (const int pin : pins_) is_pin[static_cast<std::size_t>(pin)] = 1;
  for (Eigen::Index j = 0; j < pinned.cols(); ++j)
    for (la::SparseMatrix::InnerIterator entry(pinned, j); entry; ++entry)
      if (entry.row() != j && (is_pin[static_cast<std::size_t>(entry.row())] || is_pin[static_cast<std::size_t>(j)]))
        entry.valueRef() = 0.0;
  usable_ = factor_.factor(pinned, la::block_ordering(pinned, solid::node_ends(mesh_, solid)));
  message_ = usable_ ? "" : factor_.message();
}

void FreeBodySolver::set_rigid_motions(const la::SparseMatrix& mass, Relief relief) {
  rigid_.resize(3 * static_cast<Eigen::Index>(mesh_.n_nodes()), 6);
  for (int i = 0; i < mesh_.n_nodes(); ++i) {
    const Eigen::Vector3d r = mesh_.nodes_m.row(i).transpose() - centre_m_;
    rigid_.middleRows<3>(3 * static_cast<Eigen::Index>(i)) << 1, 0, 0, 0, r[2], -r[1], 0, 1, 0, -r[2], 0, r[0], 0, 0, 1,
        r[1], -r[0], 0;
  }
  mass_rigid_ = relief == Relief::kEuclidean ? rigid_ : times(mass, rigid_);
  inertia_.compute(rigid_.transpose() * mass_rigid_);
}

void FreeBodySolver::choose_pins() {
  const auto place = [&](int node) { return Eigen::Vector3d(mesh_.nodes_m.row(node).transpose()); };
  const int first = farthest_node(mesh_, [&](const Eigen::Vector3d& x) { return (x - centre_m_).norm(); });
  const Eigen::Vector3d x0 = place(first);
  const int second = farthest_node(mesh_, [&](const Eigen::Vector3d& x) { return (x - x0).norm(); });
  const Eigen::Vector3d along = place(second) - x0;
  const int third = farthest_node(mesh_, [&](const Eigen::Vector3d& x) { return along.cross(x - x0).norm(); });
  const Eigen::Vector3d across = along.cross(place(third) - x0);
  // The second node's axes across its largest component stop all turns but that about the line of both; the third's axis stops
  // this one.
  const int free_axis = largest_component(along);
  pins_ = {3 * first,
           3 * first + 1,
           3 * first + 2,
           3 * second + (free_axis + 1) % 3,
           3 * second + (free_axis + 2) % 3,
           3 * third + largest_component(across)};
}

Eigen::MatrixXd FreeBodySolver::relieved(const Eigen::MatrixXd& force_n) const {
  // Column by column: a product of matrices would sum in another order for another number of columns.
  Eigen::MatrixXd load = force_n;
  for (Eigen::Index c = 0; c < load.cols(); ++c)
    load.col(c) -= mass_rigid_ * inertia_.solve(rigid_.transpose() * force_n.col(c));
  return load;
}

RigidAcceleration FreeBodySolver::acceleration(const Eigen::VectorXd& force_n) const {
  RigidAcceleration result;
  const Eigen::VectorXd resultant = rigid_.transpose() * force_n;
  result.net_force_n = resultant.head<3>();
  result.net_moment_n_m = resultant.tail<3>();
  if (relief_ == Relief::kEuclidean) return result;
  const Eigen::VectorXd acceleration = inertia_.solve(resultant);
  result.acceleration_m_s2 = acceleration.head<3>();
  result.spin_rad_s2 = acceleration.tail<3>();
  return result;
}

Eigen::MatrixXd FreeBodySolver::stiffness_times(const Eigen::MatrixXd& u) const { return times(stiffness_, u); }

Eigen::MatrixXd FreeBodySolver::solve_pinned(Eigen::MatrixXd load) {
  for (const int pin : pins_) load.row(pin).setZero();
  factor_.solve(load.data(), load.data(), load.cols());
  return load;
}

QuasistaticSolution FreeBodySolver::solve(const Eigen::MatrixXd& force_n) {
  if (force_n.rows() != rigid_.rows())
    throw InputError("quasistatic load", "has the wrong number of rows", std::to_string(force_n.rows()),
                     std::to_string(rigid_.rows()));
  if (!force_n.allFinite()) throw InputError("quasistatic load", "is not finite");
  QuasistaticSolution result;
  const Eigen::MatrixXd load = relieved(force_n);
  Eigen::MatrixXd& u = result.displacement_m;
  u = solve_pinned(load);
  Eigen::MatrixXd rest = load - times(stiffness_, u);
  result.relative_residual.resize(u.cols());
  result.backward_error.resize(u.cols());
  const auto measure = [&] {
    for (Eigen::Index c = 0; c < u.cols(); ++c) {
      const double size = load.col(c).norm(), off = rest.col(c).norm();
      result.relative_residual[c] = size > 0.0 ? off / size : 0.0;
      result.backward_error[c] = size > 0.0 ? off / (largest_diagonal_ * u.col(c).norm() + size) : 0.0;
    }
    return (result.backward_error.array() <= kBackwardErrorToRefine).all();
  };
  if (!measure()) {
    const Eigen::MatrixXd correction = solve_pinned(rest);
    for (Eigen::Index c = 0; c < u.cols(); ++c)
      if (!(result.backward_error[c] <= kBackwardErrorToRefine)) u.col(c) += correction.col(c);
    rest = load - times(stiffness_, u);
    measure();
  }
  for (Eigen::Index c = 0; c < u.cols(); ++c) {
    const Eigen::VectorXd rigid_part = inertia_.solve(mass_rigid_.transpose() * u.col(c));
    u.col(c) -= rigid_ * rigid_part;
  }
  result.strain_energy_j = 0.5 * u.cwiseProduct(load).colwise().sum().transpose();
  return result;
}

}  // namespace klang::fracture
