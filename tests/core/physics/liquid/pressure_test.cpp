#include "core/physics/liquid/pressure.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/liquid/level_set.hpp"

namespace klang::liquid {
namespace {

/// Pressure of a column of liquid (planar, L wide, 2 L high) at the instant its gate goes, over rho g H; cells such that neither surface
/// lies on faces or centres.
double pressure_after_release(double cells_across, double x_over_l, double z_over_h) {
  const double length = 0.05715, height = 2.0 * length, h = length / cells_across;
  const GridShape shape{static_cast<int>(cells_across) + 3, 1, static_cast<int>(2.0 * cells_across) + 3, h};
  Field phi(shape.nx, 1, shape.nz), pressure(shape.nx, 1, shape.nz);
  for (int k = 0; k < shape.nz; ++k)
    for (int i = 0; i < shape.nx; ++i) phi(i, 0, k) = std::max((i + 0.5) * h - length, (k + 0.5) * h - height);
  std::vector<Solid> solids;
  const SolidField open = solid_field(shape, solids);
  MacGrid u(shape);
  PressureOptions options;
  options.tolerance = 1e-10;
  for (double& w : u[2].data()) w = -9.81 * options.kick_s;
  const PressureSolve solve = project(shape, phi, open, solids, {u, pressure}, options);
  EXPECT_TRUE(solve.converged);
  const Eigen::Vector3d at(x_over_l * length, 0.0, z_over_h * height);
  if (x_over_l > 0.0) return at_centres(pressure, at, h) / (9.81 * height);
  // On the wall: the slope across it is 0.
  const double first = at_centres(pressure, {0.5 * h, 0.0, at.z()}, h),
               second = at_centres(pressure, {1.5 * h, 0.0, at.z()}, h);
  return (9.0 * first - second) / 8.0 / (9.81 * height);
}

TEST(ReleasedColumn, PressureIsTheSeriesToOrderTwo) {
  // tests/reference/liquid.json, released_column.
  struct Point {
    double x, z, p;
  };
  const Point points[] = {{0.0, 0.25, 0.1788046222011039},   {0.0, 0.5, 0.08006103336143237},
                          {0.25, 0.25, 0.16714193414413492}, {0.5, 0.25, 0.13201897242024951},
                          {0.5, 0.5, 0.057174848551034475},  {0.75, 0.75, 0.01165769372842983}};
  double before = 0.0;
  for (const double n : {16.37, 32.37, 64.37}) {
    double error = 0.0;
    for (const Point& point : points)
      error = std::max(error, std::abs(pressure_after_release(n, point.x, point.z) - point.p));
    if (before > 0.0) {
      EXPECT_LE(std::abs(std::log2(before / error) - 2.0), 0.5) << n;
    }
    before = error;
  }
  EXPECT_LE(before, 2e-4);
}

TEST(Pressure, InADropIsLaplaces) {
  const int n = 20;
  const double h = 0.001, radius = 0.006;
  const GridShape shape{n, n, n, h};
  Field phi(n, n, n), pressure(n, n, n);
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        phi(i, j, k) = (shape.centre_m(i, j, k) - Eigen::Vector3d(0.0101, 0.0098, 0.01)).norm() - radius;
  std::vector<Solid> solids;
  const SolidField open = solid_field(shape, solids);
  MacGrid u(shape);
  PressureOptions options;
  options.tension_m3_s2 = 7.26e-5;
  options.tolerance = 1e-9;
  EXPECT_TRUE(project(shape, phi, open, solids, {u, pressure}, options).converged);
  EXPECT_LE(std::abs(pressure(10, 10, 10) / (2.0 * options.tension_m3_s2 / radius) - 1.0), 0.01);
}

/// A drop on the axis of a grid that is the same all around.
struct RoundDrop {
  GridShape shape{20, 1, 40, 0.001};
  double radius_m = 0.012;
  Field phi{20, 1, 40}, pressure{20, 1, 40};
  std::vector<Solid> solids;
  SolidField open = sector_field(shape);
  MacGrid u{shape};
  RoundDrop() {
    for (int k = 0; k < 40; ++k)
      for (int i = 0; i < 20; ++i) phi(i, 0, k) = std::hypot(0.001 * (i + 0.5), 0.001 * (k + 0.5) - 0.0203) - radius_m;
  }
};

/// Water 0.63 m deep in a tank of 1 m, where asked two cells of it closed in.
MacGrid flow_of_a_source(double source_per_s, bool closed_cell, PressureSolve& solve) {
  const GridShape shape{10, 10, 10, 0.1};
  Field phi(10, 10, 10), pressure(10, 10, 10);
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 10; ++j)
      for (int i = 0; i < 10; ++i) phi(i, j, k) = shape.centre_m(i, j, k).z() - 0.63;
  std::vector<Solid> solids;
  SolidField open = solid_field(shape, solids);
  if (closed_cell) {
    for (const int k : {1, 2})
      for (const int side : {4, 5}) open.open[0](side, 4, k) = open.open[1](4, side, k) = 0.0;
    for (const int side : {1, 3}) open.open[2](4, 4, side) = 0.0;
  }
  MacGrid u(shape);
  PressureOptions options;
  options.tolerance = 1e-10;
  options.source_per_s = source_per_s;
  solve = project(shape, phi, open, solids, {u, pressure}, options);
  return u;
}

TEST(SolidField, NothingFlowsBetweenCellsThatAreSolidAllThrough) {
  const GridShape shape{6, 6, 6, 0.1};
  Solid box;  // two cells wide, long and high, at the wall x = 0, its corners on the grid's
  box.shape = SolidShape::kBox;
  box.size_m = {0.2, 0.2, 0.2};
  box.position_m = {0.1, 0.3, 0.2};
  const SolidField field = solid_field(shape, {box});
  for (int k = 1; k < 3; ++k)
    for (int i = 0; i < 2; ++i) EXPECT_EQ(field.open[1](i, 3, k), 0.0) << i << " " << k << ": a quarter by its corners";
  EXPECT_EQ(field.open[1](3, 3, 1), 1.0);
}

TEST(SolidField, APlateOfOneCellOnTheGridsPlanesIsClosedAndASlitOfOneIsOpen) {
  const GridShape shape{6, 6, 8, 0.005};
  const auto plate = [](double z_m) {
    Solid box;
    box.shape = SolidShape::kBox;
    box.size_m = {1.0, 1.0, 0.005};
    box.position_m = {0.0, 0.0, z_m};
    return box;
  };
  const SolidField one = solid_field(shape, {plate(0.0125)});
  EXPECT_EQ(one.open_volume(2, 2, 2), 0.0);
  EXPECT_EQ(one.open_volume(2, 2, 1), 1.0);
  EXPECT_EQ(one.open_volume(2, 2, 3), 1.0);
  for (const int k : {2, 3}) EXPECT_EQ(one.open[2](2, 2, k), 0.0) << k;
  for (const int k : {1, 4}) EXPECT_EQ(one.open[2](2, 2, k), 1.0) << k;
  EXPECT_EQ(one.open[0](2, 2, 2), 0.0);
  EXPECT_EQ(one.open[0](2, 2, 3), 1.0);
  const SolidField slit = solid_field(shape, {plate(0.0125), plate(0.0225)});
  EXPECT_EQ(slit.open_volume(2, 2, 3), 1.0);
  EXPECT_EQ(slit.open[0](2, 2, 3), 1.0);
  EXPECT_EQ(slit.open[2](2, 2, 3), 0.0);
}

TEST(Pressure, ASourceRaisesAPoolEvenly) {
  PressureSolve solve;
  const MacGrid u = flow_of_a_source(0.02, false, solve);
  EXPECT_TRUE(solve.converged);
  for (int k = 0; k <= 6; ++k) EXPECT_NEAR(u[2](3, 7, k), 0.02 * 0.1 * k, 1e-9) << k;
  EXPECT_NEAR(solve.max_divergence, 0.02e-3, 1e-9) << "said";
}

TEST(Pressure, ASourceLeavesClosedLiquidAlone) {
  PressureSolve solve;
  const MacGrid u = flow_of_a_source(0.02, true, solve);
  EXPECT_TRUE(solve.converged) << "two cells without a way to the surface";
  EXPECT_NEAR(u[2](4, 4, 2), 0.0, 1e-12);
  EXPECT_NEAR(u[2](0, 0, 6), 0.02 * 0.6, 0.001);
}

TEST(Pressure, InARoundDropIsLaplaces) {
  RoundDrop drop;
  PressureOptions options;
  options.tension_m3_s2 = 7.26e-5;
  options.tolerance = 1e-9;
  EXPECT_TRUE(project(drop.shape, drop.phi, drop.open, drop.solids, {drop.u, drop.pressure}, options).converged);
  for (const int i : {0, 5})
    EXPECT_LE(std::abs(drop.pressure(i, 0, 20) / (2.0 * options.tension_m3_s2 / drop.radius_m) - 1.0), 0.01) << i;
}

TEST(Pressure, LeavesARoundFlowWithoutDivergenceAsItIs) {
  RoundDrop drop;
  for (int k = 0; k < 40; ++k)
    for (int i = 0; i <= 20; ++i) drop.u[0](i, 0, k) = -0.5 * 3.0 * 0.001 * i;  // together, and up and down
  for (int k = 0; k <= 40; ++k)
    for (int i = 0; i < 20; ++i) drop.u[2](i, 0, k) = 3.0 * (0.001 * k - 0.02);
  const MacGrid before = drop.u;
  PressureOptions options;
  options.tolerance = 1e-12;
  EXPECT_TRUE(project(drop.shape, drop.phi, drop.open, drop.solids, {drop.u, drop.pressure}, options).converged);
  for (int k = 12; k < 28; ++k)
    for (int i = 0; i < 8; ++i) EXPECT_NEAR(drop.u[0](i, 0, k), before[0](i, 0, k), 1e-12);
  const double volume = liquid_volume_m3(drop.shape, drop.phi, drop.open) * 2.0 * kPi * drop.shape.nx;
  EXPECT_LE(std::abs(volume / (4.0 / 3.0 * kPi * std::pow(drop.radius_m, 3)) - 1.0), 0.003)
      << "of the sector, times sectors";
}

}  // namespace
}  // namespace klang::liquid
