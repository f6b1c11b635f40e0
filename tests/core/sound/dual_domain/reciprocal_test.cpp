#include "core/sound/dual_domain/reciprocal.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/dual_domain/tank_modes.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"
#include "validate/studies/closed_tank.hpp"
#include "validate/studies/two_medium.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;
using validate::detail::ClosedTank;

constexpr double kRadius_m = 1e-3;
double strength(double frequency_hz) { return bubble_source_strength(kRadius_m, frequency_hz, 1000.0); }

TEST(Reciprocity, BallIsTheSeriesWithinATenthOfAPercent) {
  const LiquidBoundary ball(test::ball(0.05, 8));
  const std::vector<Vector3d> ears = {{0.3, 0.2, 0.4}, {0.0, 0.0, -0.6}};
  const std::vector<SwingingBubble> bubbles = {{{0.0, 0.0, 0.02}, kRadius_m}, {{0.0, 0.0, 0.0}, kRadius_m}};
  const auto found = reciprocal_transfer(ball, 500.0, random_source_points(ball, 20, 1, 1), {bubbles, ears});
  for (std::size_t b = 0; b < bubbles.size(); ++b)
    for (std::size_t e = 0; e < ears.size(); ++e) {
      validate::LiquidBall exact;
      exact.frequency_hz = 500.0;
      exact.source_m = bubbles[b].position_m.z();
      const Complex p = validate::ball_pressure(exact, validate::Coupling::kOneWay, ears[e]);
      EXPECT_LE(std::abs(found[b][e].plain / strength(500.0) - p) / std::abs(p), 1e-3) << b << " " << e;
      EXPECT_LE(std::abs(found[b][e].pressure / strength(500.0) - p) / std::abs(p), 1e-3) << b << " " << e;
    }
}

const Vector3d kInTank(0.13, 0.09, -0.03);
const std::vector<Vector3d> kAroundTank = {{0.5, 0.2, 0.3}, {-0.3, 0.4, 0.1}, {0.15, 0.1, 0.5}};
/// Driven by the images, at 500 Hz, 0.4 % from what finer elements give.
const std::vector<Complex>& tank_exact() {
  static const std::vector<Complex> exact =
      validate::detail::forward_from_images({}, 0.05 / 3.0, 500.0, kInTank, kAroundTank, silent_monitor());
  return exact;
}

TEST(Reciprocity, ClosedTankIsThatOfItsImagesWithinTwoPercentWhereForwardSourcesAreTenOff) {
  const ClosedTank tank;
  const LiquidBoundary boundary(tank.mesh(0.02));
  const Vector3d at = kInTank;
  const std::vector<Vector3d>& ears = kAroundTank;
  const std::vector<Complex>& exact = tank_exact();
  const SourcePoints points = random_source_points(boundary, 60, 60, 1);
  const auto found = reciprocal_transfer(boundary, 500.0, points, {{{at, kRadius_m}}, ears})[0];
  const DualDomainResult forward = solve_dual_domain(boundary, 500.0, points, {{at, kRadius_m}})[0];
  for (std::size_t e = 0; e < ears.size(); ++e) {
    const double size = std::abs(exact[e]) * strength(500.0);
    EXPECT_LE(std::abs(found[e].plain - strength(500.0) * exact[e]), 0.02 * size) << e;
    EXPECT_LE(found[e].error_estimate(), 0.02) << e;
    // The estimate of the forward method's error is its error.
    const double error = std::abs(air_pressure(forward, ears[e]) - strength(500.0) * exact[e]) / size;
    EXPECT_GE(error, 0.1) << e;
    const double estimate = std::abs(air_pressure(forward, ears[e]) - found[e].pressure) / std::abs(found[e].pressure);
    EXPECT_LE(std::abs(estimate - error), 0.02) << e;
  }
}

TEST(Reciprocity, CoarserAirAndLiquidAreSeenInTheEstimate) {
  const ClosedTank tank;
  const LiquidBoundary coarse(tank.mesh(0.05));
  const std::vector<Complex>& exact = tank_exact();
  const auto found = reciprocal_transfer(coarse, 500.0, random_source_points(coarse, 60, 1, 1),
                                         {{{kInTank, kRadius_m}}, kAroundTank})[0];
  for (std::size_t e = 0; e < exact.size(); ++e) {
    const double error = std::abs(found[e].plain / strength(500.0) - exact[e]) / std::abs(exact[e]);
    EXPECT_LE(error, 3.0 * found[e].error_estimate()) << e;
    EXPECT_GE(error, 0.1 * found[e].error_estimate()) << e;
  }
}

