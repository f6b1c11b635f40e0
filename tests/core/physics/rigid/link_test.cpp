// Cords and hinges: pendulums against their closed forms, and what they take from the ledger.
#include <gtest/gtest.h>

#include <cmath>

#include "core/physics/rigid/impact_pulse.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

using namespace klang::rigid;
using Eigen::Vector3d;

namespace {

RigidWorld without_floor(double rate_hz) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.floor.reset();
  return RigidWorld(options);
}

/// Times at which x falls through zero.
std::vector<double> falls(RigidWorld& world, int body, double until_s) {
  std::vector<double> times;
  double before = world.centre_m(body).x(), before_s = 0.0;
  while (world.time_s() < until_s) {
    world.step();
    const double x = world.centre_m(body).x();
    if (before > 0 && x <= 0) times.push_back(before_s + (world.time_s() - before_s) * before / (before - x));
    before = x;
    before_s = world.time_s();
  }
  return times;
}

/// K(sin(angle / 2)) 2 / pi by the arithmetic-geometric mean.
double pendulum_factor(double angle) {
  double a = 1.0, b = std::cos(angle / 2);
  for (int i = 0; i < 20; ++i) std::tie(a, b) = std::pair((a + b) / 2, std::sqrt(a * b));
  return 1.0 / a;
}

double worst_residual(const RigidWorld& world) { return std::abs(world.ledger().residual_j); }

}  // namespace

// A small ball on a cord of 0.5 m to its centre swings as the mathematical pendulum, which it is: its spin has nothing to do.
TEST(Link, ABallOnACordSwingsAsThePendulum) {
  const double length = 0.5, angle = 0.6;
  std::vector<double> lost_j;
  for (const double rate_hz : {5000.0, 20000.0}) {
    RigidWorld world = without_floor(rate_hz);
    RigidBodySpec bob = ball("bob", 0.01, 0.1);
    bob.position_m = {length * std::sin(angle), 0, -length * std::cos(angle)};
    world.add(bob);
    world.link({0, kFloor, Vector3d::Zero(), Vector3d::Zero(), length});
    const std::vector<double> times = falls(world, 0, 4.0);
    ASSERT_GE(times.size(), 3u);
    const double period = 2 * M_PI * std::sqrt(length / 9.81) * pendulum_factor(angle);
    EXPECT_LE(std::abs((times[2] - times[0]) / (2 * period) - 1.0), 4.0 / rate_hz) << rate_hz;
    EXPECT_LE(std::abs(world.centre_m(0).norm() - length), 1e-5);
    EXPECT_LE(worst_residual(world), 1e-12);
    // What the cord takes of the swing falls with the step.
    const double start_j = 0.1 * 9.81 * length * (1 - std::cos(angle));
    EXPECT_GE(world.ledger().contact_j, -1e-12);
    EXPECT_LE(world.ledger().contact_j, 60.0 / rate_hz * start_j);
    lost_j.push_back(world.ledger().contact_j);
  }
  EXPECT_LE(std::abs(lost_j[0] / lost_j[1] / 4.0 - 1.0), 0.02);  // order 1
}

// A slender rod on a hinge through its end: I = m l^2 / 3 about it, so that the pendulum's length is 2 l / 3; it stays in its plane.
TEST(Link, ARodOnAHingeSwingsAsThePhysicalPendulum) {
  const double length = 0.4, angle = 0.5;
  RigidWorld world = without_floor(10000.0);
  RigidBodySpec rod = cuboid("rod", {0.004, 0.004, length}, 0.05);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(-angle, Vector3d::UnitY()));
  rod.orientation = turn;
  rod.position_m = turn * Vector3d(0, 0, -length / 2);
  world.add(rod);
  for (const double y : {-0.05, 0.05}) world.link({0, kFloor, Vector3d(0, y, length / 2), Vector3d(0, y, 0), {}});
  const double inertia = world.spec(0).inertia_kg_m2(1, 1) + 0.05 * length * length / 4;
  const std::vector<double> times = falls(world, 0, 3.0);
  ASSERT_GE(times.size(), 2u);
  const double period = 2 * M_PI * std::sqrt(inertia / (0.05 * 9.81 * length / 2)) * pendulum_factor(angle);
  EXPECT_LE(std::abs((times[1] - times[0]) / period - 1.0), 1e-3);
  EXPECT_LE(std::abs(world.centre_m(0).y()), 1e-6);
  EXPECT_LE(std::abs(world.centre_m(0).norm() - length / 2), 1e-5);
  EXPECT_LE(worst_residual(world), 1e-12);
}

