#include "core/physics/fracture/quasistatic/free_body_solver.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/fracture/quasistatic/body_stress.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using Eigen::Vector3d;
using klang::InputError;
using klang::mesh::TetMesh;
using klang::test::box_mesh;
using klang::test::reference_glass;

Eigen::VectorXd random_vector(Eigen::Index n, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::VectorXd v(n);
  for (Eigen::Index i = 0; i < n; ++i) v[i] = uniform(random);
  return v;
}

Eigen::MatrixXd dense_stiffness(const FreeBodySolver& solver) {
  const Eigen::Index n = 3 * solver.mesh().n_nodes();
  return solver.stiffness_times(Eigen::MatrixXd::Identity(n, n));
}

class FreeBody : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Elements, FreeBody, testing::Values(1, 2));

TEST_P(FreeBody, StiffnessHasSixZeroEigenvalues) {
  FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam()), reference_glass());
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(dense_stiffness(solver), Eigen::EigenvaluesOnly).eigenvalues();
  EXPECT_LE(values.head(6).cwiseAbs().maxCoeff(), 1e-13 * values.maxCoeff());
  EXPECT_GE(values[6], 1e-7 * values.maxCoeff());
}

TEST_P(FreeBody, PinsGiveTheStressOfTheDensePseudoInverse) {
  FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam()), reference_glass());
  ASSERT_TRUE(solver.usable());
  const Eigen::VectorXd force = random_vector(3 * solver.mesh().n_nodes(), 1);
  const QuasistaticSolution solution = solver.solve(force);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense_stiffness(solver));
  Eigen::VectorXd inverse = eigen.eigenvalues().cwiseInverse();
  inverse.head(6).setZero();
  const Eigen::VectorXd u =
      eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose() * solver.relieved(force);
  const StressField pinned = solver.stresses().field(solution.displacement_m.col(0));
  const StressField dense = solver.stresses().field(u);
  const double scale = dense.stress_pa.cwiseAbs().maxCoeff();
  EXPECT_LE((pinned.stress_pa - dense.stress_pa).cwiseAbs().maxCoeff(), 1e-10 * scale);
  EXPECT_LE(std::abs(pinned.strain_energy_j / dense.strain_energy_j - 1.0), 1e-10);
  EXPECT_LE(std::abs(pinned.strain_energy_j / solution.strain_energy_j[0] - 1.0), 1e-10);
}

TEST_P(FreeBody, PinsAreThreeTwoOneAtThreeNodes) {
  FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam()), reference_glass());
  const auto& pins = solver.pins();
  EXPECT_EQ(pins[0] / 3, pins[2] / 3);
  EXPECT_EQ(pins[3] / 3, pins[4] / 3);
  EXPECT_NE(pins[0] / 3, pins[3] / 3);
  EXPECT_NE(pins[5] / 3, pins[3] / 3);
  EXPECT_NE(pins[5] / 3, pins[0] / 3);
}

TEST_P(FreeBody, BalancedLoadHasNoResultantAndNoMoment) {
  for (const Relief relief : {Relief::kConsistentMass, Relief::kLumpedMass, Relief::kEuclidean}) {
    FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam()), reference_glass(), relief);
    const Eigen::VectorXd force = random_vector(3 * solver.mesh().n_nodes(), 2);
    const Eigen::VectorXd rest = klang::test::rigid_motions(solver.mesh()).transpose() * solver.relieved(force);
    EXPECT_LE(rest.head<3>().norm(), 1e-13 * force.norm());
    EXPECT_LE(rest.tail<3>().norm(), 1e-14 * force.norm());
  }
}