// k a = pi: without loss the ball of liquid rings for ever. P of a central bubble in closed form.
TEST(LiquidLoss, ResonatingBallIsTheClosedFormInBothDirections) {
  constexpr double kBall_m = 0.05, kEta = 0.05, kFrequency = 1497.0 / (2.0 * kBall_m);
  const LiquidBoundary ball(test::ball(kBall_m, 8));
  ReciprocalOptions options;
  options.pass.liquid_loss_factor = kEta;
  options.estimate_air = false;
  const SourcePoints points = random_source_points(ball, 20, 40, 1);
  const SwingingBubble bubble{{0.0, 0.0, 0.0}, kRadius_m};
  const Complex k = 2.0 * kPi * kFrequency / 1497.0 * std::sqrt(Complex(1.0, -kEta));
  EXPECT_LE(std::abs(k - options.pass.liquid_wavenumber_per_m(kFrequency)), 1e-12 * std::abs(k));
  const Complex slope = k / (4.0 * kPi * kBall_m * std::sin(k * kBall_m));
  const DualDomainResult forward = solve_dual_domain(ball, kFrequency, points, {bubble}, options.pass)[0];
  ASSERT_TRUE(forward.usable());
  for (Eigen::Index i = 0; i < forward.normal_derivative.size(); i += 37)
    EXPECT_LE(std::abs(forward.normal_derivative[i] / forward.source_strength - slope), 2e-5 * std::abs(slope)) << i;
  const double ka = 2.0 * kPi * kFrequency / 343.0;
  const Vector3d ear(0.0, 0.3, 0.4);
  const Complex exact = 1.2041e-3 * slope * kBall_m * kBall_m / (-Complex(1.0, ka * kBall_m)) *
                        std::polar(1.0, -ka * (0.5 - kBall_m)) / 0.5;
  const auto found = reciprocal_transfer(ball, kFrequency, points, {{bubble}, {ear}}, options)[0][0];
  EXPECT_LE(std::abs(found.plain / strength(kFrequency) - exact), 0.05 * std::abs(exact));
  options.pass.liquid_loss_factor = 0.0;
  const auto lossless = reciprocal_transfer(ball, kFrequency, points, {{bubble}, {ear}}, options)[0][0];
  EXPECT_GE(std::abs(lossless.plain), 5.0 * std::abs(found.plain));
}

TEST(LiquidLoss, SlopesOfATankAboveItsFirstModeAreTheImagesOfALossyLiquid) {
  const ClosedTank tank;
  const LiquidBoundary boundary(tank.mesh(0.015));
  const Vector3d at(0.13, 0.09, -0.05);
  DualDomainOptions options;
  options.liquid_loss_factor = 0.05;
  const double frequency = 2495.0;  // c / (4 H)
  const DualDomainResult forward =
      solve_dual_domain(boundary, frequency, random_source_points(boundary, 60, 1, 1), {{at, kRadius_m}}, options)[0];
  ASSERT_TRUE(forward.usable());
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
    const BoundarySample& s = boundary.samples()[i];
    if (s.region != BoundaryRegion::kFreeSurface) continue;
    const Complex exact = tank.top_slope(s.point_m.x(), s.point_m.y(), at, options.liquid_wavenumber_per_m(frequency));
    error += std::norm(forward.normal_derivative[static_cast<Eigen::Index>(i)] / forward.source_strength - exact);
    size += std::norm(exact);
  }
  EXPECT_LE(std::sqrt(error / size), 0.08);
}

/// Root of kappa tan(kappa L / 2) = i k beta: waves cos(kappa x) about the middle between two walls that give way.
Complex across(double length_m, Complex ik_beta) {
  Complex kappa = std::sqrt(2.0 * ik_beta / length_m);
  for (int i = 0; i < 50; ++i) {
    const Complex half = 0.5 * length_m * kappa, f = kappa * std::tan(half) - ik_beta;
    kappa -= f / (std::tan(half) + half / (std::cos(half) * std::cos(half)));
  }
  return kappa;
}

