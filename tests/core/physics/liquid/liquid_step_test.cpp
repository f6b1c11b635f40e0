#include "core/physics/liquid/liquid_step.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

LiquidSetup tank() {
  LiquidSetup setup;
  setup.shape = {12, 10, 14, 0.01};
  setup.pools.push_back({Vector3d::Zero(), Vector3d(0.12, 0.10, 0.0837), {}});
  return setup;
}

Solid half_space(const Vector3d& normal, const Vector3d& point) {
  Solid solid;
  solid.shape = SolidShape::kHalfSpace;
  solid.normal = normal.normalized();
  solid.position_m = point;
  return solid;
}

double fastest_in_a_second(LiquidSetup setup) {
  setup.options.longest_step_s = 4e-3;
  Liquid liquid(std::move(setup));
  double most = 0.0;
  liquid.advance_to(1.0, [&](const LiquidStep& step) { most = std::max(most, step.max_speed_m_s); });
  return most;
}

TEST(HydrostaticRest, StaysAtRestBelow1em10) { EXPECT_LE(fastest_in_a_second(tank()), 1e-10); }

TEST(HydrostaticRest, StaysAtRestOverACurvedFloor) {
  LiquidSetup setup = tank();
  Solid ball;
  ball.radius_m = 0.05;
  ball.position_m = {0.061, 0.052, -0.003};
  setup.solids.push_back(ball);
  EXPECT_LE(fastest_in_a_second(std::move(setup)), 1e-10);
}

TEST(HydrostaticRest, StaysAtRestInATiltedTankWithTension) {
  LiquidSetup setup = tank();
  setup.solids.push_back(half_space({0.3, 0.1, 1.0}, {0.06, 0.05, 0.02}));
  setup.solids.push_back(half_space({1.0, 0.0, 0.5}, {0.02, 0.0, 0.07}));
  setup.options.tension = true;
  EXPECT_LE(fastest_in_a_second(std::move(setup)), 1e-10);
}

TEST(HydrostaticRest, StaysAtRestInARoundTank) {
  LiquidSetup setup;
  setup.round = true;
  setup.shape = {12, 1, 14, 0.01};
  setup.pools.push_back({Vector3d::Zero(), Vector3d(0.12, 0.01, 0.0837), {}});
  setup.options.tension = true;
  EXPECT_LE(fastest_in_a_second(std::move(setup)), 1e-10);
}

TEST(FreeFall, DropFollowsTheParabolaExactly) {
  LiquidSetup setup;
  setup.shape = {20, 20, 40, 0.005};
  setup.drops.push_back({0.02, {0.045, 0.05, 0.16}, {0.1, 0.0, 0.0}});
  Liquid liquid(setup);
  const double start = liquid.centre_of_mass_z_m();
  liquid.advance_to(0.12, [](const LiquidStep&) {});
  EXPECT_LE(std::abs(liquid.centre_of_mass_z_m() - start + 0.5 * 9.81 * 0.12 * 0.12), 1e-7);
  EXPECT_LE(std::abs(liquid.volume_m3() / liquid.start_volume_m3() - 1.0), 1e-6);
}

/// A wave of ka = 0.01 in a tank of 0.2 m, mode 2: frequency over sqrt(g k tanh k depth), and the share of the amplitude after a period.
struct Swing {
  double frequency = 0.0, left = 0.0;
};
Swing standing_wave(double depth_m) {
  const double k = 31.41592653589793, cell = 0.2 / 32, omega = std::sqrt(9.81 * k * std::tanh(k * depth_m));
  LiquidSetup setup;
  setup.shape = {32, 2, 22, cell};
  setup.pools.push_back({Vector3d::Zero(), Vector3d(0.2, 2 * cell, depth_m), PoolWave{0.01 / k, 2, 0}});
  Liquid liquid(setup);
  const auto amplitude = [&] {
    double sum = 0.0;
    for (int i = 0; i < 32; ++i)
      for (int z = 0; z + 1 < 22; ++z) {
        const double low = liquid.phi_m()(i, 0, z), high = liquid.phi_m()(i, 0, z + 1);
        if (low < 0.0 && high >= 0.0) sum += cell * (z + 0.5 + low / (low - high)) * std::cos(k * (i + 0.5) * cell);
      }
    return sum / 16.0 * k / 0.01;
  };
  std::vector<double> crossings;
  double before = amplitude(), t_before = 0.0;
  EXPECT_LE(std::abs(before - 1.0), 1e-3);
  Swing swing;
  const double period = 2.0 * kPi / omega;
  liquid.advance_to(1.1 * period, [&](const LiquidStep& step) {
    const double now = amplitude();
    if (now * before < 0.0) crossings.push_back(t_before + (step.time_s - t_before) * before / (before - now));
    if (std::abs(step.time_s - period) < 0.1 * period) swing.left = std::max(swing.left, now);
    before = now;
    t_before = step.time_s;
  });
  EXPECT_EQ(crossings.size(), 2U);
  if (crossings.size() == 2) swing.frequency = kPi / (crossings[1] - crossings[0]) / omega;
  return swing;
}

