// Motion over many steps: flight, sliding, rolling, rest, the ledger, Froude's scaling.
#include "core/physics/rigid/rigid_world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

using namespace klang::rigid;
using Eigen::Vector3d;

namespace {

RigidWorldOptions on_the_floor(double rate_hz, const Skin& floor) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.floor = floor;
  return options;
}

/// Two cubes, a ball and a flat box that fall on each other, `scale` times as large.
RigidWorld heap(double scale, double time_scale) {
  RigidWorld world(on_the_floor(8192 / time_scale, skin(0.5, 0.3)));
  for (int i = 0; i < 6; ++i) {
    RigidBodySpec body =
        i % 3 == 2 ? ball("b", 0.015 * scale, 0.05) : cuboid("b", scale * Vector3d(0.03, 0.02, 0.016), 0.05);
    body.skin = skin(0.5, 0.3);
    body.position_m = scale * Vector3d(0.003 * (i % 2), 0.004 * (i % 3), 0.03 + 0.04 * i);
    body.orientation = Eigen::AngleAxisd(0.4 * i, Vector3d(1, 0.5 * i, 0.3).normalized());
    body.angular_velocity_rad_s = Vector3d(3, 1, 2 * i) / time_scale;
    world.add(body);
  }
  return world;
}

}  // namespace

TEST(RigidWorld, AThrownBodyFliesOnItsParabola) {
  RigidWorldOptions options;
  options.rate_hz = 1000;
  RigidWorld world(options);
  RigidBodySpec body = cuboid("box", {0.05, 0.04, 0.03}, 0.1);
  body.velocity_m_s = Vector3d(1, 2, 3);
  body.angular_velocity_rad_s = Vector3d(5, 6, 7);
  world.add(body);
  for (int i = 0; i < 1000; ++i) world.step();
  EXPECT_NEAR((world.centre_m(0) - Vector3d(1, 2, 3 - 9.81 / 2)).norm(), 0, 1e-12);
  EXPECT_LE(std::abs(world.ledger().residual_j), 1e-12);
}

// tests/reference/contact.json, coulomb: mu = 0.3, 2 m/s, g = 9.81: 0.67957866 m.
TEST(RigidWorld, ACubeSlidesAsFarAsCoulombSays) {
  RigidWorld world(on_the_floor(5000, skin(0, 0.3)));
  RigidBodySpec cube = cuboid("cube", Vector3d::Constant(0.05), 0.3);
  cube.skin = skin(0, 0.3);
  cube.position_m = Vector3d(0, 0, 0.025);
  cube.velocity_m_s = Vector3d(1.2, 1.6, 0);
  world.add(cube);
  for (int i = 0; i < 4000; ++i) world.step();
  const Vector3d way = world.centre_m(0) - cube.position_m;
  EXPECT_NEAR(way.norm(), 0.6795786612300374, 1e-3 * 0.68);
  EXPECT_NEAR(std::atan2(way.y(), way.x()), std::atan2(1.6, 1.2), 1e-4);
  EXPECT_LE(world.velocity_m_s(0).norm(), 1e-9);
  EXPECT_NEAR(world.ledger().friction_j, 0.5 * 0.3 * 4, 1e-3);
}

// tests/reference/contact.json, sphere_slides_to_roll: 2 m/s becomes 10/7 m/s, 2/7 of the energy is lost.
TEST(RigidWorld, ASlidingBallEndsRollingAtFiveSeventhsOfItsSpeed) {
  RigidWorld world(on_the_floor(5000, skin(0, 0.3)));
  RigidBodySpec body = ball("ball", 0.02, 0.1);
  body.skin = skin(0, 0.3);
  body.position_m = Vector3d(0, 0, 0.02);
  body.velocity_m_s = Vector3d(2, 0, 0);
  world.add(body);
  for (int i = 0; i < 2000; ++i) world.step();
  EXPECT_NEAR(world.velocity_m_s(0).x(), 10.0 / 7, 1e-3);
  EXPECT_NEAR(world.ledger().friction_j, 0.5 * 0.1 * 4 * 2 / 7, 1e-3 * 0.06);
}

TEST(RigidWorld, AStackOfTenStandsAndTheFloorCarriesItsWeightInEveryStep) {
  RigidWorld world(on_the_floor(10000, skin(0.2, 0.5)));
  for (int i = 0; i < 10; ++i) {
    RigidBodySpec cube = cuboid("cube", Vector3d::Constant(0.02), 0.05);
    cube.skin = skin(0.2, 0.5);
    cube.position_m = Vector3d(0, 0, 0.01 + 0.02 * i);
    world.add(cube);
  }
  double least = HUGE_VAL, most = 0;
  for (int i = 0; i < 3000; ++i) {
    double impulse = 0;
    for (const ContactImpulse& c : world.step().contacts) {
      if (c.b == kFloor) impulse += c.impulse_n_s.z();
    }
    least = std::min(least, impulse);
    most = std::max(most, impulse);
  }
  const double weight = 0.5 * 9.81 * 1e-4;
  EXPECT_GE(least, 0.95 * weight);
  EXPECT_LE(most, 1.05 * weight);
  EXPECT_NEAR(world.centre_m(9).z(), 0.19, 1e-4);
}