namespace {

/// A bar of 0.3 m along x, hinged about y at its end, and where `bars` is 2 another one hinged to its other end; a ball falls on the
/// first at x, without friction, loss or gravity.
RigidWorld struck_bars(double rate_hz, int bars, double x, CollisionOrder order) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.collisions = order;
  options.gravity_m_s2.setZero();
  options.floor.reset();
  RigidWorld world(options);
  for (int i = 0; i < bars; ++i) {
    RigidBodySpec bar = cuboid("bar", {0.3, 0.03, 0.02}, 0.5);
    bar.skin = skin(1.0, 0.0);
    bar.position_m.x() = 0.31 * i;
    world.add(bar);
    for (const double y : {-0.05, 0.05}) {
      if (i == 0)
        world.link({0, kFloor, Vector3d(-0.15, y, 0), Vector3d(-0.15, y, 0), {}});
      else
        world.link({i - 1, i, Vector3d(0.155, y, 0), Vector3d(-0.155, y, 0), {}});
    }
  }
  RigidBodySpec striker = ball("ball", 0.02, 0.09);
  striker.skin = skin(1.0, 0.0);
  striker.position_m = {x, 0, 0.0305};
  striker.velocity_m_s = {0, 0, -1};
  world.add(striker);
  while (world.time_s() < 0.0099) world.step();
  return world;
}

}  // namespace

// J = 2 v / (1 / m + a^2 / I) with I the bar's about its hinge, at a from it: the hinge holds while it is struck.
TEST(Link, ABlowOnABodyOnAHingeIsThatOfTheBodyThatTurnsAboutIt) {
  for (const double rate_hz : {1000.0, 5000.0, 10000.0})
    for (const double x : {0.0, 0.12}) {
      const RigidWorld world = struck_bars(rate_hz, 1, x, CollisionOrder::kPairwise);
      const double arm = x + 0.15, inertia = world.spec(0).inertia_kg_m2(1, 1) + 0.5 * 0.15 * 0.15;
      const double impulse = 2 / (1 / 0.09 + arm * arm / inertia);
      EXPECT_NEAR(world.velocity_m_s(1).z(), -1 + impulse / 0.09, 1e-9) << rate_hz << ' ' << x;
      EXPECT_NEAR(world.angular_velocity_rad_s(0).y(), impulse * arm / inertia, 1e-3 * impulse * arm / inertia);
      EXPECT_NEAR(world.ledger().contact_j, 0.0, 1e-3 * 0.045) << rate_hz << ' ' << x;
    }
}

// And what hangs on what is struck is struck with it, in either order of impacts.
TEST(Link, ABlowGoesOnThroughAChainOfHinges) {
  const RigidWorld pairwise = struck_bars(10000.0, 2, 0.1, CollisionOrder::kPairwise),
                   simultaneous = struck_bars(10000.0, 2, 0.1, CollisionOrder::kSimultaneous);
  for (int body = 0; body < 3; ++body) {
    EXPECT_LE((pairwise.velocity_m_s(body) - simultaneous.velocity_m_s(body)).norm(), 1e-9) << body;
    EXPECT_LE((pairwise.angular_velocity_rad_s(body) - simultaneous.angular_velocity_rad_s(body)).norm(), 1e-9) << body;
  }
  EXPECT_GT(std::abs(pairwise.angular_velocity_rad_s(1).y()), 0.1);
}

namespace {

/// Contact time of the first impact, at 1 m/s; the bodies without friction or loss.
double first_contact_s(RigidWorld world) {
  while (world.time_s() < 0.01)
    for (const ContactImpulse& row : world.step().contacts) {
      EXPECT_NEAR(row.approach_m_s, 1.0, 1e-12);
      return row.duration_s;
    }
  ADD_FAILURE() << "nothing strikes";
  return 0.0;
}

RigidBodySpec smooth(RigidBodySpec body) {
  body.skin = skin(1.0, 0.0);
  return body;
}

RigidWorld in_space(CollisionOrder order) {
  RigidWorldOptions options;
  options.collisions = order;
  options.gravity_m_s2.setZero();
  options.floor.reset();
  return RigidWorld(options);
}

}  // namespace

// A bar that swings about its hinge is struck along itself without loss, so that the hinge alone stops the ball: it goes back as fast as it came, though
// the hinge is off by w^2 r t since the step's begin.
TEST(Link, ABlowAlongABarThatSwingsIsGivenBack) {
  for (const double rate_hz : {1000.0, 5000.0}) {
    RigidWorldOptions options;
    options.rate_hz = rate_hz;
    options.gravity_m_s2.setZero();
    options.floor.reset();
    RigidWorld world(options);
    RigidBodySpec bar = smooth(cuboid("bar", {0.3, 0.02, 0.02}, 0.5)), striker = smooth(ball("ball", 0.02, 0.09));
    const double spin = 5.0, gap = 0.0021;  // met after 2.1 ms, when the bar lies along x but for 0.01
    bar.orientation = Eigen::AngleAxisd(spin * gap, Vector3d::UnitY());
    bar.position_m = bar.orientation * Vector3d(0.15, 0, 0);
    bar.angular_velocity_rad_s = {0, -spin, 0};
    bar.velocity_m_s = bar.angular_velocity_rad_s.cross(bar.position_m);
    world.add(bar);
    for (const double y : {-0.05, 0.05}) world.link({0, kFloor, Vector3d(-0.15, y, 0), Vector3d(0, y, 0), {}});
    striker.position_m = {0.32 + gap, 0, 0};
    striker.velocity_m_s = {-1, 0, 0};
    world.add(striker);
    const double start_j = world.ledger().kinetic_j;
    while (world.time_s() < 0.01) world.step();
    EXPECT_NEAR(world.velocity_m_s(1).x(), 1.0, 2e-3) << rate_hz;
    EXPECT_NEAR(world.ledger().kinetic_j, start_j, 2e-3 * start_j) << rate_hz;
  }
}

