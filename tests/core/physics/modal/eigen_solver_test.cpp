#include "core/physics/modal/eigen_solver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using klang::mesh::TetMesh;
using klang::test::box_mesh;
using namespace klang::modal;
namespace solid = klang::solid;

const solid::Material kCeramic = solid::from_youngs_modulus(72e9, 0.19, 2700);

EigenResult solve(const TetMesh& mesh, const EigenOptions& options, const char* support_text = "free",
                  const solid::Material& material = kCeramic) {
  const solid::Support support = solid::parse_support(support_text);
  return solve_modes(mesh, solid::assemble(mesh, support), material, support, options);
}

EigenOptions lowest(int count, EigenMethod method = EigenMethod::kAuto) {
  EigenOptions options;
  options.count = count;
  options.method = method;
  return options;
}

TEST(SolveModes, DenseAndShiftInvertAgreeTo1e9) {
  const TetMesh mesh = box_mesh(0.1, 0.08, 0.02, 5, 4, 1, 2);
  const EigenResult dense = solve(mesh, lowest(12, EigenMethod::kDense));
  const EigenResult sparse = solve(mesh, lowest(12, EigenMethod::kShiftInvert));
  ASSERT_EQ(dense.status, EigenStatus::kConverged) << dense.message;
  ASSERT_EQ(sparse.status, EigenStatus::kConverged) << sparse.message;
  EXPECT_EQ(dense.method_used, EigenMethod::kDense);
  EXPECT_EQ(sparse.method_used, EigenMethod::kShiftInvert);
  for (int k = 0; k < 12; ++k) {
    EXPECT_NEAR(dense.model.angular_frequency_rad_s[k] / sparse.model.angular_frequency_rad_s[k], 1, 1e-9) << k;
  }
  EXPECT_EQ(dense.none_missing, true);
  EXPECT_EQ(sparse.none_missing, true);
}

TEST(SolveModes, ShapesAreMassNormalisedAndResidualsSmall) {
  const TetMesh mesh = box_mesh(0.1, 0.08, 0.02, 8, 6, 2, 2);
  const auto assembled = solid::assemble(mesh);
  const EigenResult result = solve_modes(mesh, assembled, kCeramic, {}, lowest(10));
  ASSERT_EQ(result.status, EigenStatus::kConverged) << result.message;
  const Eigen::MatrixXd& u = result.model.shapes;
  Eigen::MatrixXd mass_u = assembled.mass_unit_density.selfadjointView<Eigen::Lower>() * u;
  mass_u *= kCeramic.density_kg_m3;
  EXPECT_LE((u.transpose() * mass_u - Eigen::MatrixXd::Identity(10, 10)).cwiseAbs().maxCoeff(), 1e-9);
  const auto k = solid::stiffness(assembled, kCeramic.lame_lambda_pa, kCeramic.lame_mu_pa);
  for (int i = 0; i < 10; ++i) {
    const double omega_sq = std::pow(result.model.angular_frequency_rad_s[i], 2);
    const Eigen::VectorXd residual = k.selfadjointView<Eigen::Lower>() * u.col(i) - omega_sq * mass_u.col(i);
    EXPECT_LE(residual.norm() / (omega_sq * mass_u.col(i).norm()), 1e-9);
    EXPECT_NEAR(result.relative_residual[i], residual.norm() / (omega_sq * mass_u.col(i).norm()), 1e-10);
  }
}

