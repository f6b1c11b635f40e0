// Bodies that turn while they land: place, normal and inertia of an impact are those of its touch, whatever the step.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

using namespace klang::rigid;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kG = 9.81;

RigidWorld on_a_floor(double rate_hz, double restitution, double friction) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.floor = skin(restitution, friction);
  return RigidWorld(options);
}

std::vector<ContactImpulse> impacts_of(const StepRecord& step) {
  std::vector<ContactImpulse> found;
  for (const ContactImpulse& c : step.contacts)
    if (c.kind == klang::events::ImpulseKind::kImpact) found.push_back(c);
  return found;
}

/// Steps until one has an impact.
std::vector<ContactImpulse> first_impacts(RigidWorld& world) {
  for (int i = 0; i < 20000; ++i)
    if (auto found = impacts_of(world.step()); !found.empty()) return found;
  return {};
}

Vector3d momentum_of_spin(const RigidWorld& world, int body) {
  const Matrix3d turn = world.pose(body).orientation().toRotationMatrix();
  return turn * world.spec(body).inertia_kg_m2 * turn.transpose() * world.angular_velocity_rad_s(body);
}

}  // namespace

// A box that turns about a level axis and comes down on an edge: a plane problem. With x ahead and the edge at (x, z) = r from the centre,
// an impulse J upward and mu s J along the floor, against the sliding, changes u by J (1/m + x^2/I - mu s x z / I).
TEST(TurningImpact, ABoxThatLandsOnItsEdgeRebounsAsTheClosedFormSays) {
  const double length = 0.12, height = 0.02, mass = 0.2, spin = 7.0, tilt = 0.3, drop = 0.15, e = 0.5;
  for (const double mu : {0.0, 0.3}) {
    for (const double rate_hz : {1000.0, 5000.0, 10000.0, 20000.0}) {
      RigidWorld world = on_a_floor(rate_hz, e, mu);
      RigidBodySpec box = cuboid("box", {length, 0.05, height}, mass);
      box.skin = skin(e, mu);
      box.position_m = Vector3d(0, 0, drop);
      box.orientation = Eigen::AngleAxisd(tilt, Vector3d::UnitY());
      box.angular_velocity_rad_s = Vector3d(0, spin, 0);
      box.velocity_m_s = Vector3d(3, 0, 0);  // slides through the whole impact
      world.add(box);
      const auto impacts = first_impacts(world);
      ASSERT_EQ(impacts.size(), 2U);
      // Turned by a about y the corner (L/2, -H/2) is at (L/2 cos a - H/2 sin a, -L/2 sin a - H/2 cos a).
      const auto arm = [&](double t) {
        const double a = tilt + spin * t;
        return Vector3d(0.5 * length * std::cos(a) - 0.5 * height * std::sin(a), 0,
                        -0.5 * length * std::sin(a) - 0.5 * height * std::cos(a));
      };
      double early = 0.0, late = 0.2;
      for (int i = 0; i < 200; ++i) {
        const double t = 0.5 * (early + late);
        (drop - 0.5 * kG * t * t + arm(t).z() > 0 ? early : late) = t;
      }
      const double touch_s = early, inertia = mass * (length * length + height * height) / 12;
      const Vector3d r = arm(touch_s), turning(0, spin, 0), before(3, 0, -kG * touch_s);
      const Vector3d u = before + turning.cross(r);
      const double s = u.x() > 0 ? -1.0 : 1.0;  // friction's side
      const Vector3d along(mu * s, 0, 1);
      const double give = 1 / mass + Vector3d((r.cross(along) / inertia).cross(r)).z();
      const double impulse = -(1 + e) * u.z() / give;
      Vector3d sum = Vector3d::Zero();
      for (const ContactImpulse& c : impacts) {
        sum += c.impulse_n_s;
        EXPECT_NEAR(c.time_s, touch_s, 1e-12);
        EXPECT_NEAR(c.approach_m_s, -u.z(), 1e-10);
      }
      EXPECT_LE((sum - impulse * along).norm(), 1e-9 * impulse) << rate_hz << " Hz, friction " << mu;
      const double after_s = world.time_s() - touch_s;
      EXPECT_NEAR(world.angular_velocity_rad_s(0).y(), spin + (r.cross(impulse * along) / inertia).y(), 1e-8);
      EXPECT_NEAR(world.velocity_m_s(0).z(), before.z() + impulse / mass - kG * after_s, 1e-9);
      EXPECT_LE(std::abs(world.ledger().residual_j), 1e-13);
    }
  }
}

