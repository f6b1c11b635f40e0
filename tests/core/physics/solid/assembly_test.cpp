#include "core/physics/solid/assembly.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using klang::mesh::TetMesh;
using namespace klang::solid;
using klang::test::box_mesh;

Eigen::MatrixXd full(const SparseMatrix& lower) {
  return Eigen::MatrixXd(SparseMatrix(lower.selfadjointView<Eigen::Lower>()));
}

// tests/reference/static.json: t4_element (lambda 7, mu 5, rho 3).
TetMesh reference_element() {
  TetMesh mesh;
  mesh.nodes_m.resize(4, 3);
  mesh.nodes_m << 0, 0, 0, 2, 0, 0, 0.5, 3, 0, 1, 1, 4;
  mesh.elements.resize(1, 4);
  mesh.elements << 0, 1, 2, 3;
  return mesh;
}

TEST(ElementStiffness, HasNoFactorHalf) {
  // K_exact of tests/reference/static.json: t4_element. The paper's eq. 12 prints -1/2 of it.
  Eigen::Matrix<double, 12, 12> expected;
  expected << 1173. / 64, 6, 3. / 2, -1053. / 64, -4. / 3, 5. / 6, -25. / 16, -14. / 3, 7. / 6, -5. / 16, 0, -7. / 2, 6,
      597. / 64, 3. / 4, -8. / 3, -221. / 64, 5. / 6, -10. / 3, -89. / 16, 1. / 6, 0, -5. / 16, -7. / 4, 3. / 2, 3. / 4,
      417. / 64, 1. / 6, 2. / 3, -265. / 64, 5. / 6, -1. / 6, -21. / 16, -5. / 2, -5. / 4, -17. / 16, -1053. / 64,
      -8. / 3, 1. / 6, 9997. / 576, -2, -5. / 2, -55. / 144, 14. / 3, -7. / 6, -25. / 48, 0, 7. / 2, -4. / 3,
      -221. / 64, 2. / 3, -2, 3277. / 576, 5. / 12, 10. / 3, -247. / 144, -1. / 2, 0, -25. / 48, -7. / 12, 5. / 6,
      5. / 6, -265. / 64, -5. / 2, 5. / 12, 3385. / 576, -5. / 6, -5. / 6, 5. / 144, 5. / 2, -5. / 12, -85. / 48,
      -25. / 16, -10. / 3, 5. / 6, -55. / 144, 10. / 3, -5. / 6, 85. / 36, 0, 0, -5. / 12, 0, 0, -14. / 3, -89. / 16,
      -1. / 6, 14. / 3, -247. / 144, -5. / 6, 0, 277. / 36, -4. / 3, 0, -5. / 12, 7. / 3, 7. / 6, 1. / 6, -21. / 16,
      -7. / 6, -1. / 2, 5. / 144, 0, -4. / 3, 97. / 36, 0, 5. / 3, -17. / 12, -5. / 16, 0, -5. / 2, -25. / 48, 0,
      5. / 2, -5. / 12, 0, 0, 5. / 4, 0, 0, 0, -5. / 16, -5. / 4, 0, -25. / 48, -5. / 12, 0, -5. / 12, 5. / 3, 0,
      5. / 4, 0, -7. / 2, -7. / 4, -17. / 16, 7. / 2, -7. / 12, -85. / 48, 0, 7. / 3, -17. / 12, 0, 0, 17. / 4;
  const AssembledSolid solid = assemble(reference_element());
  const Eigen::MatrixXd k = full(stiffness(solid, 7, 5));
  EXPECT_LE((k - expected).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_NEAR(k.trace(), 82.59375, 1e-12);
}

TEST(ElementMass, ConsistentAndLumpedAreTheExactOnes) {
  const Eigen::MatrixXd consistent = 3 * full(assemble(reference_element()).mass_unit_density);
  const Eigen::MatrixXd lumped = 3 * full(assemble(reference_element(), {}, MassKind::kLumped).mass_unit_density);
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      EXPECT_NEAR(consistent(i, j), i == j ? 1.2 : i % 3 == j % 3 ? 0.6 : 0.0, 1e-14);
      EXPECT_NEAR(lumped(i, j), i == j ? 3.0 : 0.0, 1e-14);
    }
  }
}