TEST(SolveModes, NumberOfRigidModesFollowsFromSupportAndParts) {
  const TetMesh one = box_mesh(0.1, 0.05, 0.03, 3, 2, 2, 2);
  const auto rigid = [&](const TetMesh& mesh, const char* support) {
    const EigenResult result = solve(mesh, lowest(3, EigenMethod::kShiftInvert), support);
    EXPECT_EQ(result.status, EigenStatus::kConverged) << support << ": " << result.message;
    EXPECT_EQ(result.none_missing, true) << support;
    EXPECT_GT(result.model.frequency_hz()[0], 100) << support;
    return result.n_rigid_modes;
  };
  EXPECT_EQ(rigid(one, "free"), 6);
  EXPECT_EQ(rigid(one, "clamped:x=0"), 0);
  EXPECT_EQ(rigid(one, "pinned:box:0,0,0:0,0,0"), 3);     // a corner
  EXPECT_EQ(rigid(one, "pinned:box:0,0,0:0,0.05,0"), 1);  // an edge: a hinge
  TetMesh two = one;
  const Eigen::Index n = one.nodes_m.rows();
  two.nodes_m.conservativeResize(2 * n, 3);
  two.nodes_m.bottomRows(n) = one.nodes_m;
  two.nodes_m.bottomRows(n).col(2).array() += 0.1;
  two.elements.conservativeResize(2 * one.elements.rows(), 10);
  two.elements.bottomRows(one.elements.rows()) = one.elements.array() + static_cast<int>(n);
  EXPECT_EQ(rigid(two, "free"), 12);
  EXPECT_EQ(rigid(two, "clamped:z=0"), 6);
}

TEST(SolveModes, BodiesThatShareOneEdgeHaveAHingeMoreThanABody) {
  TetMesh mesh;  // two tetrahedra on a common edge
  mesh.nodes_m.resize(6, 3);
  mesh.nodes_m << 0, 0, 0, 0, 0, 1, 1, 0, 0, 0.5, 1, 0.5, -1, 0, 0, -0.5, -1, 0.5;
  mesh.elements.resize(2, 4);
  mesh.elements << 0, 2, 3, 1, 0, 4, 5, 1;
  const EigenResult result = solve(mesh, lowest(4));
  EXPECT_EQ(result.n_rigid_modes, 7);
  EXPECT_EQ(result.status, EigenStatus::kConverged) << result.message;
  EXPECT_EQ(result.none_missing, true);
}

TEST(SolveModes, CountZeroReturnsTheBandWithNothingMissing) {
  const TetMesh mesh = box_mesh(0.1, 0.08, 0.02, 8, 6, 2, 2);
  const EigenResult all = solve(mesh, lowest(20));
  ASSERT_TRUE(all.usable());
  const Eigen::VectorXd f = all.model.frequency_hz();
  EigenOptions band;
  band.band = {0.5 * (f[2] + f[3]), 0.5 * (f[11] + f[12])};
  const EigenResult some = solve(mesh, band);
  ASSERT_EQ(some.status, EigenStatus::kConverged) << some.message;
  ASSERT_EQ(some.model.n_modes(), 9);
  EXPECT_EQ(some.none_missing, true);
  EXPECT_EQ(some.sturm_count, 18);
  for (int k = 0; k < 9; ++k) EXPECT_NEAR(some.model.frequency_hz()[k] / f[k + 3], 1, 1e-9);
  EigenOptions above;
  above.count = 5;
  above.band.low_hz = band.band.low_hz;
  const EigenResult five = solve(mesh, above);
  ASSERT_EQ(five.model.n_modes(), 5);
  EXPECT_NEAR(five.model.frequency_hz()[0] / f[3], 1, 1e-9);
  EXPECT_EQ(five.none_missing, true);
  EigenOptions empty;
  empty.band = {20, 0.5 * f[0]};
  const EigenResult none = solve(mesh, empty);
  EXPECT_EQ(none.status, EigenStatus::kConverged);
  EXPECT_EQ(none.model.n_modes(), 0);
  EXPECT_EQ(none.none_missing, true);
}

