#include "core/sound/dual_domain/liquid_boundary.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/dual_domain/source_points.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"

namespace {

using namespace klang;
using namespace klang::bubble;
using Eigen::Vector3d;

/// The message of the InputError, or nothing.
template <class Body>
std::string refusal(const Body& body) {
  try {
    body();
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST(LiquidBoundary, TankHasItsVolumeAreasAndCentre) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02));
  EXPECT_NEAR(boundary.volume_m3(), 0.30 * 0.22 * 0.15, 1e-12);
  EXPECT_NEAR(boundary.free_area_m2(), 0.30 * 0.22, 1e-12);
  EXPECT_NEAR(boundary.rigid_area_m2(), 0.30 * 0.22 + 2 * 0.15 * (0.30 + 0.22), 1e-12);
  EXPECT_LE((boundary.centre_m() - Vector3d(0.15, 0.11, -0.075)).norm(), 1e-12);
  EXPECT_NEAR(boundary.distance_m({0.15, 0.11, -0.03}), 0.03, 1e-12);
}

TEST(LiquidBoundary, CornersGetASampleForEachFace) {
  const LiquidBoundary boundary(test::tank({0.3, 0.2, 0.1}, 0.05));
  int at_corner = 0;
  double area = 0.0;
  for (const BoundarySample& s : boundary.samples()) {
    at_corner += s.point_m.norm() < 1e-12 ? 1 : 0;
    area += s.area_m2;
    EXPECT_NEAR(s.normal.cwiseAbs().maxCoeff(), 1.0, 1e-12);  // along an axis everywhere
  }
  EXPECT_EQ(at_corner, 3);
  EXPECT_NEAR(area, boundary.free_area_m2() + boundary.rigid_area_m2(), 1e-12);
}

TEST(LiquidBoundary, BallNormalsPointAlongTheRadius) {
  const LiquidBoundary boundary(test::ball(0.05, 10));
  for (const BoundarySample& s : boundary.samples()) EXPECT_GE(s.normal.dot(s.point_m.normalized()), 1.0 - 1e-4);
}

TEST(LiquidBoundary, ExpansionMovesTheFreeSurfaceAlone) {
  BoundaryOptions options;
  options.expand_m = 0.004;
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02), options);
  EXPECT_NEAR(boundary.volume_m3(), 0.30 * 0.22 * 0.154, 1e-9);
  EXPECT_TRUE(boundary.inside_liquid({0.1, 0.1, 0.002}));
  EXPECT_FALSE(boundary.inside_liquid({0.1, 0.1, -0.152}));
}

TEST(LiquidBoundary, TurnedFaceIsNamed) {
  BoundaryMesh mesh = test::tank({0.30, 0.22, 0.15}, 0.05);
  std::swap(mesh.surface.triangles(7, 1), mesh.surface.triangles(7, 2));
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(mesh); }), "inconsistent normals"));
}

TEST(LiquidBoundary, TurnedPatchIsNamed) {
  BoundaryMesh mesh = test::tank({0.30, 0.22, 0.15}, 0.05);
  for (Eigen::Index t = 0; t < mesh.surface.triangles.rows(); ++t)
    if (mesh.region[static_cast<std::size_t>(t)] == 0)
      std::swap(mesh.surface.triangles(t, 1), mesh.surface.triangles(t, 2));
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(mesh); }), "inconsistent normals"));
}

TEST(LiquidBoundary, InwardNormalsOpenEdgesAndMissingFreeSurfaceAreRefused) {
  BoundaryMesh inward = test::ball(0.05, 4);
  inward.surface.triangles.col(1).swap(inward.surface.triangles.col(2));
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(inward); }), "normals point into the liquid"));

  BoundaryMesh open = test::ball(0.05, 4);
  open.surface.triangles.conservativeResize(open.surface.triangles.rows() - 1, 3);
  open.region.pop_back();
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(open); }), "open at an edge"));

  BoundaryMesh rigid = test::ball(0.05, 4);
  rigid.region.assign(rigid.region.size(), 1);
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(rigid); }), "no free surface"));

  BoundaryMesh unknown = test::ball(0.05, 4);
  unknown.region[3] = 9;
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(unknown); }), "face 3"));
}