TEST(StandingWave, Of32CellsIsWithin2PerMilWhereverTheSurfaceLiesInACell) {
  // tests/reference/liquid.json, standing_wave_2d: 17.522594830545945 rad/s at 0.1 m.
  EXPECT_LE(std::abs(std::sqrt(9.81 * 31.41592653589793 * std::tanh(3.141592653589793)) - 17.522594830545945), 1e-12);
  for (const double cells : {0.25, 0.5}) {
    const Swing swing = standing_wave(0.1 + cells * 0.2 / 32);
    EXPECT_LE(std::abs(swing.frequency - 1.0), 0.002) << cells;
    EXPECT_LE(std::abs(1.0 - swing.left), 0.02) << cells;
  }
}

TEST(StandingWave, OfThreeMillimetresOnEighteenCellsGainsNothingInFivePeriods) {
  const double cell = 0.008, length = 18 * cell, height_m = 0.003, depth_m = 0.106, k = kPi / length;
  LiquidSetup setup;
  setup.shape = {18, 2, 23, cell};
  setup.pools.push_back({Vector3d::Zero(), Vector3d(length, 2 * cell, depth_m), PoolWave{height_m, 1, 0}});
  Liquid liquid(setup);
  const double period = 2.0 * kPi / std::sqrt(9.81 * k * std::tanh(k * depth_m));
  std::vector<double> most(5, 0.0);  // of the speed, in each period
  liquid.advance_to(5.0 * period, [&](const LiquidStep& step) {
    const auto n = static_cast<std::size_t>(std::min(4.0, (step.time_s - 1e-9) / period));
    most[n] = std::max(most[n], step.max_speed_m_s);
  });
  EXPECT_LE(std::abs(most[0] / (height_m * 2.0 * kPi / period / std::tanh(k * depth_m)) - 1.0), 0.1);
  EXPECT_LE(most[4], 1.01 * most[0]);
  EXPECT_LE(0.94 * most[0], most[4]);
}

/// A drop into a pool over a ball, with an inlet and an outlet.
LiquidSetup splash() {
  LiquidSetup setup = tank();
  setup.drops.push_back({0.012, {0.05, 0.05, 0.105}, {0.0, 0.2, -1.0}});
  Solid ball;
  ball.radius_m = 0.02;
  ball.position_m = {0.09, 0.05, 0.06};
  ball.motion = SolidMotion::kFree;
  ball.density_kg_m3 = 2500.0;
  setup.solids.push_back(ball);
  Inlet inlet;
  inlet.radius_m = 0.015;
  inlet.position_m = {0.03, 0.05, 0.12};
  inlet.speed_m_s = 0.5;
  setup.inlets.push_back(inlet);
  setup.outlets.push_back({{0.11, 0.0, 0.07}, {0.13, 0.10, 0.14}});
  return setup;
}

std::string state_at(Liquid& liquid, double time_s) {
  liquid.advance_to(time_s, [](const LiquidStep&) {});
  std::ostringstream out;
  liquid.save(out);
  return out.str();
}

TEST(Splash, HasTheSameBitsOnOneAndTwoThreads) {
  std::string states[2];
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    Liquid liquid(splash());
    states[threads - 1] = state_at(liquid, 0.08);
  }
  set_thread_count(0);
  EXPECT_TRUE(states[0] == states[1]);
}

TEST(Splash, GoesOnWithTheSameBitsFromItsState) {
  Liquid whole(splash()), first(splash()), second(splash());
  const std::string half = state_at(first, 0.04);
  std::istringstream in(half);
  second.load(in);
  EXPECT_TRUE(state_at(whole, 0.04) == half);
  EXPECT_TRUE(state_at(whole, 0.08) == state_at(second, 0.08));
}

TEST(Splash, KeepsItsVolumeAndConverges) {
  Liquid liquid(splash());
  double drift = 0.0, divergence = 0.0, inflow = 0.0;
  bool converged = true;
  liquid.advance_to(0.15, [&](const LiquidStep& step) {
    drift = std::max(drift, step.drift_relative);
    divergence = std::max(divergence, step.pressure.max_divergence);
    converged = converged && step.pressure.converged;
    inflow = step.inflow_m3;
  });
  EXPECT_TRUE(converged);
  EXPECT_LE(divergence, 1e-3);
  EXPECT_LE(drift, 1e-3);
  EXPECT_LE(std::abs(inflow - kPi * 0.015 * 0.015 * 0.5 * 0.15), 1e-12);
}

TEST(Sphere, StartsWithItsAddedMass) {
  // A light ball deep in a tank starts with g (rho - rho_s) / (rho_s + rho/2); walls five radii away make the added mass some percent greater.
  LiquidSetup setup;
  setup.shape = {40, 40, 40, 0.005};
  setup.pools.push_back({Vector3d::Zero(), Vector3d(0.2, 0.2, 0.19), {}});
  Solid ball;
  ball.radius_m = 0.02;
  ball.position_m = {0.1, 0.1, 0.1};
  ball.motion = SolidMotion::kFree;
  ball.density_kg_m3 = 100.0;
  setup.solids.push_back(ball);
  Liquid liquid(setup);
  liquid.step(1e-4);
  const double acceleration = liquid.solids()[0].velocity_m_s.z() / 0.5e-4;
  EXPECT_LE(std::abs(acceleration / (9.81 * 900.0 / 600.0) - 1.0), 0.06);
}

}  // namespace
}  // namespace klang::liquid
