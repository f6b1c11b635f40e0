#include "core/physics/solid/statics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using klang::mesh::TetMesh;
using klang::test::box_mesh;
using namespace klang::solid;
using Eigen::Vector3d;

const Material kMaterial = from_youngs_modulus(62e9, 0.2, 2600);  // of tests/reference/static.json

// Moves the inner nodes of a box, so that a patch of equal elements cannot hide an error.
TetMesh distorted_box(double lx, double ly, double lz, int nx, int ny, int nz, int order) {
  TetMesh mesh = box_mesh(lx, ly, lz, nx, ny, nz, 1);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const Vector3d x = mesh.nodes_m.row(i).transpose();
    const double bubble =
        x[0] * (lx - x[0]) / (lx * lx) * x[1] * (ly - x[1]) / (ly * ly) * x[2] * (lz - x[2]) / (lz * lz);
    mesh.nodes_m.row(i) += bubble * Eigen::RowVector3d(3 * lx / nx, -4 * ly / ny, 3 * lz / nz);
  }
  return order == 1 ? mesh : klang::mesh::to_quadratic(mesh);
}

// The given displacement less its rigid part, as solve_statics returns it.
Eigen::VectorXd without_rigid_part(const TetMesh& mesh, const AssembledSolid& solid, const Eigen::VectorXd& u) {
  Eigen::MatrixXd rigid(3 * mesh.n_nodes(), 6);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const Vector3d x = mesh.nodes_m.row(i).transpose();
    rigid.middleRows<3>(3 * i) << 1, 0, 0, 0, x[2], -x[1], 0, 1, 0, -x[2], 0, x[0], 0, 0, 1, x[1], -x[0], 0;
  }
  const Eigen::MatrixXd mass_rigid = solid.mass_unit_density.selfadjointView<Eigen::Lower>() * rigid;
  return u - rigid * (rigid.transpose() * mass_rigid).ldlt().solve(mass_rigid.transpose() * u);
}

class PatchTest : public testing::TestWithParam<int> {
 protected:
  // Free box under the traction of a uniform stress: u = strain x to round-off, energy as given.
  void expect_uniform(const Eigen::Matrix3d& stress, const Eigen::Matrix3d& strain, double energy) {
    const TetMesh mesh = distorted_box(0.1, 0.02, 0.03, 4, 2, 3, GetParam());
    const AssembledSolid solid = assemble(mesh);
    const Eigen::VectorXd force =
        traction_force_n(mesh, [&](const Vector3d&, const Vector3d& normal) -> Vector3d { return stress * normal; });
    const StaticResult result = solve_statics(mesh, solid, kMaterial, force);
    ASSERT_TRUE(result.usable()) << result.message;
    EXPECT_EQ(result.n_rigid_modes, 6);
    Eigen::VectorXd exact(3 * mesh.n_nodes());
    for (int i = 0; i < mesh.n_nodes(); ++i) exact.segment<3>(3 * i) = strain * mesh.nodes_m.row(i).transpose();
    exact = without_rigid_part(mesh, solid, exact);
    EXPECT_LE((result.displacement_m - exact).cwiseAbs().maxCoeff(), 1e-11 * exact.cwiseAbs().maxCoeff());
    EXPECT_NEAR(result.energy_j[0] / energy, 1, 1e-11);
    EXPECT_LE(result.relative_residual[0], 1e-11);
  }
};
INSTANTIATE_TEST_SUITE_P(Elements, PatchTest, testing::Values(1, 2));

TEST_P(PatchTest, UniaxialTensionIsExact) {  // tests/reference/static.json: uniaxial_patch
  expect_uniform(Vector3d(1e6, 0, 0).asDiagonal(),
                 Vector3d(1.6129032258064517e-05, -3.225806451612903e-06, -3.225806451612903e-06).asDiagonal(),
                 0.0004838709677419355);
}

TEST_P(PatchTest, HydrostaticPressureIsExact) {  // tests/reference/static.json: hydrostatic_patch
  expect_uniform(Vector3d::Constant(-1e6).asDiagonal(), Vector3d::Constant(-9.67741935483871e-06).asDiagonal(),
                 0.000870967741935484);
}

TEST_P(PatchTest, PureShearIsExact) {  // tests/reference/static.json: shear_patch
  Eigen::Matrix3d unit = Eigen::Matrix3d::Zero();
  unit(0, 1) = unit(1, 0) = 1;
  expect_uniform(1e6 * unit, 0.5 * 3.8709677419354835e-05 * unit, 0.001161290322580645);
}