TEST(LiquidBoundary, BubbleOutsideOrOnTheSurfaceIsRefused) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.05));
  EXPECT_TRUE(says(refusal([&] { boundary.check_bubble({0.1, 0.1, 0.02}, 1e-4); }), "outside the liquid"));
  EXPECT_TRUE(says(refusal([&] { boundary.check_bubble({0.1, 0.1, 0.0}, 1e-4); }), "lies on the boundary"));
  EXPECT_EQ(refusal([&] { boundary.check_bubble({0.1, 0.1, -0.02}, 1e-4); }), "");
}

TEST(LiquidBoundary, SolidThatReachesTheAirNeedsItsDryPart) {
  BoundaryMesh mesh = test::tank({0.30, 0.22, 0.15}, 0.05);
  for (std::size_t t = 0; t < 4; ++t) mesh.region[t] = 2;  // a hole in the air's boundary
  EXPECT_TRUE(says(refusal([&] { LiquidBoundary b(mesh); }), "seen from the air"));
}

TEST(LiquidBoundary, SunkSolidIsPartOfTheLiquidsBoundaryOnly) {
  BoundaryMesh mesh = test::tank({0.30, 0.22, 0.15}, 0.02);
  const BoundaryMesh stone = test::ball(0.03, 4, {0.15, 0.11, -0.08});
  const Eigen::Index first = mesh.surface.vertices_m.rows(), n = mesh.surface.triangles.rows();
  mesh.surface.vertices_m.conservativeResize(first + stone.surface.vertices_m.rows(), 3);
  mesh.surface.vertices_m.bottomRows(stone.surface.vertices_m.rows()) = stone.surface.vertices_m;
  mesh.surface.triangles.conservativeResize(n + stone.surface.triangles.rows(), 3);
  mesh.surface.triangles.bottomRows(stone.surface.triangles.rows()) =
      stone.surface.triangles.array() + static_cast<int>(first);
  mesh.surface.triangles.bottomRows(stone.surface.triangles.rows())
      .col(1)
      .swap(mesh.surface.triangles.bottomRows(stone.surface.triangles.rows()).col(2));
  mesh.region.insert(mesh.region.end(), static_cast<std::size_t>(stone.surface.triangles.rows()), 2);
  const LiquidBoundary boundary(mesh);
  EXPECT_FALSE(boundary.inside_liquid({0.15, 0.11, -0.08}));
  EXPECT_TRUE(boundary.inside_air_boundary({0.15, 0.11, -0.08}));
  EXPECT_LT(boundary.volume_m3(), 0.30 * 0.22 * 0.15 - 0.9 * 4.0 / 3.0 * kPi * 2.7e-5);
}

TEST(SourcePoints, AreInsideApartFromTheBoundaryAndRepeatable) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02));
  const SourcePoints a = random_source_points(boundary, 40, 60, 5), b = random_source_points(boundary, 40, 60, 5),
                     c = random_source_points(boundary, 40, 60, 6);
  EXPECT_EQ(a.air_m, b.air_m);
  EXPECT_NE(a.air_m, c.air_m);
  for (const Vector3d& x : a.fluid_m) EXPECT_GE(boundary.distance_m(x), boundary.spacing_m());
}

TEST(SourcePoints, FollowTheLiquidAndKeepTheirPlacesOtherwise) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02));
  SourcePoints points = random_source_points(boundary, 20, 20, 5);
  const SourcePoints before = points;
  advect(points, boundary, 0.01, [](const Vector3d& x) { return Vector3d(-x.y() + 0.11, x.x() - 0.15, 0.0); });
  // A turn by 0.01 rad around the middle; the midpoint rule errs by angle^3 / 6 of the radius.
  int carried = 0;
  for (std::size_t i = 0; i < points.fluid_m.size(); ++i) {
    const double c = std::cos(0.01), s = std::sin(0.01), x = before.fluid_m[i].x() - 0.15,
                 y = before.fluid_m[i].y() - 0.11;
    carried +=
        (points.fluid_m[i] - Vector3d(0.15 + c * x - s * y, 0.11 + s * x + c * y, before.fluid_m[i].z())).norm() <=
        1e-7;
  }
  EXPECT_GE(carried, 18);
  const SourcePoints rested = points;
  advect(points, boundary, 0.01);
  EXPECT_EQ(points.air_m, rested.air_m);
}