TEST_P(FreeBody, MovedAndTurnedItHoldsTheSameEnergyAndTheTurnedStress) {
  const TetMesh mesh = box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam());
  const Eigen::VectorXd force = random_vector(3 * mesh.n_nodes(), 3);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -2).normalized()).toRotationMatrix();
  TetMesh moved = mesh;
  Eigen::VectorXd moved_force = force;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    moved.nodes_m.row(i) = (turn * mesh.nodes_m.row(i).transpose() + Vector3d(0.3, -0.2, 0.5)).transpose();
    moved_force.segment<3>(3 * i) = turn * force.segment<3>(3 * i);
  }
  FreeBodySolver here(mesh, reference_glass()), there(moved, reference_glass());
  const QuasistaticSolution a = here.solve(force), b = there.solve(moved_force);
  EXPECT_LE(std::abs(a.strain_energy_j[0] / b.strain_energy_j[0] - 1.0), 1e-12);
  const StressField fa = here.stresses().field(a.displacement_m.col(0)),
                    fb = there.stresses().field(b.displacement_m.col(0));
  for (int e = 0; e < mesh.n_elements(); ++e)
    EXPECT_LE((turn * matrix_of(fa.stress_pa.col(e)) * turn.transpose() - matrix_of(fb.stress_pa.col(e))).norm(),
              1e-11 * fa.stress_pa.col(e).norm());
  EXPECT_LE(
      std::abs(largest_principal_stress(mesh, fa).stress_pa / largest_principal_stress(moved, fb).stress_pa - 1.0),
      1e-11);
}

TEST_P(FreeBody, RigidMotionStrainsNothing) {
  const TetMesh mesh = box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam());
  const ElementStresses stresses(mesh, reference_glass());
  const Eigen::VectorXd motion = klang::test::rigid_motions(mesh) * random_vector(6, 4);
  EXPECT_LE(stresses.field(motion).stress_pa.cwiseAbs().maxCoeff(), 1e-13 * 62e9);
}

TEST_P(FreeBody, AcceleratesAsTheRigidBodyOfItsMassAndInertia) {
  FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 3, 1, 2, GetParam()), reference_glass());
  const TetMesh& mesh = solver.mesh();
  const Vector3d push(3, -5, 7), at = mesh.nodes_m.row(0).transpose();
  const RigidAcceleration got = solver.acceleration(nodal_force_n(mesh, {{0, push}}));
  const double mass = 2600 * 0.03 * 0.01 * 0.02;
  const Vector3d moment = (at - Vector3d(0.015, 0.005, 0.01)).cross(push);
  const Vector3d inertia =
      mass / 12 * Vector3d(0.01 * 0.01 + 0.02 * 0.02, 0.03 * 0.03 + 0.02 * 0.02, 0.03 * 0.03 + 0.01 * 0.01);
  EXPECT_LE(std::abs(solver.mass_kg() / mass - 1.0), 1e-12);
  EXPECT_LE((got.net_force_n - push).norm(), 1e-12);
  EXPECT_LE((got.net_moment_n_m - moment).norm(), 1e-12 * moment.norm());
  EXPECT_LE((got.acceleration_m_s2 - push / mass).norm(), 1e-11 * push.norm() / mass);
  EXPECT_LE((got.spin_rad_s2 - moment.cwiseQuotient(inertia)).norm(), 1e-11 * got.spin_rad_s2.norm());
}

TEST(ElementStresses, EnergyOfCurvedElementsAddsUpToThatOfTheStiffness) {
  const TetMesh mesh = klang::mesh::mesh_shape({"sphere", {{"radius_m", 0.05}}, {}}, {.max_edge_m = 0.03});
  FreeBodySolver solver(mesh, reference_glass());
  const Eigen::VectorXd u = 1e-6 * random_vector(3 * mesh.n_nodes(), 5);
  const StressField field = solver.stresses().field(u);
  const double energy = 0.5 * u.dot(solver.stiffness_times(u).col(0));
  EXPECT_LE(std::abs(field.strain_energy_j / energy - 1.0), 1e-12);
  EXPECT_LE(std::abs(field.volume_m3.sum() / klang::mesh::mass_properties(mesh).volume_m3 - 1.0), 1e-12);
}

TEST(ElementStresses, UniformStrainIsExactInCurvedElements) {
  const TetMesh mesh = klang::mesh::mesh_shape({"sphere", {{"radius_m", 0.05}}, {}}, {.max_edge_m = 0.03});
  const ElementStresses stresses(mesh, reference_glass());
  Eigen::Matrix3d gradient;
  gradient << 1, 2, 3, 4, 5, 6, 7, 8, 10;
  gradient *= 1e-6;
  Eigen::VectorXd u(3 * mesh.n_nodes());
  for (int i = 0; i < mesh.n_nodes(); ++i) u.segment<3>(3 * i) = gradient * mesh.nodes_m.row(i).transpose();
  const StressField field = stresses.field(u);
  const StressTensor exact = stresses.stress_pa(gradient);
  EXPECT_LE((field.stress_pa.colwise() - exact).cwiseAbs().maxCoeff(), 1e-10 * exact.norm());
  EXPECT_LE((field.corner_stress_pa.colwise() - exact).cwiseAbs().maxCoeff(), 1e-10 * exact.norm());
}

