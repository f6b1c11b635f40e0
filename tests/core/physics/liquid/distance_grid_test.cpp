#include <gtest/gtest.h>

#include "core/physics/liquid/distance_grid.hpp"
#include "core/physics/liquid/surface.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

/// Half a cube's size of liquid in a box, its surface meshed and turned into distances again.
Field again(const GridShape& shape, const std::function<double(const Vector3d&)>& phi) {
  Field field(shape.nx, shape.ny, shape.nz);
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) field(i, j, k) = phi(shape.centre_m(i, j, k));
  return surface_distance(shape, Vector3d::Zero(), liquid_surface(shape, field, {}));
}

TEST(SurfaceDistance, OfABallIsItsDistanceToFullDepth) {
  const GridShape shape{32, 32, 32, 0.01};
  const Vector3d middle(0.161, 0.157, 0.163);
  const Field found = again(shape, [&](const Vector3d& x) { return (x - middle).norm() - 0.11; });
  double worst = 0.0;
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 32; ++i) {
        const double exact = (shape.centre_m(i, j, k) - middle).norm() - 0.11;
        EXPECT_TRUE(std::abs(exact) < 0.002 || (exact < 0.0) == (found(i, j, k) < 0.0));
        if (std::abs(exact) < 0.06) worst = std::max(worst, std::abs(found(i, j, k) - exact));
      }
  EXPECT_LE(worst, 0.004);
}

/// A box of liquid from the floor to a height, free above, walls around.
LiquidSurface filled(double x, double y, double z) {
  LiquidSurface box;
  box.surface.vertices_m.resize(8, 3);
  for (int c = 0; c < 8; ++c)
    box.surface.vertices_m.row(c) << ((c & 1) != 0 ? x : 0.0), ((c & 2) != 0 ? y : 0.0), ((c & 4) != 0 ? z : 0.0);
  const int quads[6][4] = {{4, 5, 7, 6}, {0, 2, 3, 1}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  box.surface.triangles.resize(12, 3);
  for (int q = 0; q < 6; ++q) {
    box.surface.triangles.row(2 * q) << quads[q][0], quads[q][1], quads[q][2];
    box.surface.triangles.row(2 * q + 1) << quads[q][0], quads[q][2], quads[q][3];
    box.region.insert(box.region.end(), 2, q == 0 ? 0 : 1);
  }
  return box;
}

TEST(SurfaceDistance, CountsFromTheFreeSurfaceAndNotFromWalls) {
  const GridShape shape{12, 10, 16, 0.01};
  const Field found = surface_distance(shape, Vector3d::Zero(), filled(0.12, 0.1, 0.083));
  for (int k = 0; k < 16; ++k)
    EXPECT_LE(std::abs(found(0, 5, k) - (0.01 * (k + 0.5) - 0.083)), 1e-12)
        << k << ": beside a wall, down to the floor";
}

TEST(DistanceFromZeroSet, OfAPlaneIsExactWhateverTheSlope) {
  const GridShape shape{10, 10, 10, 0.01};
  for (const double slope : {0.1, 1.0, 30.0}) {
    Field value(10, 10, 10);
    for (int k = 0; k < 10; ++k)
      for (int j = 0; j < 10; ++j)
        for (int i = 0; i < 10; ++i) value(i, j, k) = slope * (shape.centre_m(i, j, k).z() - 0.047);
    distance_from_zero_set(shape, value);
    for (int k = 0; k < 10; ++k) EXPECT_LE(std::abs(value(3, 4, k) - (0.01 * (k + 0.5) - 0.047)), 1e-9) << slope;
  }
}

}  // namespace
}  // namespace klang::liquid
