#include "core/physics/fracture/quasistatic/place_compliance.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/graded_patch.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/node_ends.hpp"
#include "core/physics/solid/statics.hpp"

namespace klang::fracture {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kPatchEdges = 4.0;       ///< radius of what is cut, in edges
constexpr double kAreaEdges = 1.0 / 6.0;  ///< radius of the load, in edges
constexpr double kAreaThickness = 1.0 / 6.0;
constexpr double kCutOfArea = 0.8, kGrowth = 0.6, kCutOfEdge = 0.5;
constexpr int kMostRounds = 8;
constexpr double kEnough = 1e-3;  ///< of the dent: a correction that adds less ends them

Vector3d corner_of(const mesh::TetMesh& mesh, int element, int c) {
  return mesh.nodes_m.row(mesh.elements(element, c)).transpose();
}

/// Longest edge of the elements that have all corners of the face nearest to the place.
double edge_at(const mesh::TetMesh& mesh, const mesh::SurfacePoint& at) {
  double longest_sq = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    int shared = 0;
    for (int c = 0; c < 4; ++c)
      for (std::size_t k = 0; k < 3; ++k) shared += mesh.elements(e, c) == at.nodes[k];
    if (shared < 3) continue;
    for (const auto& [a, b] : mesh::kTetEdges)
      longest_sq = std::max(longest_sq, (corner_of(mesh, e, a) - corner_of(mesh, e, b)).squaredNorm());
  }
  return std::sqrt(longest_sq);
}

/// Elements with a corner near the place, but for the one that is farthest: something has to hold the rest still.
std::vector<int> elements_near(const mesh::TetMesh& mesh, const Vector3d& place, double distance_m) {
  std::vector<int> near;
  int farthest = 0;
  double most_m = 0.0;
  std::vector<double> least_m(static_cast<std::size_t>(mesh.n_elements()));
  for (int e = 0; e < mesh.n_elements(); ++e) {
    double least = HUGE_VAL;
    for (int c = 0; c < 4; ++c) least = std::min(least, (corner_of(mesh, e, c) - place).norm());
    least_m[static_cast<std::size_t>(e)] = least;
    if (least > most_m) most_m = least, farthest = e;
  }
  for (int e = 0; e < mesh.n_elements(); ++e)
    if (e != farthest && least_m[static_cast<std::size_t>(e)] <= distance_m) near.push_back(e);
  return near;
}

/// The part of a mesh that is cut finer, its stiffness, and the factor of that with shared faces held.
struct Patch {
  mesh::GradedPatch cut;
  la::SparseMatrix stiffness, mass;  ///< lower triangles
  std::vector<Index> free;           ///< degrees of freedom
  la::SparseCholesky factor;
  bool usable = false;

  Patch(const mesh::TetMesh& mesh, const solid::Material& material, const std::vector<int>& elements,
        const mesh::Grading& grading)
      : cut(mesh::graded_patch(mesh, elements, grading)) {
    const solid::AssembledSolid solid = solid::assemble(cut.mesh);
    stiffness = solid::stiffness(solid, material.lame_lambda_pa, material.lame_mu_pa);
    mass = solid.mass_unit_density;
    mass *= material.density_kg_m3;
    la::SparseMatrix held = stiffness;
    const auto is_held = [&](Index dof) { return cut.is_shared[static_cast<std::size_t>(dof / 3)] != 0; };
    for (Index j = 0; j < held.cols(); ++j)
      for (la::SparseMatrix::InnerIterator entry(held, j); entry; ++entry)
        if (entry.row() != j && (is_held(entry.row()) || is_held(j))) entry.valueRef() = 0.0;
    for (Index i = 0; i < held.cols(); ++i)
      if (!is_held(i)) free.push_back(i);
    usable = !free.empty() && static_cast<Index>(free.size()) < held.cols() &&
             factor.factor(held, la::block_ordering(held, solid::node_ends(cut.mesh, solid)));
  }
  VectorXd fine(const VectorXd& coarse) const { return times(cut.from_coarse, coarse); }
  VectorXd coarse(const VectorXd& fine) const { return times(cut.from_coarse.transpose(), fine); }
  VectorXd pulled(const VectorXd& u) const { return stiffness.selfadjointView<Eigen::Lower>() * u; }
  /// What the part gives way under forces with its shared faces held.
  VectorXd solved(const VectorXd& force) {
    VectorXd load = VectorXd::Zero(force.size());
    load(free) = force(free);
    VectorXd u = factor.solve(load);
    VectorXd only = VectorXd::Zero(u.size());
    only(free) = u(free);
    return only;
  }

