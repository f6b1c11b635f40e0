// Single impacts against closed forms. Values marked "tests/reference/contact.json" are from tests/reference.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/rigid/impact_pulse.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

using namespace klang::rigid;
using Eigen::Vector3d;
using klang::kPi;

namespace {

/// Rebound over impact speed of the point that touches, where both are taken at the moment of touch.
struct Drop {
  double speed_m_s, rate_hz, phase;
};

/// The body's centre falls from a height that it reaches with the speed; only a body that touches below its centre keeps all of it.
double rebound(RigidBodySpec body, const Drop& drop, double restitution, double lowest_m) {
  RigidWorldOptions options;
  options.rate_hz = drop.rate_hz;
  options.floor = skin(restitution, 0.4);
  body.skin = skin(restitution, 0.4);
  RigidWorld world(options);
  const double way = drop.speed_m_s / drop.rate_hz * (1 + drop.phase);
  body.position_m = Vector3d(0, 0, lowest_m + way);
  body.velocity_m_s = Vector3d(0, 0, -std::sqrt(drop.speed_m_s * drop.speed_m_s - 2 * 9.81 * way));
  world.add(body);
  double before = 0, after = 0;
  for (int i = 0; i < 4 && before == 0; ++i) {
    for (const ContactImpulse& c : world.step().contacts) {
      before = c.approach_m_s;
      after += c.impulse_n_s.z() / body.mass_kg;
    }
  }
  EXPECT_NEAR(before, drop.speed_m_s, 1e-9 * drop.speed_m_s);
  return after / before - 1;
}

}  // namespace

TEST(Impact, BallsAndCubesReboundWithTheirRestitutionAtEveryRateSpeedAndPhase) {
  for (double rate : {1000.0, 5000.0, 10000.0}) {
    for (double speed : {0.1, 1.0, 4.0}) {
      for (double phase : {0.0, 0.21, 0.5, 0.83}) {
        for (double e : {0.3, 0.6, 1.0}) {
          EXPECT_NEAR(rebound(ball("ball", 0.01, 0.03), {speed, rate, phase}, e, 0.01), e, 1e-9);
          EXPECT_NEAR(rebound(cuboid("cube", Vector3d::Constant(0.02), 0.03), {speed, rate, phase}, e, 0.01), e, 1e-9);
        }
      }
    }
  }
}

TEST(Impact, HullsOnACuboidReboundAsOnTheFloor) {
  for (double rate : {1000.0, 5000.0, 10000.0}) {
    for (double speed : {0.1, 1.0, 4.0}) {
      RigidWorldOptions options;
      options.rate_hz = rate;
      RigidWorld world(options);
      RigidBodySpec slab = cuboid("slab", {0.4, 0.4, 0.04}, 1.0);
      slab.position_m = Vector3d(0, 0, -0.02);
      slab.fixed = true;
      slab.skin = skin(0.6, 0.0);
      RigidBodySpec body = stone(0.01);
      body.skin = skin(0.6, 0.0);
      body.position_m = Vector3d(0.003, 0.001, 0.01 + 2.3 * speed / rate);
      body.velocity_m_s = Vector3d(0, 0, -speed);
      world.add(slab);
      const int number = world.add(body);
      double approach = 0, separation = 0;
      Vector3d impulse = Vector3d::Zero();
      for (int i = 0; i < 1000 && approach == 0; ++i) {
        const auto record = world.step();
        for (const ContactImpulse& c : record.contacts) {
          if (c.kind != klang::events::ImpulseKind::kImpact) continue;
          approach = c.approach_m_s;
          impulse += (c.a == number ? 1 : -1) * c.impulse_n_s;
        }
      }
      ASSERT_GT(approach, 0.9 * speed);
      // J of a frictionless impact at arm r: (1 + e) u / (1/m + (r x n) . I^-1 (r x n)); here by what moved.
      separation = 0.6 * approach;
      const double energy_lost = world.ledger().contact_j;
      // With one point: energy lost = J (u - e u) / 2.
      EXPECT_NEAR(energy_lost, impulse.norm() * (approach - separation) / 2, 1e-9 * energy_lost);
    }
  }
}