TEST(ElementMass, StraightQuadraticElementIsExact) {
  // int N_i N_j over a straight quadratic tetrahedron of volume V: 6 V / 2520 times these integers.
  const TetMesh mesh = klang::test::box_mesh(1, 1, 1, 1, 1, 1, 2);
  TetMesh one;
  one.nodes_m.resize(10, 3);
  one.elements.resize(1, 10);
  for (int i = 0; i < 10; ++i) {
    one.nodes_m.row(i) = mesh.nodes_m.row(mesh.elements(0, i));
    one.elements(0, i) = i;
  }
  const double unit = (1.0 / 6.0) / 420;
  const Eigen::MatrixXd m = full(assemble(one).mass_unit_density);
  EXPECT_NEAR(m(0, 0), 6 * unit, 1e-8 * unit);     // corner with itself
  EXPECT_NEAR(m(0, 3), 1 * unit, 1e-8 * unit);     // corner with corner
  EXPECT_NEAR(m(0, 12), -4 * unit, 1e-8 * unit);   // corner with its own edge
  EXPECT_NEAR(m(0, 15), -6 * unit, 1e-8 * unit);   // corner with an edge across
  EXPECT_NEAR(m(12, 12), 32 * unit, 1e-8 * unit);  // edge with itself
  EXPECT_NEAR(m(12, 15), 16 * unit, 1e-8 * unit);  // edges that share a corner
  EXPECT_NEAR(m(12, 27), 8 * unit, 1e-8 * unit);   // opposite edges
}

class AssemblyOfOrder : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Elements, AssemblyOfOrder, testing::Values(1, 2));

TEST_P(AssemblyOfOrder, StiffnessNullSpaceIsTheSixRigidMotions) {
  const AssembledSolid solid = assemble(box_mesh(0.1, 0.05, 0.03, 2, 2, 1, GetParam()));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(full(stiffness(solid, 7, 5)));
  const double scale = eigen.eigenvalues().tail(1)(0);
  for (int i = 0; i < 6; ++i) EXPECT_LE(std::abs(eigen.eigenvalues()(i)), 1e-14 * scale) << i;
  EXPECT_GE(eigen.eigenvalues()(6), 1e-5 * scale);
}

TEST_P(AssemblyOfOrder, TotalMassIsTheVolumeForEitherMass) {
  const TetMesh mesh = box_mesh(0.1, 0.05, 0.03, 3, 2, 2, GetParam());
  for (const MassKind kind : {MassKind::kConsistent, MassKind::kLumped}) {
    const AssembledSolid solid = assemble(mesh, {}, kind);
    Eigen::VectorXd x_translation = Eigen::VectorXd::Zero(solid.n_dofs());
    for (Eigen::Index i = 0; i < solid.n_dofs(); i += 3) x_translation[i] = 1;
    const double volume = x_translation.dot(solid.mass_unit_density.selfadjointView<Eigen::Lower>() * x_translation);
    EXPECT_NEAR(volume, 0.1 * 0.05 * 0.03, 1e-14);
    EXPECT_GT(solid.mass_unit_density.diagonal().minCoeff(), 0);
  }
}