TEST(StressField, PrincipalStressesAndVonMisesAreTheTextbooks) {
  StressTensor shear = StressTensor::Zero();
  shear[4] = 5.0;  // yz
  EXPECT_LE((principal_stresses_pa(shear) - Vector3d(5, 0, -5)).norm(), 1e-14);
  EXPECT_LE(std::abs(von_mises_pa(shear) - 5.0 * std::sqrt(3.0)), 1e-14);
  StressTensor uniaxial = StressTensor::Zero();
  uniaxial[1] = -7.0;
  EXPECT_LE((principal_stresses_pa(uniaxial) - Vector3d(0, 0, -7)).norm(), 1e-14);
  EXPECT_LE(std::abs(von_mises_pa(uniaxial) - 7.0), 1e-14);
}

TEST(StressField, ExtremesAreThoseOfAllElementsLookedAtOneByOne) {
  for (const int order : {1, 2}) {
    FreeBodySolver solver(box_mesh(0.03, 0.01, 0.02, 4, 2, 3, order), reference_glass());
    const TetMesh& mesh = solver.mesh();
    const StressField field =
        solver.stresses().field(solver.solve(random_vector(3 * mesh.n_nodes(), 6)).displacement_m.col(0));
    double most = -1e300, least = 1e300;
    for (int e = 0; e < mesh.n_elements(); ++e)
      for (int c = 0; c < field.n_corners(); ++c) {
        const Vector3d principal = principal_stresses_pa(field.corner(e, c));
        most = std::max(most, principal[0]);
        least = std::min(least, principal[2]);
      }
    const StressExtreme tension = largest_principal_stress(mesh, field);
    EXPECT_EQ(tension.stress_pa, most);
    EXPECT_EQ(smallest_principal_stress(mesh, field).stress_pa, least);
    EXPECT_LE(std::abs(tension.direction.norm() - 1.0), 1e-14);
    EXPECT_TRUE(breaks(tension, most));
    EXPECT_FALSE(breaks(tension, std::nextafter(most, 2 * most)));
    EXPECT_THROW(breaks(tension, 0.0), InputError);
    EXPECT_THROW(breaks(tension, std::nan("")), InputError);
  }
}

TEST(BodyStress, SlenderBodiesLargestTensionIsNotTakenForThePointForcesOwn) {
  // A beam struck from below in the middle: tension on the side across, 0.75 F L / (b h^2).
  const TetMesh mesh = box_mesh(0.2, 0.01, 0.01, 40, 4, 4, 2);
  FreeBodySolver solver(mesh, reference_glass());
  const BodyStress stress = body_stress(solver, reference_glass(), {{{0.1, 0.005, 0}, {0, 0, 100}}});
  ASSERT_TRUE(stress.usable()) << stress.message;
  const StressExtreme& body = stress.tension_is_at_a_load ? *stress.tension_elsewhere : stress.tension;
  EXPECT_LE(std::abs(body.stress_pa / (0.75 * 100 * 0.2 / 1e-6) - 1.0), 0.05);
  EXPECT_GE(body.place_m[2], 0.007);
}

TEST(BodyStress, PointForceOnASolidBodyIsToldAsTheMeshsOwn) {
  double before = 0.0;
  for (const int n : {2, 4, 8}) {
    FreeBodySolver solver(box_mesh(0.02, 0.02, 0.02, n, n, n, 2), reference_glass());
    const BodyStress stress =
        body_stress(solver, reference_glass(), {{{0.01, 0.01, 0.02}, {0, 0, 50}}, {{0.01, 0.01, 0}, {0, 0, -50}}});
    ASSERT_TRUE(stress.usable()) << stress.message;
    EXPECT_TRUE(stress.tension_is_at_a_load);
    EXPECT_FALSE(stress.warnings.empty());
    EXPECT_GE(stress.tension.stress_pa, 2.5 * before);  // as the edge's square
    before = stress.tension.stress_pa;
  }
}