// A tile that clatters down on a floor: where one corner strikes, corners that lie there already are pressed on without approach.
TEST(Impact, PlacesThatOthersPressOnTakeAsLongAsABlowOfTheirImpulse) {
  RigidWorldOptions options;
  options.rate_hz = 10000.0;
  options.floor = skin(0.5, 0.4);
  RigidWorld world(options);
  RigidBodySpec tile = cuboid("tile", {0.1, 0.1, 0.008}, 0.2);
  tile.skin = skin(0.5, 0.4);
  tile.position_m = Vector3d(0, 0, 0.06);
  tile.orientation = Eigen::AngleAxisd(0.5, Vector3d(1, 0.3, 0).normalized());
  world.add(tile);
  int n_pressed = 0, n_impacts = 0;
  double longest_s = 0.0, shortest_s = 1.0;
  while (world.time_s() < 1.0)
    for (const ContactImpulse& contact : world.step().contacts) {
      if (contact.kind != klang::events::ImpulseKind::kImpact || !(contact.impulse_n_s.z() > 0.0)) continue;
      ++n_impacts;
      EXPECT_GT(contact.duration_s, 0.0) << world.time_s();
      if (contact.approach_m_s > 0.0) {
        longest_s = std::max(longest_s, contact.duration_s);
        shortest_s = std::min(shortest_s, contact.duration_s);
      } else {
        ++n_pressed;
      }
    }
  EXPECT_GE(n_impacts, 30);
  EXPECT_GE(n_pressed, 1);
  EXPECT_LE(longest_s / shortest_s, 30.0);
}

// tests/reference/contact.json, rod_drop_frictionless: mass 0.05 kg, length 0.2 m, speed 1 m/s; J = (1+e) m v / (1 + 3 cos^2).
TEST(Impact, ARodThatLandsOnItsEndGetsTheClosedFormsImpulseAndSpin) {
  struct Row {
    double angle_deg, e, impulse_n_s, spin_rad_s, speed_m_s;
  };
  const Row rows[] = {{15, 1.0, 0.026322452478319824, 15.255321996045485, -0.4735509504336035},
                      {30, 0.0, 0.015384615384615385, 7.994080650317895, -0.6923076923076923},
                      {30, 0.5, 0.02307692307692308, 11.991120975476841, -0.5384615384615383},
                      {30, 1.0, 0.03076923076923077, 15.98816130063579, -0.3846153846153846}};
  for (const Row& row : rows) {
    RigidBodySpec rod;
    rod.name = "rod";
    rod.mass_kg = 0.05;
    const double across = 1e-12, along = 0.05 * 0.04 / 12;  // a thin rod; what it has about its axis does not count
    rod.inertia_kg_m2 = Vector3d(across, along, along).asDiagonal();
    ConvexPart part;
    part.corners_m.resize(3, 2);
    part.corners_m << -0.1, 0.1, 0, 0, 0, 0;
    rod.parts.push_back(part);
    rod.skin = skin(row.e, 0.0);
    const double angle = row.angle_deg * kPi / 180;
    rod.orientation = Eigen::AngleAxisd(angle, -Vector3d::UnitY());  // one end is up by the angle
    RigidWorldOptions options;
    options.gravity_m_s2.setZero();
    options.rate_hz = 20000;
    options.floor = skin(row.e, 0.0);
    rod.position_m = Vector3d(0, 0, 0.1 * std::sin(angle) + 1e-5);
    rod.velocity_m_s = Vector3d(0, 0, -1);
    RigidWorld world(options);
    world.add(rod);
    double impulse = 0;
    for (const ContactImpulse& c : world.step().contacts) impulse += c.impulse_n_s.z();
    EXPECT_NEAR(impulse, row.impulse_n_s, 1e-6 * row.impulse_n_s) << row.angle_deg << " deg, e " << row.e;
    EXPECT_NEAR(world.angular_velocity_rad_s(0).norm(), row.spin_rad_s, 1e-6 * row.spin_rad_s);
    EXPECT_NEAR(world.velocity_m_s(0).z(), row.speed_m_s, 1e-6);
  }
}

// tests/reference/contact.json, hertz: a glass ball of 10 mm at 1 m/s on concrete.
TEST(Impact, ContactTimeIsHertzs) {
  EXPECT_NEAR(hertz_duration_s(0.010890854532444618, 0.01, 21059782608.695652, 1.0), 8.771272603493277e-05, 1e-18);
}

