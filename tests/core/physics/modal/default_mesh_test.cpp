#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/physics/modal/eigen_solver.hpp"
#include "tests/core/physics/modal/reference_bodies.hpp"

// What `klang modes` gives without a word about the mesh.
namespace {

using namespace klang::modal;
namespace mesh = klang::mesh;
namespace solid = klang::solid;
using klang::test::ReferenceBody;

EigenResult solve_on_default_mesh(const ReferenceBody& body, const EigenOptions& options) {
  const mesh::TetMesh tets = mesh::mesh_shape(body.shape);
  EigenResult result = solve_modes(tets, solid::assemble(tets), body.material, {}, options);
  EXPECT_EQ(result.status, EigenStatus::kConverged) << result.message;
  EXPECT_EQ(result.none_missing, true);
  EXPECT_EQ(result.n_rigid_modes, 6);
  return result;
}

// Index by index: a lost or invented member of a multiple frequency shifts all that follow.
void expect_first_15_within_500_ppm(const ReferenceBody& body) {
  EigenOptions options;
  options.count = 15;
  const Eigen::VectorXd f = solve_on_default_mesh(body, options).model.frequency_hz();
  ASSERT_EQ(f.size(), 15);
  for (int k = 0; k < 15; ++k)
    EXPECT_LE(std::abs(f[k] / body.frequency_hz[static_cast<std::size_t>(k)] - 1), 5e-4) << "mode " << k;
}

TEST(DefaultMesh, First15ModesOfABallWithin500Ppm) { expect_first_15_within_500_ppm(klang::test::reference_ball()); }
TEST(DefaultMesh, First15ModesOfATileWithin500Ppm) { expect_first_15_within_500_ppm(klang::test::reference_tile()); }
TEST(DefaultMesh, First15ModesOfABlockWithin500Ppm) { expect_first_15_within_500_ppm(klang::test::reference_block()); }

// No exact values of these are at hand; the estimate lies within a fifth of the true error (mesh_error_test.cpp).
double largest_estimated_error(const mesh::ShapeSpec& shape) {
  const mesh::TetMesh tets = mesh::mesh_shape(shape);
  EigenOptions options;
  options.count = 15;
  options.prove_none_missing = false;
  options.estimate_mesh_error = true;
  const EigenResult result =
      solve_modes(tets, solid::assemble(tets), solid::from_youngs_modulus(200e9, 0.29, 7850), {}, options);
  EXPECT_EQ(result.status, EigenStatus::kConverged) << result.message;
  return result.mesh_relative_error->maxCoeff();
}

TEST(DefaultMesh, First15ModesOfFlatBarsAreEstimatedWithin500Ppm) {
  EXPECT_LE(largest_estimated_error({"box", {{"length_m", 0.15}, {"width_m", 0.025}, {"height_m", 0.01}}, {}}), 5e-4);
  EXPECT_LE(largest_estimated_error({"box", {{"length_m", 0.3}, {"width_m", 0.03}, {"height_m", 0.005}}, {}}), 5e-4);
}

// Share of a mode's motion in which sections of the tube move sideways as a whole: bending. Ring modes, torsion and
// stretching have none.
double bending_share(const mesh::TetMesh& tets, const Eigen::VectorXd& shape) {
  std::map<long, std::pair<Eigen::Vector2d, int>> section;  // by z in steps of 1 um
  const auto level = [&](int node) { return std::lround(1e6 * tets.nodes_m(node, 2)); };
  for (int i = 0; i < tets.n_nodes(); ++i) {
    auto& [sum, count] = section.try_emplace(level(i), Eigen::Vector2d::Zero(), 0).first->second;
    sum += shape.segment<2>(3 * i);
    ++count;
  }
  double sideways = 0;
  for (const auto& [z, s] : section) sideways += s.first.squaredNorm() / s.second;
  return sideways / shape.squaredNorm();
}

void expect_six_bending_pairs_within_200_ppm(double length_m) {
  const ReferenceBody tube = klang::test::reference_tube(length_m);
  EigenOptions options;
  options.band.high_hz = 1.01 * tube.frequency_hz.back();
  const EigenResult result = solve_on_default_mesh(tube, options);
  const Eigen::VectorXd f = result.model.frequency_hz();
  std::vector<double> bending;
  for (Eigen::Index k = 0; k < f.size(); ++k) {
    const double share = bending_share(result.model.mesh, result.model.shapes.col(k));
    EXPECT_TRUE(share < 0.1 || share > 0.4) << "mode " << k << " at " << f[k] << " Hz: " << share;
    if (share > 0.4) bending.push_back(f[k]);
  }
  ASSERT_EQ(bending.size(), 12U);
  for (std::size_t k = 0; k < bending.size(); ++k)
    EXPECT_LE(std::abs(bending[k] / tube.frequency_hz[k / 2] - 1), 2e-4) << "bending mode " << k;
}

TEST(DefaultMesh, SixBendingPairsOfTheLongTubeWithin200Ppm) { expect_six_bending_pairs_within_200_ppm(0.505); }
TEST(DefaultMesh, SixBendingPairsOfTheShortTubeWithin200Ppm) { expect_six_bending_pairs_within_200_ppm(0.353); }

}  // namespace
