#include "core/physics/fracture/quasistatic/place_compliance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/mesh/graded_patch.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/surface_point.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using Eigen::Vector3d;
using klang::test::box_mesh;
using klang::test::reference_glass;

/// What the mesh gives way at one place under a force at that place.
double at_a_point(FreeBodySolver& solver, const Vector3d& place) {
  const auto at = klang::mesh::nearest_surface_point(solver.mesh(), place);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * solver.mesh().n_nodes());
  for (std::size_t k = 0; k < at.nodes.size(); ++k)
    force[3 * at.nodes[k] + 2] = at.weights[static_cast<Eigen::Index>(k)];
  return force.dot(solver.solve(force).displacement_m.col(0));
}

TEST(PlaceCompliance, IsThatOfThePlateWhateverItsMeshAndWhereverOnItsElements) {
  // 0.12 x 0.12 x 0.02 m; places at the middle: a node of one mesh, inside faces of the others.
  double least = HUGE_VAL, most = 0.0, least_at_a_point = HUGE_VAL, most_at_a_point = 0.0;
  const Vector3d middle(0.06, 0.06, 0.02);
  for (const int n : {3, 4, 8}) {
    FreeBodySolver solver(box_mesh(0.12, 0.12, 0.02, n, n, 1 + n / 8, 2), reference_glass());
    const PlaceCompliance found = place_compliance(solver, reference_glass(), middle, Vector3d::UnitZ());
    least = std::min(least, found.beyond_dent_m_per_n);
    most = std::max(most, found.beyond_dent_m_per_n);
    least_at_a_point = std::min(least_at_a_point, at_a_point(solver, middle));
    most_at_a_point = std::max(most_at_a_point, at_a_point(solver, middle));
  }
  EXPECT_LE(most - least, 0.05 * most);
  EXPECT_GE(most_at_a_point - least_at_a_point, 0.5 * least_at_a_point);
}

TEST(GradedPatch, KeepsVolumeAndTakesQuadraticFieldsExactly) {
  const klang::mesh::TetMesh mesh = box_mesh(0.3, 0.2, 0.1, 2, 2, 2, 2);
  std::vector<int> some;
  for (int e = 0; e < mesh.n_elements() / 2; ++e) some.push_back(e);
  const auto patch = klang::mesh::graded_patch(mesh, some, {Vector3d(0.0, 0.0, 0.0), 0.01, 0.5});
  klang::mesh::TetMesh part = mesh;
  part.elements = mesh.elements(some, Eigen::all);
  const double volume = klang::mesh::mass_properties(part).volume_m3;
  EXPECT_LE(std::abs(klang::mesh::mass_properties(patch.mesh).volume_m3 / volume - 1.0), 1e-12);
  EXPECT_GT(patch.mesh.n_elements(), 4 * static_cast<int>(some.size()));
  const auto field = [](const auto& x) { return 1.0 + x[0] * x[1] - 2.0 * x[2] * x[2] + x[0]; };
  Eigen::VectorXd coarse(mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i) coarse[i] = field(mesh.nodes_m.row(i));
  const Eigen::VectorXd fine = patch.from_coarse * coarse;
  int n_shared = 0;
  for (int i = 0; i < patch.mesh.n_nodes(); ++i) {
    EXPECT_LE(std::abs(fine[i] - field(patch.mesh.nodes_m.row(i))), 1e-13);
    n_shared += patch.is_shared[static_cast<std::size_t>(i)];
  }
  EXPECT_GT(n_shared, 6);
}

}  // namespace
