// Round bodies touch the floor as round ones: they roll on without a blow, land where a circle is lowest, and stand on their faces.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/round_surfaces.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

using namespace klang::rigid;
using Eigen::Vector3d;

namespace {

RigidBodySpec body_of(const klang::mesh::ShapeSpec& shape, double restitution, double friction) {
  RigidBodySpec body;
  body.name = shape.kind;
  for (const Eigen::Matrix3Xd& corners_m : klang::mesh::convex_parts(shape)) body.parts.push_back({corners_m});
  body.round = klang::mesh::round_surfaces(shape);
  set_mass_from_parts(body, 7800);
  body.skin = skin(restitution, friction);
  return body;
}

RigidWorld on_the_floor(double rate_hz, double restitution, double friction) {
  RigidWorldOptions options;
  options.rate_hz = rate_hz;
  options.floor = skin(restitution, friction);
  return RigidWorld(options);
}

const klang::mesh::ShapeSpec kRod{"rod", {{"length_m", 0.2}, {"radius_m", 0.02}}, {}};
const klang::mesh::ShapeSpec kTube{"tube", {{"length_m", 0.2}, {"outer_radius_m", 0.02}, {"wall_m", 0.003}}, {}};

}  // namespace

TEST(Rolling, CylindersKeepTheirSpeedAndAreSilent) {
  for (const auto& shape : {kRod, kTube}) {
    for (const double rate_hz : {1000.0, 5000.0, 20000.0}) {
      RigidWorld world = on_the_floor(rate_hz, 0.5, 0.3);
      RigidBodySpec rod = body_of(shape, 0.5, 0.3);
      rod.orientation = Eigen::AngleAxisd(klang::kPi / 2, Vector3d::UnitX());  // along y
      rod.position_m = Vector3d(0, 0, 0.02);
      rod.velocity_m_s = Vector3d(0.4, 0, 0);
      rod.angular_velocity_rad_s = Vector3d(0, 0.4 / 0.02, 0);
      world.add(rod);
      double least = HUGE_VAL, most = 0.0;
      for (int i = 0; i < rate_hz; ++i) {
        double impulse = 0.0;
        for (const ContactImpulse& c : world.step().contacts) {
          ASSERT_EQ(c.kind, klang::events::ImpulseKind::kLasting) << i;
          impulse += c.impulse_n_s.z();
        }
        least = std::min(least, impulse);
        most = std::max(most, impulse);
      }
      EXPECT_NEAR(world.velocity_m_s(0).x(), 0.4, 1e-9) << rate_hz;
      EXPECT_NEAR(world.centre_m(0).x(), 0.4, 1e-9);
      EXPECT_NEAR(world.centre_m(0).y(), 0.0, 1e-9);
      const double weight = rod.mass_kg * 9.81 / rate_hz;
      EXPECT_GE(least, (1 - 1e-6) * weight);
      EXPECT_LE(most, (1 + 1e-6) * weight);
    }
  }
}

// J = (1 + e) m v / (1 + m x^2 / I) with the lowest place of the lower rim x aside of the centre.
TEST(Rolling, ATiltedCylinderLandsOnItsRim) {
  for (const double tilt : {0.1, 0.6, 1.2, 1.5}) {
    RigidWorld world = on_the_floor(5000, 0.5, 0.0);
    RigidBodySpec rod = body_of(kRod, 0.5, 0.0);
    rod.orientation = Eigen::AngleAxisd(0.7, Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt, Vector3d::UnitY()) *
                      Eigen::AngleAxisd(0.123, Vector3d::UnitZ());  // about its own axis: no matter
    const double x = 0.1 * std::sin(tilt) - 0.02 * std::cos(tilt), low = 0.1 * std::cos(tilt) + 0.02 * std::sin(tilt);
    rod.position_m = Vector3d(0, 0, low + 0.01);
    world.add(rod);
    double impulse = 0.0, time_s = 0.0;
    for (int i = 0; i < 1000 && impulse == 0; ++i)
      for (const ContactImpulse& c : world.step().contacts) impulse += c.impulse_n_s.z(), time_s = c.time_s;
    const double speed = std::sqrt(2 * 9.81 * 0.01);
    EXPECT_NEAR(time_s, speed / 9.81, 1e-9);
    EXPECT_NEAR(impulse, 1.5 * rod.mass_kg * speed / (1 + rod.mass_kg * x * x / rod.inertia_kg_m2(0, 0)),
                1e-6 * impulse)
        << tilt;
  }
}

TEST(Rolling, ACylinderLandsFlatOnItsEndAndStandsOnIt) {
  RigidWorld world = on_the_floor(5000, 0.5, 0.4);
  RigidBodySpec rod = body_of(kRod, 0.5, 0.4);
  rod.position_m = Vector3d(0, 0, 0.103);
  world.add(rod);
  const double speed = std::sqrt(2 * 9.81 * 0.003);
  double impulse = 0.0;
  for (int i = 0; i < 400 && impulse == 0; ++i)
    for (const ContactImpulse& c : world.step().contacts) impulse += c.impulse_n_s.z();
  EXPECT_NEAR(impulse, 1.5 * rod.mass_kg * speed, 1e-9 * impulse);
  for (int i = 0; i < 5000; ++i) world.step();
  EXPECT_NEAR(world.centre_m(0).z(), 0.1, 1e-5);
  EXPECT_LE(world.velocity_m_s(0).norm() + world.angular_velocity_rad_s(0).norm(), 1e-6);
}

// A bowl rocks on its sphere: with m, I about its centre of mass and d from that to the sphere's, small swings without sliding have
// the frequency sqrt(m g d / (I + m (R - d)^2)).
TEST(Rolling, ABowlRocksOnItsSphereAsTheClosedFormSays) {
  const klang::mesh::ShapeSpec shape{"bowl", {{"outer_radius_m", 0.06}, {"wall_m", 0.004}, {"depth_m", 0.05}}, {}};
  RigidWorld world = on_the_floor(5000, 0.0, 1.0);
  RigidBodySpec bowl = body_of(shape, 0.0, 1.0);
  const double angle = 0.05, off = 0.06 - bowl.centre_m.z();
  bowl.orientation = Eigen::AngleAxisd(angle, Vector3d::UnitY());
  bowl.position_m = Vector3d(0, 0, 0.06) + bowl.orientation * Vector3d(0, 0, -0.06);
  world.add(bowl);
  const double inertia = bowl.inertia_kg_m2(1, 1) + bowl.mass_kg * std::pow(0.06 - off, 2);
  const double omega = std::sqrt(bowl.mass_kg * 9.81 * off / inertia);
  double crossed = 0.0, before = 1.0;
  int n = 0;
  while (n < 5) {
    for (const ContactImpulse& c : world.step().contacts) ASSERT_EQ(c.kind, klang::events::ImpulseKind::kLasting);
    const double tilt = (world.pose(0).orientation() * Vector3d::UnitZ()).x();
    if ((before > 0) != (tilt > 0)) {
      ++n;
      crossed = world.time_s();
    }
    before = tilt;
  }
  EXPECT_NEAR(crossed, (n - 0.5) * klang::kPi / omega, 0.01 * crossed);
}