TEST(Statics, PureBendingIsExactForQuadraticElements) {
  // tests/reference/static.json: pure_bending (x along the bar, y across h, from the mid-plane).
  TetMesh mesh = box_mesh(0.2, 0.01, 0.02, 4, 1, 2, 2);
  mesh.nodes_m.col(1).array() -= 0.005;
  mesh.nodes_m.col(2).array() -= 0.01;
  const AssembledSolid solid = assemble(mesh);
  const double inertia = 1.666666666666667e-09, ei = 62e9 * inertia, nu = 0.2;
  const Eigen::VectorXd force = traction_force_n(mesh, [&](const Vector3d& x, const Vector3d& n) -> Vector3d {
    return std::abs(n[0]) > 0.5 ? Vector3d(n[0] * x[1] / inertia, 0, 0) : Vector3d(0, 0, 0);
  });
  const StaticResult result = solve_statics(mesh, solid, kMaterial, force);
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_NEAR(result.energy_j[0] / 0.000967741935483871, 1, 1e-10);
  Eigen::VectorXd exact(3 * mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    const auto x = mesh.nodes_m.row(i);
    exact.segment<3>(3 * i) << x[0] * x[1] / ei, -(x[0] * x[0] + nu * (x[1] * x[1] - x[2] * x[2])) / (2 * ei),
        -nu * x[1] * x[2] / ei;
  }
  exact = without_rigid_part(mesh, solid, exact);
  EXPECT_LE((result.displacement_m - exact).cwiseAbs().maxCoeff(), 1e-9 * exact.cwiseAbs().maxCoeff());
}

TEST(Statics, CantileverTipIsTheThreeDimensionalOne) {
  // tests/reference/static.json: cantilever_tip (ritz3d_mean_tip, 4 digits); the beam formulas are 0.1 and 0.3 %
  // off.
  TetMesh corners = box_mesh(0.2, 0.01, 0.02, 24, 4, 4, 1);
  for (int i = 0; i < corners.n_nodes(); ++i) {  // finer towards the clamp, whose edges are singular
    auto x = corners.nodes_m.row(i);
    x[0] = 0.2 * std::pow(x[0] / 0.2, 1.6);
    x[1] = 0.005 * (1 - std::cos(klang::kPi * x[1] / 0.01));
    x[2] = 0.01 * (1 - std::cos(klang::kPi * x[2] / 0.02));
  }
  const TetMesh mesh = klang::mesh::to_quadratic(corners);
  const AssembledSolid solid = assemble(mesh, parse_support("clamped:x=0"));
  const Eigen::VectorXd force = traction_force_n(mesh, [](const Vector3d&, const Vector3d& n) -> Vector3d {
    return n[0] > 0.5 ? Vector3d(0, 1 / (0.02 * 0.01), 0) : Vector3d(0, 0, 0);
  });
  const StaticResult result = solve_statics(mesh, solid, kMaterial, force);
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_EQ(result.n_rigid_modes, 0);
  const double mean_tip = force.dot(result.displacement_m.col(0));  // P = 1 N
  EXPECT_NEAR(mean_tip / 2.5775896333220716e-05, 1, 3e-4);
  EXPECT_NEAR(result.energy_j[0], 0.5 * mean_tip, 1e-9 * mean_tip);
}

TEST(Statics, CurvedSphereUnderPressureShrinksUniformly) {
  // p on the curved faces of a ball: u = -p x / (3 K). Curved elements hold it exactly, whatever their
  // mid-nodes.
  TetMesh mesh = klang::mesh::mesh_shape({"sphere", {{"radius_m", 0.05}}, {}});
  const AssembledSolid solid = assemble(mesh);
  const Eigen::VectorXd force =
      traction_force_n(mesh, [](const Vector3d&, const Vector3d& n) -> Vector3d { return -1e6 * n; });
  const StaticResult result = solve_statics(mesh, solid, kMaterial, force);
  ASSERT_TRUE(result.usable()) << result.message;
  const double strain = -1e6 / (3 * kMaterial.bulk_modulus_pa());
  Eigen::VectorXd exact(3 * mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i) exact.segment<3>(3 * i) = strain * mesh.nodes_m.row(i).transpose();
  EXPECT_LE((result.displacement_m - exact).cwiseAbs().maxCoeff(), 1e-9 * exact.cwiseAbs().maxCoeff());
}

TEST(Statics, PushedFreeBarIsStrainedByItsOwnInertia) {
  // tests/reference/static.json: free_bar_end_force_nu0. f - M a gives the linear stress and its energy; projecting
  // by the Euclidean inner product instead would miss it where nodal masses differ (they do: corners, edges,
  // faces).
  const Material material = from_youngs_modulus(62e9, 0.0, 2600);
  const TetMesh mesh = box_mesh(0.1, 0.01, 0.01, 40, 2, 2, 2);
  const AssembledSolid solid = assemble(mesh);
  const Eigen::VectorXd force = traction_force_n(mesh, [](const Vector3d&, const Vector3d& n) -> Vector3d {
    return n[0] < -0.5 ? Vector3d(10 / 1e-4, 0, 0) : Vector3d(0, 0, 0);
  });
  const StaticResult result = solve_statics(mesh, solid, material, force);
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_NEAR(result.energy_j[0] / 2.688172043010753e-07, 1, 1e-5);
}

TEST(Statics, RefusesForcesOfTheWrongSizeAndNaN) {
  const TetMesh mesh = box_mesh(1, 1, 1, 1, 1, 1, 1);
  const AssembledSolid solid = assemble(mesh);
  EXPECT_THROW(solve_statics(mesh, solid, kMaterial, Eigen::VectorXd::Zero(5)), InputError);
  EXPECT_THROW(solve_statics(mesh, solid, kMaterial, Eigen::VectorXd::Constant(24, std::nan(""))), InputError);
}

}  // namespace