// T goes as m^0.4, m = 1 / (1 / m_ball + a^2 / I_hinge) on the hinge, 1 / (1 / m_ball + 1 / M + x^2 / I) without it.
TEST(Link, ABlowOnABodyOnAHingeLastsAsOnTheBodySoHeld) {
  for (const CollisionOrder order : {CollisionOrder::kPairwise, CollisionOrder::kSimultaneous})
    for (const double x : {-0.13, -0.1, 0.0, 0.12}) {
      double time_s[2], mass_kg[2];
      for (const int hinged : {0, 1}) {
        RigidWorld world = in_space(order);
        world.add(smooth(cuboid("bar", {0.3, 0.03, 0.02}, 0.5)));
        if (hinged != 0)
          for (const double y : {-0.05, 0.05})
            world.link({0, kFloor, Vector3d(-0.15, y, 0), Vector3d(-0.15, y, 0), {}});
        RigidBodySpec striker = smooth(ball("ball", 0.02, 0.09));
        striker.position_m = {x, 0, 0.0305};
        striker.velocity_m_s = {0, 0, -1};
        world.add(striker);
        const double inertia = world.spec(0).inertia_kg_m2(1, 1), arm = x + 0.15;
        mass_kg[hinged] = 1 / (hinged != 0 ? 1 / 0.09 + arm * arm / (inertia + 0.5 * 0.15 * 0.15)
                                           : 1 / 0.09 + 1 / 0.5 + x * x / inertia);
        time_s[hinged] = first_contact_s(std::move(world));
      }
      EXPECT_NEAR(time_s[1] / time_s[0] / std::pow(mass_kg[1] / mass_kg[0], 0.4), 1.0, 1e-9) << x;
    }
}

// From above the cord holds the ball that hangs on it, m = m_ball; from below it does not, 1 / m = 1 / m_ball + 1 / M.
TEST(Link, ACordHoldsWhatABlowPullsItFrom) {
  double time_s[2];
  for (const int below : {0, 1}) {
    RigidWorld world = in_space(CollisionOrder::kPairwise);
    world.add(smooth(ball("bob", 0.03, 0.5)));
    world.link({0, kFloor, Vector3d::Zero(), Vector3d(0, 0, 0.5), 0.5});
    RigidBodySpec striker = smooth(ball("striker", 0.02, 0.09));
    striker.position_m = {0, 0, below != 0 ? -0.0505 : 0.0505};
    striker.velocity_m_s = {0, 0, below != 0 ? 1.0 : -1.0};
    world.add(striker);
    time_s[below] = first_contact_s(std::move(world));
  }
  EXPECT_NEAR(time_s[0] / time_s[1] / std::pow(1 + 0.09 / 0.5, 0.4), 1.0, 1e-9);
}

// Two balls tied by a cord fly apart until it is taut, then together with the velocity of their centre along it: momentum is kept,
// the energy that is gone is booked.
TEST(Link, ACordThatBecomesTautTakesTheSpeedAlongIt) {
  RigidWorldOptions options;
  options.gravity_m_s2.setZero();
  options.floor.reset();
  RigidWorld world(options);
  RigidBodySpec a = ball("a", 0.01, 0.1), b = ball("b", 0.01, 0.3);
  a.velocity_m_s = {-2, 0.5, 0};
  b.position_m = {0.1, 0, 0};
  world.add(a);
  world.add(b);
  world.link({1, 0, Vector3d::Zero(), Vector3d::Zero(), 0.2});
  const double start_j = world.ledger().kinetic_j;
  while (world.time_s() < 0.1) world.step();
  const Vector3d momentum = 0.1 * world.velocity_m_s(0) + 0.3 * world.velocity_m_s(1);
  EXPECT_LE((momentum - Vector3d(-0.2, 0.05, 0)).norm(), 1e-14);
  EXPECT_LE((world.centre_m(0) - world.centre_m(1)).norm(), 0.2 + 1e-5);
  EXPECT_LT(world.ledger().kinetic_j, 0.7 * start_j);
  EXPECT_LE(std::abs(world.ledger().kinetic_j + world.ledger().contact_j + world.ledger().friction_j +
                     world.ledger().correction_j - world.ledger().work_j - start_j),
            1e-13);
}