TEST_P(AssemblyOfOrder, UniformStrainHasItsExactEnergy) {
  // u = G x: energy V/2 (lambda (tr e)^2 + 2 mu e:e) whatever the mesh.
  const TetMesh mesh = box_mesh(0.1, 0.02, 0.03, 3, 2, 2, GetParam());
  const AssembledSolid solid = assemble(mesh);
  Eigen::Matrix3d gradient;
  gradient << 1, 0.3, -0.2, 0.5, -0.7, 0.1, 0.4, 0.25, 0.6;
  Eigen::VectorXd u(solid.n_dofs());
  for (int i = 0; i < mesh.n_nodes(); ++i) u.segment<3>(3 * i) = gradient * mesh.nodes_m.row(i).transpose();
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  const double lambda = 17222222222.22222, mu = 25833333333.333336, volume = 0.1 * 0.02 * 0.03;
  const double expected = volume / 2 * (lambda * std::pow(strain.trace(), 2) + 2 * mu * strain.squaredNorm());
  const double energy = 0.5 * u.dot(stiffness(solid, lambda, mu).selfadjointView<Eigen::Lower>() * u);
  EXPECT_NEAR(energy / expected, 1, 1e-12);
}

TEST_P(AssemblyOfOrder, HasTheSameBitsOnOneAndOnManyThreads) {
  const TetMesh mesh = box_mesh(0.1, 0.05, 0.03, 9, 7, 5, GetParam());
  const AssembledSolid many = assemble(mesh);
  klang::set_thread_count(1);
  const AssembledSolid one = assemble(mesh);
  klang::set_thread_count(0);
  ASSERT_EQ(one.stiffness_mu.nonZeros(), many.stiffness_mu.nonZeros());
  for (Eigen::Index k = 0; k < one.stiffness_mu.nonZeros(); ++k) {
    ASSERT_EQ(one.stiffness_mu.valuePtr()[k], many.stiffness_mu.valuePtr()[k]);
    ASSERT_EQ(one.stiffness_lambda.valuePtr()[k], many.stiffness_lambda.valuePtr()[k]);
    ASSERT_EQ(one.mass_unit_density.valuePtr()[k], many.mass_unit_density.valuePtr()[k]);
  }
}

TEST_P(AssemblyOfOrder, HeldNodesAreTheFullMatrixWithoutThem) {
  const TetMesh mesh = box_mesh(0.1, 0.05, 0.03, 2, 2, 2, GetParam());
  const Eigen::MatrixXd all = full(stiffness(assemble(mesh), 3, 2));
  const AssembledSolid clamped = assemble(mesh, parse_support("clamped:x=0"));
  const Eigen::MatrixXd part = full(stiffness(clamped, 3, 2));
  ASSERT_LT(clamped.free_nodes.size(), static_cast<std::size_t>(mesh.n_nodes()));
  for (std::size_t i = 0; i < clamped.free_nodes.size(); ++i) {
    for (std::size_t j = 0; j < clamped.free_nodes.size(); ++j) {
      const Eigen::Matrix3d expected = all.block<3, 3>(3 * clamped.free_nodes[i], 3 * clamped.free_nodes[j]);
      EXPECT_LE((part.block<3, 3>(3 * i, 3 * j) - expected).cwiseAbs().maxCoeff(), 1e-15 * all.cwiseAbs().maxCoeff());
    }
  }
}

TEST(Assembly, NamesTheFirstElementThatIsInsideOut) {
  for (const int order : {1, 2}) {
    TetMesh mesh = box_mesh(1, 1, 1, 4, 4, 4, order);
    mesh.elements.row(300).head(2).reverseInPlace();
    mesh.elements.row(37).head(2).reverseInPlace();
    try {
      assemble(mesh);
      FAIL() << "order " << order;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("element 37 "), std::string::npos) << error.what();
    }
  }
}

TEST(Assembly, RefusesIndicesOutOfRangeAndNaN) {
  TetMesh mesh = reference_element();
  mesh.elements(0, 3) = 4;
  EXPECT_THROW(assemble(mesh), InputError);
  mesh = reference_element();
  mesh.nodes_m(2, 1) = std::nan("");
  EXPECT_THROW(assemble(mesh), InputError);
  EXPECT_THROW(assemble(reference_element(), parse_support("clamped:x>-1")), InputError);
}

}  // namespace