// A box that tumbles: the speed of the corner after over before, by momentum and angular momentum at the touch.
TEST(TurningImpact, ATumblingBoxReboundsAtItsRestitutionAndRubsAtItsFriction) {
  const double e = 0.5, mu = 0.3;
  std::vector<double> times;
  for (const double rate_hz : {1000.0, 5000.0, 10000.0}) {
    RigidWorld world = on_a_floor(rate_hz, e, mu);
    RigidBodySpec box = cuboid("box", {0.12, 0.05, 0.02}, 0.3);
    box.skin = skin(e, mu);
    box.position_m = Vector3d(0.3, -0.2, 0.2);
    box.orientation = Eigen::AngleAxisd(1.1, Vector3d(0.4, 0.7, -0.3).normalized());
    box.angular_velocity_rad_s = Vector3d(3, -4, 5);
    world.add(box);
    const Vector3d spin_before = momentum_of_spin(world, 0);
    const auto impacts = first_impacts(world);
    ASSERT_EQ(impacts.size(), 1U);
    const ContactImpulse& c = impacts[0];
    times.push_back(c.time_s);
    const Matrix3d turn = c.turn_a.toRotationMatrix(), inverse = turn * box.inertia_kg_m2.inverse() * turn.transpose();
    const Vector3d arm = turn * c.place_a_m, before(0, 0, -kG * c.time_s);
    EXPECT_NEAR(0.2 - 0.5 * kG * c.time_s * c.time_s + arm.z(), 0, 1e-12);  // on the floor
    const Vector3d after = world.velocity_m_s(0) + Vector3d(0, 0, kG * (world.time_s() - c.time_s));
    const Vector3d u = before + (inverse * spin_before).cross(arm);
    const Vector3d v = after + (inverse * momentum_of_spin(world, 0)).cross(arm);
    EXPECT_NEAR(-v.z() / u.z(), e, 1e-10) << rate_hz;
    EXPECT_NEAR(c.impulse_n_s.head<2>().norm(), mu * c.impulse_n_s.z(), 1e-10 * c.impulse_n_s.z());
    EXPECT_LE((momentum_of_spin(world, 0) - spin_before - arm.cross(c.impulse_n_s)).norm(), 1e-14);
  }
  for (const double t : times) EXPECT_NEAR(t, times.back(), 1e-9);
}

// A brick on a bar that turns at 50 rad/s, in free space: the same whatever the step and its phase, and nothing of momentum is lost.
TEST(TurningImpact, ABrickOnATurningBarIsPushedTheSameWhateverTheStep) {
  std::vector<Vector3d> brick_after;
  for (const double rate_hz : {5000.0, 10000.0, 13000.0, 20000.0}) {
    RigidWorldOptions options;
    options.rate_hz = rate_hz;
    options.gravity_m_s2.setZero();
    RigidWorld world(options);
    RigidBodySpec bar = cuboid("bar", {0.3, 0.02, 0.03}, 0.5), brick = cuboid("brick", {0.02, 0.03, 0.015}, 0.02);
    bar.skin = brick.skin = skin(0.6, 0.2);
    bar.angular_velocity_rad_s = Vector3d(0, 0, 50);
    brick.position_m = Vector3d(0.12, 0.06, 0.002);
    brick.orientation = Eigen::AngleAxisd(0.5, Vector3d(1, 0.4, 0.7).normalized());
    brick.angular_velocity_rad_s = Vector3d(20, -30, 10);
    brick.velocity_m_s = Vector3d(0, -1, 0);
    const int a = world.add(bar), b = world.add(brick);
    const auto turning = [&] {
      Vector3d sum = Vector3d::Zero();
      for (const int i : {a, b})
        sum += momentum_of_spin(world, i) + world.spec(i).mass_kg * world.centre_m(i).cross(world.velocity_m_s(i));
      return sum;
    };
    const Vector3d at_start = turning();
    const auto impacts = first_impacts(world);
    ASSERT_EQ(impacts.size(), 1U);
    EXPECT_LE((turning() - at_start).norm(), 1e-13);
    brick_after.push_back(world.velocity_m_s(b));
  }
  for (const Vector3d& v : brick_after) EXPECT_LE((v - brick_after.back()).norm(), 1e-8) << v.transpose();
}

// Bounce after bounce.
TEST(TurningImpact, BouncesOfATumblingBoxComeAtTheSameTimesWhateverTheStep) {
  std::vector<std::vector<double>> times;
  for (const double rate_hz : {5000.0, 10000.0, 20000.0}) {
    RigidWorld world = on_a_floor(rate_hz, 0.6, 0.3);
    RigidBodySpec box = cuboid("box", {0.1, 0.07, 0.05}, 0.3);
    box.skin = skin(0.6, 0.3);
    box.position_m = Vector3d(0, 0, 0.3);
    box.orientation = Eigen::AngleAxisd(1.1, Vector3d(0.4, 0.7, -0.3).normalized());
    box.angular_velocity_rad_s = Vector3d(3, -4, 5);
    world.add(box);
    std::vector<double>& its = times.emplace_back();
    while (its.size() < 8)
      for (const ContactImpulse& c : first_impacts(world)) its.push_back(c.time_s);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_NEAR(times[0][i], times[2][i], 1e-10) << i;
    EXPECT_NEAR(times[1][i], times[2][i], 1e-10) << i;
  }
}
