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