// A ball; curvatures that differ little act by their geometric mean; a long ellipse is stiffer than that.
TEST(Impact, EllipticTouchesAreHertzs) {
  EXPECT_NEAR(elliptic_radius_m(100, 100), 0.01, 1e-12);
  EXPECT_NEAR(elliptic_radius_m(100 * (1 + 1e-4), 100 * (1 - 1e-4)), 0.01, 1e-8);
  // By SciPy's elliptic integrals.
  EXPECT_NEAR(elliptic_radius_m(200, 50), 0.010811924198241544, 1e-12);
  EXPECT_NEAR(elliptic_radius_m(1000, 10), 0.020593881414920655, 1e-12);
}

// Balls that do not turn: impulse m (1 + e) v_n n at the exact touch, whatever the step.
TEST(Impact, GlancingBallsPushAlongTheNormalOfTheirTouch) {
  for (const double rate_hz : {1000.0, 10000.0}) {
    for (const double offset_m : {0.005, 0.02, 0.023}) {
      RigidWorldOptions options;
      options.rate_hz = rate_hz;
      options.gravity_m_s2.setZero();
      RigidWorld world(options);
      for (const double radius_m : {0.01, 0.015}) {
        RigidBodySpec b = ball("ball " + std::to_string(radius_m), radius_m, 1e4 * radius_m * radius_m * radius_m);
        b.skin = skin(0.6, 0.0);
        if (radius_m == 0.01) b.position_m = Vector3d(-0.0313, offset_m, 0);
        if (radius_m == 0.01) b.velocity_m_s = Vector3d(4, 0, 0);
        world.add(b);
      }
      Vector3d impulse = Vector3d::Zero();
      for (int i = 0; i < 0.01 * rate_hz; ++i)
        for (const ContactImpulse& c : world.step().contacts) impulse += c.impulse_n_s;
      const double along_m = std::sqrt(0.025 * 0.025 - offset_m * offset_m);
      const Vector3d normal = Vector3d(-along_m, offset_m, 0) / 0.025;
      const double mass_kg = 1 / (1 / 0.01 + 1 / 0.03375);
      const Vector3d expected = mass_kg * 1.6 * 4 * along_m / 0.025 * normal;
      EXPECT_LE((impulse - expected).norm(), 1e-9 * expected.norm()) << rate_hz << " Hz, " << offset_m << " m";
    }
  }
}

// A ball that strikes the middle of a flat plate touches as one on the floor.
TEST(Impact, AFlatFaceHasNoRadius) {
  RigidWorldOptions options;
  options.gravity_m_s2.setZero();
  RigidWorld world(options);
  RigidBodySpec plate = cuboid("plate", {1, 1, 0.02}, 50), ball_on_it = ball("ball", 0.02, 0.1);
  plate.curvature = [](const Vector3d&, const Vector3d&) { return Eigen::Matrix3d(Eigen::Matrix3d::Zero()); };
  plate.fixed = true;
  ball_on_it.position_m = Vector3d(0.1, 0.05, 0.03005);
  ball_on_it.velocity_m_s = Vector3d(0, 0, -1);
  world.add(plate);
  world.add(ball_on_it);
  const StepRecord step = world.step();
  ASSERT_EQ(step.contacts.size(), 1U);
  const double modulus = contact_modulus_pa(plate.skin, ball_on_it.skin);
  EXPECT_NEAR(step.contacts[0].duration_s, hertz_duration_s(0.1, 0.02, modulus, 1.0), 1e-12);
}

// tests/reference/contact.json, cradle_5: five balls in a row, the first at 1 m/s, e = 1.
TEST(Impact, ACradlePassesTheSpeedOnPairwiseAndSharesItSimultaneously) {
  for (const bool pairwise : {true, false}) {
    RigidWorldOptions options;
    options.gravity_m_s2.setZero();
    options.collisions = pairwise ? CollisionOrder::kPairwise : CollisionOrder::kSimultaneous;
    RigidWorld world(options);
    for (int i = 0; i < 5; ++i) {
      RigidBodySpec b = ball("ball " + std::to_string(i), 0.01, 0.03);
      b.skin = skin(1.0, 0.0);
      b.position_m = Vector3d(0.02 * i - (i == 0 ? 5e-5 : 0.0), 0, 0);
      if (i == 0) b.velocity_m_s = Vector3d(1, 0, 0);
      world.add(b);
    }
    for (int i = 0; i < 3; ++i) world.step();
    const double expected[2][5] = {{-0.6, 0.4, 0.4, 0.4, 0.4}, {0, 0, 0, 0, 1}};
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(world.velocity_m_s(i).x(), expected[pairwise][i], 1e-9) << i;
  }
}