// Between walls that give way, with the pressure cos(kx x) cos(ky y) on top, the liquid's field is a product in closed form.
TEST(WallAdmittance, FieldOfATankWithSoftWallsIsTheClosedForm) {
  const ClosedTank tank;
  const LiquidBoundary boundary(tank.mesh(0.015));
  const double frequency = 2495.0, k0 = 2.0 * kPi * frequency / 1497.0;  // c / (4 H): rigid walls make it ring for ever
  const Vector3d at(0.13, 0.09, -0.08);
  std::vector<double> heights;
  for (const double beta : {0.02, 0.3}) {
    const Complex give(0.0, k0 * beta), kx = across(tank.size_m.x(), give), ky = across(tank.size_m.y(), give),
                                        kz = std::sqrt(k0 * k0 - kx * kx - ky * ky);
    const auto along = [&](double over_floor) {
      return std::cos(kz * over_floor) + give / kz * std::sin(kz * over_floor);
    };
    const auto level = [&](const Vector3d& x) {
      return std::cos(kx * (x.x() - 0.5 * tank.size_m.x())) * std::cos(ky * (x.y() - 0.5 * tank.size_m.y()));
    };
    ReciprocalOptions options;
    options.pass.wall_admittance = beta;
    EarField air;
    air.frequency_hz = frequency;
    air.q.resize(boundary.surface().vertices_m.rows(), 1);
    for (Eigen::Index v = 0; v < air.q.rows(); ++v)
      air.q(v, 0) = level(boundary.surface().vertices_m.row(v).transpose());
    const EarInLiquid found = ear_in_liquid(boundary, air, random_source_points(boundary, 60, 1, 1), options);
    const Complex exact = level(at) * along(at.z() + tank.size_m.z()) / along(tank.size_m.z());
    EXPECT_LE(std::abs(found.w(at, 0) - exact), 0.005 * std::abs(exact)) << beta;
    heights.push_back(std::abs(found.w(at, 0)));
    // The estimate, by the bubble's own field between the same walls, agrees that this is right.
    const ReciprocalTransfer checked =
        checked_transfer(boundary, air, found, random_source_points(boundary, 60, 1, 1), {at, kRadius_m}, options)[0];
    EXPECT_LE(checked.error_liquid, 0.01) << beta;
  }
  EXPECT_GE(heights[0], 3.0 * heights[1]);
}

TEST(ClosedTankImages, ModalSumIsTheSumOverImages) {
  const ClosedTank tank;
  const double k = 2.0 * kPi * 500.0 / 1497.0;
  const test::TankImages images(tank.size_m, k);
  const Vector3d at(0.13, 0.09, -0.03);
  for (const double x : {0.01, 0.13, 0.25})
    EXPECT_LE(std::abs(tank.top_slope(x, 0.1, at, k) - images.top_slope(x, 0.1, at)),
              1e-4 * std::abs(tank.top_slope(0.13, 0.09, at, k)));
}

TEST(TankModes, OfTheSplashAreTheClosedForm) {
  ClosedTank splash;
  splash.size_m = {0.44, 0.44, 0.30};
  const std::vector<TankMode> modes = tank_modes(LiquidBoundary(splash.mesh(0.1)), 1497.0, 0.0, 6000.0);
  ASSERT_GE(modes.size(), 4U);
  const double first[] = {1247.5, 2109.6, 2109.6, 2709.4};  // design: 1248, 2110, 2110, 2710
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LE(std::abs(modes[i].frequency_hz - first[i]), 1.0) << i;
  EXPECT_TRUE(tank_modes(LiquidBoundary(test::ball(0.05, 4)), 1497.0, 0.0, 1e5).empty());
}

TEST(Reciprocity, SameBitsOnAnyNumberOfThreads) {
  const LiquidBoundary ball(test::ball(0.05, 5));
  const SourcePoints points = random_source_points(ball, 10, 1, 1);
  const auto solve = [&](int n_threads) {
    set_thread_count(n_threads);
    return reciprocal_transfer(ball, 2000.0, points,
                               {{{{0.01, 0.0, 0.02}, kRadius_m}}, {Vector3d(0.3, 0.2, 0.4)}})[0][0];
  };
  const ReciprocalTransfer one = solve(1), two = solve(2);
  set_thread_count(0);
  EXPECT_EQ(one.pressure, two.pressure);
  EXPECT_EQ(one.plain, two.plain);
  EXPECT_EQ(one.error_air, two.error_air);
}

TEST(Reciprocity, RefusesAListenerInTheLiquid) {
  const LiquidBoundary ball(test::ball(0.05, 4));
  EXPECT_THROW(ear_field(ball, 500.0, {{0.0, 0.0, 0.01}}), InputError);
  EXPECT_THROW(ear_field(ball, 500.0, {{NAN, 0.0, 0.01}}), InputError);
}

}  // namespace
}  // namespace klang::bubble