TEST(RigidWorld, EveryImpulseIsMomentumAndEveryJouleIsAccountedFor) {
  RigidWorld world = heap(1.0, 1.0);
  const double start = world.ledger().kinetic_j + world.ledger().potential_j;
  EnergyLedger last = world.ledger();
  double worst_momentum = 0;
  for (int i = 0; i < 4096; ++i) {
    std::vector<Vector3d> momentum;
    for (int b = 0; b < world.n_bodies(); ++b) momentum.push_back(0.05 * world.velocity_m_s(b));
    const StepRecord record = world.step();
    for (Vector3d& p : momentum) p += 0.05 * Vector3d(0, 0, -9.81 / 8192);
    for (const ContactImpulse& c : record.contacts) {
      momentum[static_cast<std::size_t>(c.a)] += c.impulse_n_s;
      if (c.b >= 0) momentum[static_cast<std::size_t>(c.b)] -= c.impulse_n_s;
    }
    for (int b = 0; b < world.n_bodies(); ++b) {
      worst_momentum =
          std::max(worst_momentum, (momentum[static_cast<std::size_t>(b)] - 0.05 * world.velocity_m_s(b)).norm());
    }
    ASSERT_GE(world.ledger().contact_j, last.contact_j);
    ASSERT_GE(world.ledger().friction_j, last.friction_j);
    last = world.ledger();
    ASSERT_LE(std::abs(last.residual_j), 1e-9 * start) << i;
  }
  EXPECT_LE(worst_momentum, 1e-14);
  EXPECT_LE(std::abs(last.correction_j), 1e-3 * start);
}

TEST(RigidWorld, ASceneFourTimesAsLargeMovesInTheSameBitsTwiceAsSlowly) {
  RigidWorld small = heap(1.0, 1.0), large = heap(4.0, 2.0);
  for (int i = 0; i < 3000; ++i) {
    small.step();
    large.step();
  }
  for (int b = 0; b < small.n_bodies(); ++b) {
    EXPECT_EQ(4 * small.centre_m(b), large.centre_m(b));
    EXPECT_EQ(small.pose(b).orientation_wxyz, large.pose(b).orientation_wxyz);
  }
}

// Four hundred stones packed so that more pairs of boxes meet than one thread takes.
TEST(RigidWorld, AHeapMovesInTheSameBitsOnAnyNumberOfThreads) {
  const auto places = [](int n_threads) {
    klang::set_thread_count(n_threads);
    RigidWorld world(on_the_floor(5000, skin(0.5, 0.3)));
    for (int i = 0; i < 400; ++i) {
      RigidBodySpec body = stone(0.01);
      body.skin = skin(0.5, 0.3);
      body.position_m = 0.0201 * Vector3d(i % 8, i / 8 % 8, 0.6 + i / 64);
      body.orientation = Eigen::AngleAxisd(0.1 * i, Vector3d::UnitZ());
      world.add(body);
    }
    for (int i = 0; i < 250; ++i) world.step();
    std::vector<Vector3d> all;
    for (int i = 0; i < world.n_bodies(); ++i) all.push_back(world.centre_m(i));
    klang::set_thread_count(0);
    return all;
  };
  EXPECT_EQ(places(1), places(4));
}

TEST(RigidWorld, ABodyFasterThanItsHalfWidthPerStepIsRefusedByName) {
  RigidWorldOptions options;
  options.rate_hz = 1000;
  RigidWorld world(options);
  RigidBodySpec bullet = ball("bullet", 0.002, 0.01);
  bullet.velocity_m_s = Vector3d(5, 0, 0);
  world.add(bullet);
  try {
    world.step();
    FAIL() << "no error";
  } catch (const klang::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("bullet"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("rate_hz"), std::string::npos) << error.what();
  }
}

TEST(RigidWorld, OverlappingBodiesAreFoundWithTheirDepth) {
  RigidWorld world(on_the_floor(1000, skin(0.5, 0.5)));
  RigidBodySpec a = cuboid("a", Vector3d::Constant(0.1), 1), b = cuboid("b", Vector3d::Constant(0.1), 1);
  a.position_m = Vector3d(0, 0, 0.05);
  b.position_m = Vector3d(0, 0, 0.148);
  world.add(a);
  EXPECT_FALSE(world.overlap(1e-6));
  world.add(b);
  const auto overlap = world.overlap(1e-6);
  ASSERT_TRUE(overlap);
  EXPECT_EQ(overlap->a, 0);
  EXPECT_EQ(overlap->b, 1);
  EXPECT_NEAR(overlap->depth_m, 0.002, 1e-9);
}