TEST(SolveModes, CantileverBendsAtTheBeamFrequency) {
  // Euler-Bernoulli: f = 1.875104^2 / (2 pi) sqrt(E I / (rho A L^4)); slenderness 50 leaves 0.1 % for shear,
  // rotary inertia and the stiff root (nu = 0).
  const auto material = solid::from_youngs_modulus(70e9, 0.0, 2700);
  const EigenResult result = solve(box_mesh(0.5, 0.012, 0.01, 40, 1, 1, 2), lowest(2), "clamped:x=0", material);
  ASSERT_TRUE(result.usable()) << result.message;
  const double wave_number = 1.875104068711961 / 0.5;
  const double speed = std::sqrt(70e9 / 2700);
  const double thin = wave_number * wave_number / (2 * klang::kPi) * speed * 0.01 / std::sqrt(12);
  const double thick = wave_number * wave_number / (2 * klang::kPi) * speed * 0.012 / std::sqrt(12);
  EXPECT_EQ(result.n_rigid_modes, 0);
  EXPECT_NEAR(result.model.frequency_hz()[0] / thin, 1, 1.5e-3);
  EXPECT_NEAR(result.model.frequency_hz()[1] / thick, 1, 1.5e-3);
}

TEST(SolveModes, LameDerivativesMatchDifferences) {
  const TetMesh mesh = box_mesh(0.1, 0.08, 0.02, 5, 4, 1, 2);
  const auto assembled = solid::assemble(mesh);
  EigenOptions options = lowest(8);
  const EigenResult at = solve_modes(mesh, assembled, kCeramic, {}, options);
  const Eigen::MatrixXd derivative = eigenvalue_lame_derivatives(at.model, assembled);
  for (int parameter = 0; parameter < 2; ++parameter) {
    const double step = 1e-4 * (parameter == 0 ? kCeramic.lame_lambda_pa : kCeramic.lame_mu_pa);
    solid::Material plus = kCeramic, minus = kCeramic;
    (parameter == 0 ? plus.lame_lambda_pa : plus.lame_mu_pa) += step;
    (parameter == 0 ? minus.lame_lambda_pa : minus.lame_mu_pa) -= step;
    const Eigen::ArrayXd high =
        solve_modes(mesh, assembled, plus, {}, options).model.angular_frequency_rad_s.array().square();
    const Eigen::ArrayXd low =
        solve_modes(mesh, assembled, minus, {}, options).model.angular_frequency_rad_s.array().square();
    for (int k = 0; k < 8; ++k) {
      const double difference = (high[k] - low[k]) / (2 * step);
      const double scale = std::pow(at.model.angular_frequency_rad_s[k], 2) / kCeramic.lame_mu_pa;
      ASSERT_GT(derivative(k, parameter), 1e-4 * scale);
      EXPECT_LE(std::abs(derivative(k, parameter) - difference), 1e-6 * scale) << k << " " << parameter;
    }
  }
}

TEST(SolveModes, SameBitsOnEveryRun) {
  const TetMesh mesh = box_mesh(0.1, 0.08, 0.02, 8, 6, 2, 2);
  const EigenResult a = solve(mesh, lowest(6)), b = solve(mesh, lowest(6));
  EXPECT_EQ(a.model.angular_frequency_rad_s, b.model.angular_frequency_rad_s);
  EXPECT_EQ(a.model.shapes, b.model.shapes);
}

TEST(SolveModes, RefusesWhatItCannotDo) {
  const TetMesh mesh = box_mesh(1, 1, 1, 1, 1, 1, 1);
  EXPECT_THROW(solve(mesh, lowest(-1)), InputError);
  EXPECT_THROW(solve(mesh, lowest(19)), InputError);  // 24 degrees of freedom, 6 of them rigid
  EXPECT_NO_THROW(solve(mesh, lowest(18)));
  EigenOptions options;
  options.band = {100, 100};
  EXPECT_THROW(solve(mesh, options), InputError);
  options = {};
  options.tolerance = 0;
  EXPECT_THROW(solve(mesh, options), InputError);
  EXPECT_THROW(solve_modes(box_mesh(1, 1, 1, 2, 1, 1, 1), solid::assemble(mesh), kCeramic), InputError);
}

}  // namespace
