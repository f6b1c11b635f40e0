// Bodies whose edges cross.
#include <gtest/gtest.h>

#include <cmath>

#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

namespace klang::rigid {
namespace {

using Eigen::Vector3d;

/// Cubes of 0.1 m on edge: the upper's lowest edge along x at `height_m` over the lower's highest along y.
struct Crossed {
  RigidBodySpec upper = cuboid("upper", Vector3d::Constant(0.1), 1),
                lower = cuboid("lower", Vector3d::Constant(0.1), 1);
  explicit Crossed(double height_m) {
    upper.orientation = Eigen::AngleAxisd(kPi / 4, Vector3d::UnitX());
    lower.orientation = Eigen::AngleAxisd(kPi / 4, Vector3d::UnitY());
    upper.position_m = Vector3d(0.01, -0.02, 0.1 * std::sqrt(2.0) + height_m);
    lower.fixed = true;
    upper.skin = lower.skin = skin(0.5, 0.0);
  }
};

RigidWorld weightless(double rate_hz) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.gravity_m_s2 = Vector3d::Zero();
  return RigidWorld(options);
}

TEST(Edges, CrossedOnesOverlapByTheirHeightInEitherOrder) {
  for (const double depth_m : {1e-5, 1e-3, 5e-3}) {
    for (const bool lower_first : {false, true}) {
      const Crossed bodies(-depth_m);
      RigidWorld world = weightless(1000);
      world.add(lower_first ? bodies.lower : bodies.upper);
      world.add(lower_first ? bodies.upper : bodies.lower);
      const auto overlap = world.overlap(0.0);
      ASSERT_TRUE(overlap) << depth_m << lower_first;
      EXPECT_LE(std::abs(overlap->depth_m - depth_m), 1e-9) << lower_first;
    }
  }
}

TEST(Edges, CrossedOnesTouchWhenTheyMeetAndWhereTheyCross) {
  constexpr double kHeight = 1.37e-3, kSpeed = 0.8;
  for (const bool lower_first : {false, true}) {
    Crossed bodies(kHeight);
    bodies.upper.velocity_m_s = Vector3d(0, 0, -kSpeed);
    RigidWorld world = weightless(2000);
    const int first = world.add(lower_first ? bodies.lower : bodies.upper);
    const int second = world.add(lower_first ? bodies.upper : bodies.lower);
    const int upper = lower_first ? second : first;
    double impulse_n_s = 0.0;
    for (int i = 0; i < 8; ++i) {
      for (const ContactImpulse& c : world.step().contacts) {
        EXPECT_LE(std::abs(c.time_s - kHeight / kSpeed), 1e-9);
        EXPECT_LE(std::abs(c.approach_m_s - kSpeed), 1e-9);
        EXPECT_LE((c.place_m.head<2>() - Eigen::Vector2d(0, -0.02)).norm(), 1e-9);
        EXPECT_LE((c.normal - (c.a == upper ? 1 : -1) * Vector3d::UnitZ()).norm(), 1e-9);
        impulse_n_s += (c.a == upper ? 1 : -1) * c.impulse_n_s.z();
      }
    }
    // The point of the upper one at r = (-0.01, 0, .) from its centre: J = (1 + e) v / (1/m + r^2/I) with I = m s^2/6.
    EXPECT_LE(std::abs(impulse_n_s - 1.5 * kSpeed / (1 + 1e-4 / (0.01 / 6))), 1e-9) << lower_first;
  }
}

/// Next to the edge that touches, ends slope more gently than the two faces of the edge: what faces the other body most does not
/// reach it.
TEST(Edges, AnAxeRestsOnARoof) {
  RigidBodySpec axe, roof;
  axe.name = "axe";
  axe.parts.resize(1);
  axe.parts[0].corners_m.resize(3, 6);
  axe.parts[0].corners_m << -1, 1, -1.42, -1.42, 1.42, 1.42, 0, 0, -0.134, 0.134, -0.134, 0.134, 0, 0, 0.5, 0.5, 0.5,
      0.5;
  roof.name = "roof";
  roof.parts.resize(1);
  roof.parts[0].corners_m.resize(3, 6);
  roof.parts[0].corners_m << 0, 0, -1, -1, 1, 1, -1, 1, -1, 1, -1, 1, 0, 0, -1, -1, -1, -1;
  for (RigidBodySpec* body : {&axe, &roof}) {
    body->parts[0].corners_m *= 0.01;
    set_mass_from_parts(*body, 7800);
    body->skin = skin(0.0, 0.4);
  }
  roof.fixed = true;
  for (const bool roof_first : {false, true}) {
    RigidBodySpec lowered = axe;
    lowered.position_m.z() = -1e-4;
    RigidWorld overlapping(RigidWorldOptions{});
    overlapping.add(roof_first ? roof : lowered);
    overlapping.add(roof_first ? lowered : roof);
    const auto overlap = overlapping.overlap(0.0);
    ASSERT_TRUE(overlap) << roof_first;
    EXPECT_LE(std::abs(overlap->depth_m - 1e-4), 1e-9);

    RigidWorld world(RigidWorldOptions{});
    const int first = world.add(roof_first ? roof : axe), second = world.add(roof_first ? axe : roof);
    const int on_top = roof_first ? second : first;
    double impulse_n_s = 0.0;
    for (int i = 0; i < 2000; ++i) {
      const StepRecord record = world.step();
      if (i < 1000) continue;
      for (const ContactImpulse& c : record.contacts) impulse_n_s += (c.a == on_top ? 1 : -1) * c.impulse_n_s.z();
    }
    EXPECT_LE(std::abs(world.pose(on_top).position_m.z()), 1e-6) << roof_first;
    EXPECT_LE(std::abs(impulse_n_s / (0.1 * 9.81 * axe.mass_kg) - 1), 1e-3) << roof_first;
  }
}

}  // namespace
}  // namespace klang::rigid
