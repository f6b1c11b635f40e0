#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/modal/ellipsoid_modes.hpp"
#include "core/physics/modal/ellipsoid_solve.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/solid/material.hpp"

using namespace klang;
using modal::EllipsoidModes;

namespace {
solid::Material glass() { return solid::from_youngs_modulus(6.2e10, 0.2, 2600.0); }
}  // namespace

TEST(EllipsoidModes, BallHasLambsFrequenciesAndMultiplicities) {
  const solid::Material material = solid::from_youngs_modulus(1e10, 0.29, 1000.0);
  const EllipsoidModes modes({0.3, 0.3, 0.3}, material, {14, 12});
  // tests/reference/sphere_lamb.json: steel-like, nu = 0.29
  const std::pair<double, int> expected[] = {{2.501132620409397, 5}, {2.64500665425552, 5},  {3.509495880385619, 3},
                                             {3.864699778223047, 7}, {3.933378897104085, 7}, {4.86995540349663, 1}};
  std::size_t at = 0;
  const std::vector<modal::ModeId> ids = modes.lowest(28);
  ASSERT_EQ(ids.size(), 28U);
  for (const auto& [x, count] : expected)
    for (int i = 0; i < count; ++i, ++at) {
      const double found = modes.angular_frequency_rad_s(ids[at]) * 0.3 / material.shear_speed_m_s();
      EXPECT_LE(std::abs(found / x - 1.0), 1e-7) << at;
    }
}

TEST(EllipsoidModes, AgreeWithTetrahedra) {
  const solid::Material material = glass();
  const BlasThreads one(1);
  mesh::ShapeMeshOptions coarse;
  coarse.wavelength_m = 0.04;  // some 1000 nodes
  const mesh::TetMesh body =
      mesh::mesh_shape({"ellipsoid", {{"a_m", 0.012}, {"b_m", 0.02}, {"c_m", 0.03}}, {}}, coarse);
  ASSERT_LE(body.n_nodes(), 6000);
  modal::EigenOptions options;
  options.count = 10;
  const auto tetrahedra = modal::solve_modes(body, solid::assemble(body), material, {}, options);
  ASSERT_TRUE(tetrahedra.usable()) << tetrahedra.message;
  const EllipsoidModes modes({0.012, 0.02, 0.03}, material);
  const auto ids = modes.lowest(10);
  for (int i = 0; i < 10; ++i)
    EXPECT_LE(std::abs(modes.angular_frequency_rad_s(ids[i]) / tetrahedra.model.angular_frequency_rad_s[i] - 1.0), 5e-3)
        << i;
}

// errata 41 and SB eq. 9: omega -> omega / gamma, U -> gamma^-3/2 U.
TEST(EllipsoidModes, ScaledBodySolvedAnewHasTheScaledFrequenciesToTenDigits) {
  for (const Eigen::Vector3d& axes :
       {Eigen::Vector3d(0.5, 0.7, 1.0), Eigen::Vector3d(0.04, 0.3, 1.0), Eigen::Vector3d(0.04, 0.05, 1.0)}) {
    const double gamma = 0.0371;
    const EllipsoidModes unit(axes, glass()), scaled(gamma * axes, glass());
    const Eigen::Matrix3Xd at = Eigen::Vector3d(0.3, 0.5, 0.6);
    for (const auto& id : unit.lowest(10)) {
      EXPECT_LE(std::abs(scaled.angular_frequency_rad_s(id) * gamma / unit.angular_frequency_rad_s(id) - 1.0), 1e-10);
      const Eigen::Vector3d u = unit.shape_at(id, at), s = scaled.shape_at(id, at) * std::pow(gamma, 1.5);
      EXPECT_LE(std::min((u - s).norm(), (u + s).norm()), 1e-5 * (u.norm() + 1.0));
    }
  }
}

TEST(EllipsoidModes, FrequenciesFallWithTheDegree) {
  double before = HUGE_VAL;
  for (const int degree : {6, 8, 10, 12}) {
    const EllipsoidModes modes({0.1, 0.4, 1.0}, glass(), {degree, 6});
    const double now = modes.angular_frequency_rad_s(modes.lowest(10).back());
    EXPECT_LE(now, before * (1.0 + 1e-12));
    before = now;
  }
}

TEST(EllipsoidModes, SwappedAxesSwapTheClasses) {
  const EllipsoidModes first({0.3, 0.5, 1.0}, glass()), second({0.5, 0.3, 1.0}, glass());
  for (int c = 0; c < modal::kModeClasses; ++c) {
    const int swapped = (c & 4) | (c & 1) << 1 | (c >> 1 & 1);
    EXPECT_LE((first.angular_frequency_rad_s(c).head(4) - second.angular_frequency_rad_s(swapped).head(4)).norm(),
              1e-9 * first.angular_frequency_rad_s(c).head(4).norm());
  }
}