 private:
  template <class Matrix>
  static VectorXd times(const Matrix& by_node, const VectorXd& u) {
    using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Rows product = by_node * Eigen::Map<const Rows>(u.data(), u.size() / 3, 3);
    return Eigen::Map<const VectorXd>(product.data(), product.size());
  }
};

/// A unit force along a direction, spread over a circle about a place as Hertz' pressure.
VectorXd spread_force(const mesh::TetMesh& mesh, const Vector3d& place, const Vector3d& along, double radius_m) {
  VectorXd force = solid::traction_force_n(mesh, [&](const Vector3d& x, const Vector3d&) -> Vector3d {
    return std::sqrt(std::max(0.0, 1.0 - (x - place).squaredNorm() / (radius_m * radius_m))) * along;
  });
  double sum = 0.0;
  for (Index i = 0; i < force.size(); i += 3) sum += force.segment<3>(i).dot(along);
  return sum > 0.0 ? VectorXd(force / sum) : VectorXd::Zero(force.size());
}

double thickness_at(const mesh::TetMesh& mesh, const std::vector<int>& elements, const Vector3d& place,
                    const Vector3d& outward) {
  double deepest_m = 0.0;
  for (const int e : elements)
    for (int c = 0; c < 4; ++c) deepest_m = std::max(deepest_m, (place - corner_of(mesh, e, c)).dot(outward));
  return deepest_m;
}

}  // namespace

PlaceCompliance place_compliance(FreeBodySolver& solver, const solid::Material& material, const Vector3d& place_m,
                                 const Vector3d& outward) {
  const mesh::TetMesh& mesh = solver.mesh();
  const double edge_m = edge_at(mesh, mesh::nearest_surface_point(mesh, place_m));
  const std::vector<int> near = elements_near(mesh, place_m, kPatchEdges * edge_m);
  PlaceCompliance found;
  found.edge_m = edge_m;
  found.area_radius_m = std::min(kAreaEdges * edge_m, kAreaThickness * thickness_at(mesh, near, place_m, outward));
  const double b = found.area_radius_m, mu = material.lame_mu_pa, lambda = material.lame_lambda_pa;
  const double soft_per_pa = (lambda + 2.0 * mu) / (4.0 * mu * (lambda + mu));  // (1 - nu^2) / E
  found.dent_m_per_n = 0.6 * soft_per_pa / b;
  Patch patch(mesh, material, near, {place_m, kCutOfArea * b, kGrowth, kCutOfEdge * edge_m});
  found.n_cut_elements = patch.cut.mesh.n_elements();
  if (!patch.usable) throw NumericalError("compliance at a place: " + std::string(patch.factor.message()));
  const VectorXd fine_force = spread_force(patch.cut.mesh, place_m, outward, b);
  VectorXd force = patch.coarse(fine_force);

  VectorXd coarse = solver.solve(force).displacement_m.col(0);
  found.of_mesh_m_per_n = force.dot(coarse);
  double sum = found.of_mesh_m_per_n;
  // What strains a free body is the force less what accelerates it.
  const RigidAcceleration rigid = solver.acceleration(force);
  VectorXd accelerated(fine_force.size());
  for (Index i = 0; i < patch.cut.mesh.n_nodes(); ++i)
    accelerated.segment<3>(3 * i) =
        rigid.acceleration_m_s2 +
        rigid.spin_rad_s2.cross(Vector3d(patch.cut.mesh.nodes_m.row(i).transpose()) - solver.centre_m());
  VectorXd left = fine_force - patch.mass.selfadjointView<Eigen::Lower>() * accelerated;
  for (int k = 0; k < kMostRounds; ++k) {
    left -= patch.pulled(patch.fine(coarse));
    const VectorXd more = patch.solved(left);
    double gained = 0.0;
    for (const Index i : patch.free) gained += left[i] * more[i];
    const VectorXd pull = patch.pulled(more);
    left -= pull;
    force = -patch.coarse(pull);
    coarse = solver.solve(force).displacement_m.col(0);
    gained += force.dot(coarse);
    sum += gained;
    if (gained <= kEnough * found.dent_m_per_n) break;
  }
  found.beyond_dent_m_per_n = sum - found.dent_m_per_n;
  return found;
}

}  // namespace klang::fracture
