#include "core/geometry/shapes/surface_curvature.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

namespace klang::mesh {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double along(const Matrix3d& k, const Vector3d& direction) { return direction.dot(k * direction); }

TEST(SurfaceCurvature, OfFlatFacesIsNoneInsideAndUnknownAtEdges) {
  const auto box = surface_curvature({"box", {{"length_m", 0.4}, {"width_m", 0.3}, {"height_m", 0.02}}, {}}, 0.001);
  EXPECT_TRUE(box({0.1, 0.05, 0.01}, Vector3d::UnitZ()).value().isZero(0.0));
  EXPECT_FALSE(box({0.1999, 0.05, 0.01}, Vector3d::UnitZ()));
  EXPECT_FALSE(box({0.1, 0.05, 0.01}, Vector3d(0, 0.1, 1).normalized()));
}

TEST(SurfaceCurvature, OfAnEllipsoidsTipIsItsOsculatingSphere) {
  const auto egg = surface_curvature({"ellipsoid", {{"a_m", 0.02}, {"b_m", 0.03}, {"c_m", 0.04}}, {}}, 0.001);
  const Matrix3d tip = egg({0, 0, 0.0398}, Vector3d::UnitZ()).value();  // on a facet a little inside
  EXPECT_NEAR(along(tip, Vector3d::UnitX()), 0.04 / (0.02 * 0.02), 1e-9);
  EXPECT_NEAR(along(tip, Vector3d::UnitY()), 0.04 / (0.03 * 0.03), 1e-9);
  EXPECT_NEAR(along(tip, Vector3d::UnitZ()), 0.0, 1e-12);
}

TEST(SurfaceCurvature, OfARoundWallIsAcrossItsAxis) {
  const auto tube =
      surface_curvature({"tube", {{"length_m", 0.5}, {"outer_radius_m", 0.02}, {"wall_m", 0.005}}, {}}, 0.0005);
  const Matrix3d outer = tube({0.0199, 0, 0.1}, Vector3d::UnitX()).value();
  EXPECT_NEAR(along(outer, Vector3d::UnitY()), 50.0, 1e-9);
  EXPECT_NEAR(along(outer, Vector3d::UnitZ()), 0.0, 1e-12);
  EXPECT_NEAR(along(tube({0.0151, 0, 0.1}, -Vector3d::UnitX()).value(), Vector3d::UnitY()), -1.0 / 0.015, 1e-9);
  EXPECT_TRUE(tube({0.0199, 0, 0.25}, Vector3d::UnitX()));                      // lies on its side
  EXPECT_FALSE(tube({0.0199, 0, 0.25}, Vector3d(1, 0, 0.05).normalized()));     // stands on its rim
  EXPECT_TRUE(tube({0.0175, 0, 0.25}, Vector3d::UnitZ()).value().isZero(0.0));  // its end
}

TEST(SurfaceCurvature, OfABowlIsThatOfItsSpheres) {
  const auto bowl =
      surface_curvature({"bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.01}, {"depth_m", 0.08}}, {}}, 0.0005);
  const Vector3d out = Vector3d(0.6, 0, -0.8), pole(0, 0, 0.1);
  EXPECT_NEAR(along(bowl(pole + 0.1 * out, out).value(), Vector3d::UnitY()), 10.0, 1e-9);
  EXPECT_NEAR(along(bowl(pole + 0.09 * out, -out).value(), Vector3d::UnitY()), -1.0 / 0.09, 1e-9);
  EXPECT_FALSE(bowl({0.098, 0, 0.0799}, Vector3d::UnitX()));
}

// A ball of 50 mm as a polygon of 60 sides that is turned about the axis.
TEST(SurfaceCurvature, OfATurnedPolygonIsThatOfTheCurveItStandsFor) {
  const std::string path = testing::TempDir() + "curvature_profile.csv";
  std::ofstream file(path);
  file << "r_m,z_m\n";
  for (int i = 0; i <= 60; ++i) {
    const double angle = (i / 60.0 - 0.5) * std::acos(-1.0);
    file << std::max(0.0, 0.05 * std::cos(angle)) * (i == 0 || i == 60 ? 0.0 : 1.0) << "," << 0.05 * std::sin(angle)
         << "\n";
  }
  file.close();
  const auto ball = surface_curvature({"revolution", {}, path}, 0.0005);
  for (const double degrees : {3.0, 31.0, -50.0}) {
    const double angle = degrees / 180.0 * std::acos(-1.0);
    const Vector3d out(0, std::cos(angle), std::sin(angle)), along_profile(0, -std::sin(angle), std::cos(angle));
    const Matrix3d k = ball(0.05 * out, out).value();
    EXPECT_NEAR(along(k, Vector3d::UnitX()), 20.0, 0.4) << degrees;
    EXPECT_NEAR(along(k, along_profile), 20.0, 0.4) << degrees;
  }
}

}  // namespace
}  // namespace klang::mesh