TEST(EllipsoidSolve, First15ModesOfThreeBodiesLieBelowTheirBoundsAndWithinAHundredThousandth) {
  for (const Eigen::Vector3d& axes_m :
       {Eigen::Vector3d(0.012, 0.02, 0.03), Eigen::Vector3d(0.03, 0.05, 0.055), Eigen::Vector3d(0.004, 0.015, 0.03)}) {
    const mesh::ShapeSpec shape{"ellipsoid", {{"a_m", axes_m.x()}, {"b_m", axes_m.y()}, {"c_m", axes_m.z()}}, {}};
    const mesh::TetMesh body = mesh::mesh_shape(shape, mesh::ShapeDivisions{{2, 2, 1}}, 2);
    modal::ModesOptions options;
    options.eigen.count = 15;
    options.eigen.estimate_mesh_error = true;
    const modal::EigenResult found = modal::modes_of({shape, {}, 2}, body, glass(), options);
    ASSERT_TRUE(found.usable()) << found.message;
    EXPECT_EQ(found.method_used, modal::EigenMethod::kPolynomials);
    EXPECT_EQ(found.none_missing, true);
    EXPECT_EQ(found.n_rigid_modes, 6);
    ASSERT_EQ(found.model.n_modes(), 15);
    const EllipsoidModes finest(axes_m, glass(), {22, 16});
    const std::vector<modal::ModeId> ids = finest.lowest(15);
    for (Eigen::Index k = 0; k < 15; ++k) {
      const double truth = finest.angular_frequency_rad_s(ids[static_cast<std::size_t>(k)]);
      const double error = found.model.angular_frequency_rad_s[k] / truth - 1.0;
      EXPECT_LE(std::abs(error), 1e-5) << k;
      EXPECT_LE(error, (*found.mesh_relative_error)[k] + 1e-11) << k;
      EXPECT_LE(found.relative_residual[k], 1e-6) << k;
    }
  }
}

TEST(EllipsoidSolve, ShapesOnTheMeshHaveUnitModalMass) {
  const mesh::ShapeSpec shape{"ellipsoid", {{"a_m", 0.012}, {"b_m", 0.02}, {"c_m", 0.03}}, {}};
  mesh::ShapeMeshOptions fine;
  fine.wavelength_m = 0.03;
  const mesh::TetMesh body = mesh::mesh_shape(shape, fine);
  modal::EigenOptions options;
  options.count = 6;
  const modal::EigenResult found = modal::solve_ellipsoid_modes(shape, body, glass(), options);
  ASSERT_TRUE(found.usable());
  const la::SparseMatrix mass =
      glass().density_kg_m3 * la::SparseMatrix(solid::assemble(body).mass_unit_density.selfadjointView<Eigen::Lower>());
  const Eigen::MatrixXd product = found.model.shapes.transpose() * (mass * found.model.shapes);
  EXPECT_LE((product - Eigen::MatrixXd::Identity(6, 6)).cwiseAbs().maxCoeff(), 5e-3);
}

TEST(EllipsoidSolve, ABandListsWhatAShortestListDoesFromItsLowerEndOn) {
  const mesh::ShapeSpec shape{"ellipsoid", {{"a_m", 0.03}, {"b_m", 0.05}, {"c_m", 0.055}}, {}};
  const mesh::TetMesh body = mesh::mesh_shape(shape, mesh::ShapeDivisions{{2, 2, 1}}, 2);
  modal::EigenOptions by_count;
  by_count.count = 40;
  const Eigen::VectorXd all = modal::solve_ellipsoid_modes(shape, body, glass(), by_count).model.frequency_hz();
  modal::EigenOptions by_band;
  by_band.band = {0.5 * (all[9] + all[10]), 0.5 * (all[24] + all[25])};
  const modal::EigenResult found = modal::solve_ellipsoid_modes(shape, body, glass(), by_band);
  ASSERT_EQ(found.model.n_modes(), 15);
  EXPECT_EQ(found.n_below_band, 10);
  EXPECT_LE((found.model.frequency_hz() - all.segment(10, 15)).cwiseAbs().maxCoeff(), 1e-4 * all[24]);
}

TEST(EllipsoidSolve, OtherShapesAreRefused) {
  const mesh::ShapeSpec box{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.1}}, {}};
  EXPECT_THROW(modal::solve_ellipsoid_modes(box, mesh::mesh_shape(box, mesh::ShapeDivisions{{2, 2, 2}}, 2), glass()),
               InputError);
}
