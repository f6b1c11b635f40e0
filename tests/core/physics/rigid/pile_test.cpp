// Flat bodies with many corners that lie on one another.
#include <gtest/gtest.h>

#include <cmath>

#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

namespace klang::rigid {
namespace {

using Eigen::Vector3d;

constexpr double kHalfThick = 0.0009;

/// By a fifth a step of what is more than a slop, of bodies about 1 long 2e-5, however many of its corners touch.
TEST(Pile, WhatLiesTooDeepRisesByAFifth) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  for (const bool on_a_plate : {false, true}) {
    RigidWorld world(options);
    RigidBodySpec body = coin();
    const double slop = 2e-5 / std::pow(4.0, std::lround(-std::log2(body.size_m()) / 2));
    double depth = 1e-4, ground = 0.0;
    if (on_a_plate) {
      RigidBodySpec plate = coin();
      plate.fixed = true;
      plate.position_m.z() = 0.1;
      ground = plate.position_m.z() + kHalfThick;
      world.add(plate);
    }
    body.position_m.z() = ground + kHalfThick - depth;
    const int number = world.add(body);
    for (int i = 0; i < 8; ++i) {
      world.step();
      depth -= 0.2 * (depth - slop);
      EXPECT_LE(std::abs(ground + kHalfThick - world.centre_m(number).z() - depth), 2e-7) << i << on_a_plate;
    }
  }
}

/// A coin in the floor and a ball 100 times as heavy in the coin: both touches go apart by a fifth a step, whichever body is added first.
TEST(Pile, WhatLiesUnderSomethingHeavyRisesByAFifthInEitherOrder) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  for (const int coin_number : {0, 1}) {
    RigidWorld world(options);
    RigidBodySpec below = coin(), above = ball("ball", 0.012, 100 * below.mass_kg);
    const double slop = 2e-5 / std::pow(4.0, std::lround(-std::log2(below.size_m()) / 2));
    double depth = 1e-4;
    below.position_m.z() = kHalfThick - depth;
    above.position_m.z() = 2 * kHalfThick + 0.012 - 2 * depth;
    for (int i = 0; i < 2; ++i) world.add(i == coin_number ? below : above);
    for (int i = 0; i < 16; ++i) {
      world.step();
      depth -= 0.2 * (depth - slop);
      EXPECT_LE(std::abs(kHalfThick - world.centre_m(coin_number).z() - depth), 1e-6) << i << coin_number;
      EXPECT_LE(std::abs(2 * kHalfThick + 0.012 - world.centre_m(1 - coin_number).z() - 2 * depth), 1e-6)
          << i << coin_number;
    }
  }
}

/// Between the floor and a plate that is fixed it stays: neither touch gets deeper.
TEST(Pile, WhatIsCaughtBetweenFixedThingsStaysWhereItIs) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  for (const int coin_number : {0, 1}) {
    RigidWorld world(options);
    RigidBodySpec below = coin(), plate = coin();
    const double depth = 1e-4, above = 6e-5;
    below.position_m.z() = kHalfThick - depth;
    plate.position_m.z() = 3 * kHalfThick - depth - above;
    plate.fixed = true;
    for (int i = 0; i < 2; ++i) world.add(i == coin_number ? below : plate);
    for (int i = 0; i < 50; ++i) world.step();
    EXPECT_LE(std::abs(world.centre_m(coin_number).z() - below.position_m.z()), 1e-6) << coin_number;
  }
}

/// It falls loosely and lies: nothing strikes any more, nothing moves, and the solver has put next to nothing in.
TEST(Pile, OfCoinsComesToRest) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  RigidWorld world(options);
  for (int i = 0; i < 12; ++i) {
    RigidBodySpec body = coin();
    const double turn = 0.7 * i;
    body.orientation =
        Eigen::Quaterniond(1, 0.12 * std::sin(3 * turn), 0.12 * std::cos(2 * turn), 0.3 * turn).normalized();
    body.position_m << 0.026 * (i % 2), 0.026 * (i / 2 % 2), 0.012 * (0.6 + i / 4);
    world.add(body);
  }
  const double start_j = world.ledger().potential_j;
  for (int i = 0; i < 1750; ++i) world.step();
  EXPECT_LE(world.ledger().kinetic_j, 1e-12 * start_j);
  EXPECT_LE(std::abs(world.ledger().correction_j), 2e-3 * start_j);
  for (int i = 0; i < 250; ++i)
    for (const ContactImpulse& contact : world.step().contacts)
      ASSERT_EQ(contact.kind, events::ImpulseKind::kLasting) << i;
}

}  // namespace
}  // namespace klang::rigid
