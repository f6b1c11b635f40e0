#include <gtest/gtest.h>

#include <cmath>

#include "../solid/box_mesh.hpp"
#include "core/base/conventions.hpp"
#include "core/mesh/shape.hpp"
#include "core/modal/eigen_solver.hpp"
#include "datasets-synthetic/ritz_box.hpp"

namespace {

using klang::mesh::TetMesh;
using klang::test::box_mesh;
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

TEST(EigenvalueOrder, LinearElementsConvergeAtOrderTwo) {
  // First mode of a cube, against a Ritz method that shares nothing with the elements.
  klang::datasets::RitzBoxOptions ritz;
  ritz.orders = {14, 14, 14};
  ritz.highest_hz = 40000;
  const klang::datasets::RitzBox exact(Eigen::Vector3d::Constant(0.05), kAluminium, ritz);
  const double exact_hz = exact.angular_frequency_rad_s()[0] / (2 * klang::kPi);
  const std::vector<int> cells = {6, 8, 11, 16};
  std::vector<double> error;
  for (const int n : cells) {
    error.push_back(lowest_hz(box_mesh(0.05, 0.05, 0.05, n, n, n, 1), kAluminium, 3)[0] / exact_hz - 1);
  }
  EXPECT_NEAR(observed_order(cells, error), 2, 0.3);
  EXPECT_GT(error.back(), 1e-5);
}

TEST(TubeModes, BendingPairsMatchRitzWithin200PpmOnARefinedMesh) {
  // reference/chimes.json: tubes[1].ritz3d_bending (0.353 m).
  const klang::mesh::ShapeSpec tube{
      "tube", {{"length_m", 0.353}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
  const Eigen::VectorXd f =
      lowest_hz(klang::mesh::mesh_shape(tube, klang::mesh::ShapeDivisions{{48, 24, 1}}, 2), kAluminium, 8);
  for (const double exact : {1185.4672628861772, 3095.019228731142}) {
    const auto n_near = ((f.array() / exact - 1).abs() <= 2e-4).count();
    EXPECT_EQ(n_near, 2) << exact;
  }
}

}  // namespace
