#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/detail/eigen_problem.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::mesh::TetMesh;
using klang::test::box_mesh;
using namespace klang::modal;
namespace solid = klang::solid;

const solid::Material kCeramic = solid::from_youngs_modulus(72e9, 0.19, 2700);

Eigen::VectorXd lowest_hz(const TetMesh& mesh, const solid::Material& material, int count) {
  EigenOptions options;
  options.count = count;
  const EigenResult result = solve_modes(mesh, solid::assemble(mesh), material, {}, options);
  EXPECT_EQ(result.status, EigenStatus::kConverged) << result.message;
  EXPECT_EQ(result.none_missing, true);
  return result.model.frequency_hz();
}

TEST(Completeness, BothMembersOfTheTilesDegeneratePairAreFound) {
  // tests/reference/free_solids.json: modes 3 and 4 both 6648.3256 Hz, 5 and 6 both 11193.5653 Hz. This coarse mesh
  // is stiffer by a few per mille, but has the square's symmetry to within its diagonal cuts.
  const Eigen::VectorXd f = lowest_hz(box_mesh(0.1, 0.1, 0.008, 14, 14, 1, 2), kCeramic, 8);
  EXPECT_NEAR(f[3] / 6648.3256, 1, 0.02);
  EXPECT_NEAR(f[4] / f[3], 1, 2e-3);
  EXPECT_NEAR(f[5] / 11193.5653, 1, 0.02);
  EXPECT_NEAR(f[6] / f[5], 1, 2e-3);
}

TEST(Completeness, PairsOfATubeAreTurnedAlikeOnOneAndOnTwoBlasThreads) {
  const auto tube =
      klang::mesh::mesh_shape({"tube", {{"length_m", 0.08}, {"outer_radius_m", 0.02}, {"wall_m", 0.004}}, {}});
  EigenOptions options;
  options.count = 6;
  std::vector<Eigen::MatrixXd> shapes;
  for (const int threads : {1, 2}) {
    const klang::BlasThreads blas(threads);
    const EigenResult result = solve_modes(tube, solid::assemble(tube), kCeramic, {}, options);
    EXPECT_LE(result.model.angular_frequency_rad_s[1] / result.model.angular_frequency_rad_s[0] - 1.0, 1e-8)
        << "a pair";
    shapes.push_back(result.model.shapes);
  }
  EXPECT_LE((shapes[0] - shapes[1]).norm() / shapes[0].norm(), 1e-5);
}

TEST(Completeness, FivefoldAndThreefoldModesOfTheBallAreFoundWhole) {
  // tests/reference/sphere_lamb.json: multiplicities 5, 5, 3 of the first three eigenvalues.
  const auto steel = solid::from_youngs_modulus(200e9, 0.29, 7850);
  const Eigen::VectorXd f = lowest_hz(klang::mesh::mesh_shape({"sphere", {{"radius_m", 0.03}}, {}}), steel, 13);
  for (int k = 0; k < 13; ++k) {
    const double exact = k < 5 ? 41697.10601444799 : k < 10 ? 44095.671685478315 : 58507.821851427754;
    EXPECT_NEAR(f[k] / exact, 1, 2e-3) << k;
  }
}

TEST(Completeness, ALostMemberOfAPairIsCountedAndFoundAgain) {
  const TetMesh mesh = box_mesh(0.1, 0.1, 0.02, 4, 4, 1, 2);
  const auto assembled = solid::assemble(mesh);
  detail::EigenProblem problem(mesh, assembled, kCeramic);
  std::string message;
  ASSERT_TRUE(problem.factor(message)) << message;
  const detail::Pairs whole = problem.lowest(8, 1e-10, 100, {}, 0);
  ASSERT_TRUE(whole.converged);
  const double gap = detail::gap_above(whole, 5);
  ASSERT_GT(gap, whole.value[4]);

  for (const int lost : {0, 3}) {  // 3 and 4 are the pair
    detail::Pairs pairs;
    pairs.converged = true;
    pairs.value.resize(7);
    pairs.vector.resize(whole.vector.rows(), 7);
    for (int k = 0; k < 7; ++k) {
      pairs.value[k] = whole.value[k < lost ? k : k + 1];
      pairs.vector.col(k) = whole.vector.col(k < lost ? k : k + 1);
    }
    detail::Pairs unrepaired = pairs;
    const detail::Proof denied = detail::prove(problem, unrepaired, gap, 1e-10, 100, 0);
    EXPECT_EQ(denied.none_missing, false);
    EXPECT_EQ(*denied.sturm_count, 6 + denied.n_found_below + 1);
    const detail::Proof proven = detail::prove(problem, pairs, gap, 1e-10, 100, 2);
    EXPECT_EQ(proven.none_missing, true);
    ASSERT_EQ(pairs.size(), 8);
    for (int k = 0; k < 8; ++k) EXPECT_NEAR(pairs.value[k] / whole.value[k], 1, 1e-9) << k;
  }
}