TEST(FreeBodyInput, BodiesThatTouchByAnEdgeOrANodeAreRefused) {
  const auto two = [](const Vector3d& a, const Vector3d& b, std::array<int, 4> second) {
    TetMesh mesh;
    mesh.nodes_m.resize(8, 3);
    mesh.nodes_m << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, a[0], a[1], a[2], b[0], b[1], b[2], -1, -1, 0, -1, -1, -1;
    mesh.elements.resize(2, 4);
    mesh.elements << 0, 1, 2, 3, second[0], second[1], second[2], second[3];
    return mesh;
  };
  // Unused nodes at the end are dropped.
  const auto trimmed = [](TetMesh mesh, int n) {
    mesh.nodes_m.conservativeResize(n, 3);
    return mesh;
  };
  const TetMesh by_face = trimmed(two({1, 1, 1}, {0, 0, 0}, {1, 2, 3, 4}), 5);
  EXPECT_NO_THROW(FreeBodySolver(by_face, reference_glass()));
  const TetMesh by_edge = trimmed(two({0, -1, 0}, {0, 0, -1}, {0, 1, 4, 5}), 6);
  EXPECT_THROW(FreeBodySolver(by_edge, reference_glass()), InputError);
  const TetMesh by_node = trimmed(two({-1, 0, 0}, {0, -1, 0}, {0, 4, 6, 7}), 8);
  EXPECT_THROW(FreeBodySolver(by_node, reference_glass()), InputError);
  EXPECT_THROW(FreeBodySolver(trimmed(two({1, 1, 1}, {0, 0, 0}, {1, 2, 3, 4}), 6), reference_glass()), InputError);
}

TEST(FreeBodyInput, TwoBoxesJoinedAtACornerAreSeveralBodies) {
  TetMesh mesh = box_mesh(1, 1, 1, 2, 2, 2, 1);
  // The cells (0, 0, 0) and (1, 1, 1) of the eight meet in the middle alone.
  klang::mesh::IndexRows kept(12, 4);
  kept << mesh.elements.topRows(6), mesh.elements.bottomRows(6);
  mesh.elements = kept;
  std::vector<int> number(static_cast<std::size_t>(mesh.n_nodes()), -1);
  int n = 0;
  for (Eigen::Index k = 0; k < kept.size(); ++k) {
    int& node = number[static_cast<std::size_t>(kept.data()[k])];
    if (node < 0) node = n++;
    mesh.elements.data()[k] = node;
  }
  klang::mesh::Points nodes(n, 3);
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (number[static_cast<std::size_t>(i)] >= 0) nodes.row(number[static_cast<std::size_t>(i)]) = mesh.nodes_m.row(i);
  mesh.nodes_m = nodes;
  ASSERT_EQ(mesh.n_nodes(), 15);
  try {
    FreeBodySolver solver(mesh, reference_glass());
    FAIL() << "it was taken for one body";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("2 pieces"), std::string::npos) << error.what();
  }
}

TEST(FreeBodyInput, BadMaterialsAndLoadsAreRefused) {
  const TetMesh mesh = box_mesh(1, 1, 1, 1, 1, 1, 1);
  klang::solid::Material material = reference_glass();
  material.density_kg_m3 = 0.0;
  EXPECT_THROW(FreeBodySolver(mesh, material), InputError);
  material = reference_glass();
  material.lame_mu_pa = -1.0;
  EXPECT_THROW(FreeBodySolver(mesh, material), InputError);
  FreeBodySolver solver(mesh, reference_glass());
  EXPECT_THROW(solver.solve(Eigen::VectorXd::Zero(5)), InputError);
  EXPECT_THROW(solver.solve(Eigen::VectorXd::Constant(24, std::nan(""))), InputError);
  EXPECT_THROW(body_stress(solver, reference_glass(), {}), InputError);
  EXPECT_THROW(body_stress(solver, reference_glass(), {{{0, 0, 0}, {0, 0, 0}}}), InputError);
  TetMesh flat = mesh;
  flat.nodes_m.col(2).setZero();
  EXPECT_THROW(FreeBodySolver(flat, reference_glass()), InputError);
}

}  // namespace
