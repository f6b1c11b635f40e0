#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "tests/core/physics/modal/reference_bodies.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::mesh::TetMesh;
using klang::test::box_mesh;
using klang::test::ReferenceBody;
using namespace klang::modal;
namespace solid = klang::solid;

const solid::Material kAluminium{4.98e10, 2.57e10, 2700, "", ""};

Eigen::VectorXd lowest_hz(const TetMesh& mesh, const solid::Material& material, int count) {
  EigenOptions options;
  options.count = count;
  const EigenResult result = solve_modes(mesh, solid::assemble(mesh), material, {}, options);
  EXPECT_EQ(result.status, EigenStatus::kConverged) << result.message;
  EXPECT_EQ(result.none_missing, true);
  return result.model.frequency_hz();
}

// Least-squares slope of log(error) over log(h) of four meshes.
double observed_order(const std::vector<int>& cells, const std::vector<double>& error) {
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < error.size(); ++i) {
    if (i > 0) {
      EXPECT_LT(error[i], error[i - 1]);
    }
    const double x = -std::log(cells[i]), y = std::log(error[i]);
    sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const auto m = static_cast<double>(error.size());
  return (m * sxy - sx * sy) / (m * sxx - sx * sx);
}

TEST(EigenvalueOrder, QuadraticElementsConvergeAtOrderFour) {
  // Longitudinal waves of a free bar without Poisson effect: c / (2 L) exactly. It lies alone between the
  // second bending pair and the second torsional mode.
  const auto material = solid::from_youngs_modulus(70e9, 0.0, 2700);
  const double exact_hz = std::sqrt(70e9 / 2700) / (2 * 0.1);
  const std::vector<int> cells = {4, 6, 8, 12};
  std::vector<double> error;
  for (const int n : cells) {
    const Eigen::VectorXd f = lowest_hz(box_mesh(0.1, 0.016, 0.016, n, 2, 2, 2), material, 10);
    Eigen::Index nearest = 0;
    (f.array() / exact_hz - 1).abs().minCoeff(&nearest);
    error.push_back(f[nearest] / exact_hz - 1);
  }
  EXPECT_NEAR(observed_order(cells, error), 4, 0.4);
  EXPECT_GT(error.back(), 1e-8);  // above round-off
}

// Orders of the first n_groups groups of `multiplicity` modes (their mean error) over meshes whose divisions are all in
// proportion to `cells`.
std::vector<double> observed_orders(const ReferenceBody& body, const std::vector<std::array<int, 3>>& divisions,
                                    int order, int n_groups, int multiplicity, bool references_repeat) {
  std::vector<int> cells;
  std::vector<std::vector<double>> error(static_cast<std::size_t>(n_groups));
  for (const auto& n : divisions) {
    cells.push_back(n[0]);
    const Eigen::VectorXd f = lowest_hz(klang::mesh::mesh_shape(body.shape, klang::mesh::ShapeDivisions{n}, order),
                                        body.material, n_groups * multiplicity);
    for (int g = 0; g < n_groups; ++g) {
      const double exact = body.frequency_hz[static_cast<std::size_t>(references_repeat ? g * multiplicity : g)];
      error[static_cast<std::size_t>(g)].push_back(f.segment(g * multiplicity, multiplicity).mean() / exact - 1);
    }
  }
  std::vector<double> result;
  for (const auto& e : error) {
    EXPECT_GT(e.back(), 1e-5);  // the references are right to 3e-7 or better
    result.push_back(observed_order(cells, e));
  }
  return result;
}

// Coarser meshes than these are short of the asymptotic range: from 4 to 6 cells a side the block's orders are 3.4 to
// 3.6, and they rise with every level (3.8 from 8 to 12).
TEST(EigenvalueOrder, QuadraticElementsConvergeAtOrderFourOnABlock) {
  for (const double order :
       observed_orders(klang::test::reference_block(), {{6, 6, 6}, {7, 7, 7}, {8, 8, 8}, {10, 10, 10}}, 2, 4, 1, false))
    EXPECT_NEAR(order, 4, 0.4);
}

TEST(EigenvalueOrder, CurvedQuadraticElementsConvergeAtOrderFourOnABall) {
  for (const double order :
       observed_orders(klang::test::reference_ball(), {{2, 2, 1}, {3, 3, 1}, {4, 4, 1}, {5, 5, 1}}, 2, 1, 5, true))
    EXPECT_NEAR(order, 4, 0.4);
}

TEST(EigenvalueOrder, CurvedQuadraticElementsConvergeAtOrderFourOnATube) {
  for (const double order : observed_orders(klang::test::reference_tube(0.353),
                                            {{16, 16, 1}, {20, 20, 1}, {24, 24, 1}, {32, 32, 1}}, 2, 2, 2, false))
    EXPECT_NEAR(order, 4, 0.4);
}

TEST(EigenvalueOrder, LinearElementsConvergeAtOrderTwoOnABlock) {
  for (const double order : observed_orders(klang::test::reference_block(),
                                            {{8, 8, 8}, {10, 10, 10}, {12, 12, 12}, {16, 16, 16}}, 1, 4, 1, false))
    EXPECT_NEAR(order, 2, 0.3);
}

TEST(EigenvalueOrder, LinearElementsConvergeAtOrderTwoOnABall) {
  for (const double order :
       observed_orders(klang::test::reference_ball(), {{3, 3, 1}, {4, 4, 1}, {5, 5, 1}, {6, 6, 1}}, 1, 2, 5, true))
    EXPECT_NEAR(order, 2, 0.3);
}

TEST(TubeModes, BendingPairsMatchRitzWithin200PpmOnARefinedMesh) {
  // tests/reference/chimes.json: tubes[1].ritz3d_bending (0.353 m).
  const klang::mesh::ShapeSpec tube{"tube", {{"length_m", 0.353}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
  const Eigen::VectorXd f =
      lowest_hz(klang::mesh::mesh_shape(tube, klang::mesh::ShapeDivisions{{48, 24, 1}}, 2), kAluminium, 8);
  for (const double exact : {1185.4672628861772, 3095.019228731142}) {
    const auto n_near = ((f.array() / exact - 1).abs() <= 2e-4).count();
    EXPECT_EQ(n_near, 2) << exact;
  }
}

}  // namespace