TEST(Completeness, AnInventedModeIsCountedToo) {
  const TetMesh mesh = box_mesh(0.1, 0.1, 0.02, 4, 4, 1, 2);
  const auto assembled = solid::assemble(mesh);
  detail::EigenProblem problem(mesh, assembled, kCeramic);
  std::string message;
  ASSERT_TRUE(problem.factor(message)) << message;
  detail::Pairs pairs = problem.lowest(6, 1e-10, 100, {}, 0);
  const double gap = detail::gap_above(pairs, 5);
  ASSERT_GT(gap, 0);
  pairs = detail::merged(pairs, {pairs.value.head(1), pairs.vector.leftCols(1), true, ""});
  EXPECT_EQ(detail::prove(problem, pairs, gap, 1e-10, 100, 2).none_missing, false);
}

TEST(Completeness, AGapIsSureOnceItIsTenTimesAsWideAsItsEndsMayBeOff) {
  const Eigen::Vector4d value(1.0, 2.0, 2.4, 2.5);
  Eigen::Vector4d error(1e-3, 1e-3, 0.05, 0.1);
  EXPECT_EQ(detail::sure_gap_above(value, error, 2), 0.0);  // 2 to 2.4: 0.05 is too much
  error[2] = 0.039;
  EXPECT_DOUBLE_EQ(detail::sure_gap_above(value, error, 2), std::sqrt(2.0 * 2.4));
  EXPECT_DOUBLE_EQ(detail::sure_gap_above(value, error, 1), std::sqrt(1.0 * 2.0));
}

// The count is made while the search goes on, from values that are not yet what they become.
TEST(Completeness, ACountMadeDuringTheSearchIsOfTheValuesThatItEndsWith) {
  const TetMesh mesh = box_mesh(0.1, 0.1, 0.008, 26, 26, 2, 2);
  ASSERT_GE(mesh.n_nodes(), 4000) << "blocks of vectors";
  const auto assembled = solid::assemble(mesh);
  detail::EigenProblem problem(mesh, assembled, kCeramic);
  std::string message;
  ASSERT_TRUE(problem.factor(message)) << message;
  double early = 0.0;
  const detail::Pairs pairs =
      problem.lowest_block(14, 8, 1e-10, 100, [&](const Eigen::VectorXd& value, const Eigen::VectorXd& error) {
        if (early == 0.0) early = detail::sure_gap_above(value, error, 10);
      });
  ASSERT_TRUE(pairs.converged);
  ASSERT_GT(early, 0.0);
  EXPECT_EQ(*problem.n_below(early), 6 + (pairs.value.array() < early).count());
  lowest_hz(mesh, kCeramic, 10);  // proven
}

TEST(Completeness, BlockAndOneVectorLanczosAgreeTo1e9) {
  const TetMesh mesh = box_mesh(0.1, 0.1, 0.008, 10, 10, 1, 2);
  const auto assembled = solid::assemble(mesh);
  detail::EigenProblem problem(mesh, assembled, kCeramic);
  std::string message;
  ASSERT_TRUE(problem.factor(message)) << message;
  const detail::Pairs one = problem.lowest(14, 1e-10, 100, {}, 0);
  const detail::Pairs block = problem.lowest_block(14, 8, 1e-10, 100);
  ASSERT_TRUE(one.converged);
  ASSERT_TRUE(block.converged);
  for (int k = 0; k < 14; ++k) EXPECT_NEAR(block.value[k] / one.value[k], 1, 1e-9) << k;
}

}  // namespace
