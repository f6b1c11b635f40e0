#include "core/physics/liquid/surface.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::liquid {
namespace {

/// Of the triangles of some regions: how many edges are not run once each way.
int bad_edges(const LiquidSurface& surface, int left_out) {
  std::map<std::pair<int, int>, int> uses;
  for (std::size_t t = 0; t < surface.region.size(); ++t) {
    if (surface.region[t] == left_out) continue;
    for (int c = 0; c < 3; ++c)
      ++uses[{surface.surface.triangles(static_cast<Eigen::Index>(t), c),
              surface.surface.triangles(static_cast<Eigen::Index>(t), (c + 1) % 3)}];
  }
  int bad = 0;
  for (const auto& [edge, count] : uses) {
    const auto back = uses.find({edge.second, edge.first});
    bad += count != 1 || back == uses.end() || back->second != 1 ? 1 : 0;
  }
  return bad;
}

double volume(const LiquidSurface& surface) {
  double six = 0.0;
  for (std::size_t t = 0; t < surface.region.size(); ++t) {
    if (surface.region[t] == 3) continue;
    const auto row = surface.surface.triangles.row(static_cast<Eigen::Index>(t));
    const Eigen::Vector3d a = surface.surface.vertices_m.row(row[0]), b = surface.surface.vertices_m.row(row[1]),
                          c = surface.surface.vertices_m.row(row[2]);
    six += a.dot(b.cross(c));
  }
  return six / 6.0;
}

TEST(LiquidSurface, IsClosedOrientedAndManifoldForAnyPhiAndSolid) {
  const GridShape shape{6, 5, 7, 0.01};
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    RandomStream random(seed, 1);
    Field phi(6, 5, 7), solid(6, 5, 7, 1.0);
    for (double& value : phi.data()) value = random.uniform(-0.01, 0.01);
    if (seed % 2 == 1)
      for (double& value : solid.data()) value = random.uniform(-0.004, 0.01);
    const LiquidSurface surface = liquid_surface(shape, phi, seed % 2 == 1 ? solid : Field());
    EXPECT_EQ(bad_edges(surface, 3), 0) << "liquid, seed " << seed;
    EXPECT_EQ(bad_edges(surface, 2), 0) << "liquid and solids, seed " << seed;
    EXPECT_GT(volume(surface), 0.0) << seed;
  }
}

TEST(LiquidSurface, OfABallOnAFloorIsTakenByTheDualDomainSolver) {
  const GridShape shape{16, 14, 18, 0.01};
  Field phi(16, 14, 18), solid(16, 14, 18);
  for (int k = 0; k < 18; ++k)
    for (int j = 0; j < 14; ++j)
      for (int i = 0; i < 16; ++i) {
        const Eigen::Vector3d x = shape.centre_m(i, j, k);
        phi(i, j, k) = x.z() - 0.097;
        solid(i, j, k) = (x - Eigen::Vector3d(0.08, 0.07, 0.083)).norm() - 0.041;
      }
  const LiquidSurface surface = liquid_surface(shape, phi, solid);
  bubble::BoundaryMesh mesh;
  mesh.surface = surface.surface;
  mesh.region = surface.region;
  mesh.name = "ball in a tank";
  const bubble::LiquidBoundary boundary(mesh);
  // Ball less the cap above the level: of height r + z0 - level.
  const double r = 0.041, cap = r + 0.083 - 0.097;
  const double exact = 0.16 * 0.14 * 0.097 - (4.0 / 3.0 * kPi * r * r * r - kPi * cap * cap * (r - cap / 3.0));
  EXPECT_LE(std::abs(boundary.volume_m3() / exact - 1.0), 2e-3);
  const double free = 0.16 * 0.14 - kPi * (r * r - (0.097 - 0.083) * (0.097 - 0.083));
  EXPECT_LE(std::abs(boundary.free_area_m2() / free - 1.0), 1e-2);
  for (const int region : {0, 1, 2, 3})
    EXPECT_NE(std::find(surface.region.begin(), surface.region.end(), region), surface.region.end()) << region;
}

TEST(LiquidSurface, VolumeOfABallFallsAtOrderTwo) {
  double before = 0.0;
  for (const int n : {8, 16, 32}) {
    const GridShape shape{n, n, n, 1.0 / n};
    Field phi(n, n, n);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          phi(i, j, k) = (shape.centre_m(i, j, k) - Eigen::Vector3d(0.51, 0.48, 0.5)).norm() - 0.3;
    const double error = std::abs(volume(liquid_surface(shape, phi, {})) / (4.0 / 3.0 * kPi * 0.027) - 1.0);
    if (before > 0.0) {
      EXPECT_LE(std::abs(std::log2(before / error) - 2.0), 0.4) << n;
    }
    before = error;
  }
}

}  // namespace
}  // namespace klang::liquid
