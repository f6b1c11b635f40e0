#include "core/physics/rigid/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"

using namespace klang::rigid;
using Eigen::Vector3d;

namespace {

RigidWorldOptions on_the_floor(double restitution) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  options.floor->restitution = restitution;
  return options;
}

RigidBodySpec bouncing_ball() {
  RigidBodySpec body = ball("ball", 0.01, 0.02);
  body.skin.restitution = 0.6;
  body.position_m = Vector3d(0, 0, 0.01);
  return body;
}

}  // namespace

// tests/reference/contact.json, bounce: e = 0.6, first impact at 2 m/s: at rest 0.6116207951070336 s later, all impulses 8 m.
TEST(Recording, ABouncingBallRestsWhenZenosSeriesEndsAndItsImpulsesSumToTheWeightAndTheMomentum) {
  RigidWorld world(on_the_floor(0.6));
  RigidBodySpec body = bouncing_ball();
  body.velocity_m_s.z() = -2.0;
  body.position_m.z() += 1e-9;
  world.add(body);
  Recording recording(world);
  run(world, recording, {});
  double impacts = 0, last_s = 0, all = 0, first_s = -1;
  for (const klang::events::Impulse& impulse : recording.log().impulses) {
    all += impulse.impulse_n_s.z();
    if (impulse.kind != klang::events::ImpulseKind::kImpact) continue;
    if (first_s < 0) first_s = impulse.time_s;
    impacts += impulse.impulse_n_s.z();
    last_s = impulse.time_s;
  }
  // Touches below 2 g dt are held: the rest of the series is less than 2 v / (g (1 - e)) long and (1 + e) v / (1 - e) strong.
  const double held_m_s = 2 * 9.81 / 5000;
  EXPECT_NEAR(last_s - first_s, 0.6116207951070336, 2 * held_m_s / 9.81 / 0.4);
  EXPECT_NEAR(impacts / 0.02, 8.0, 1.6 * held_m_s / 0.4);
  EXPECT_NEAR(all, 0.02 * (2.0 + 9.81 * world.time_s()), 1e-12);
}

TEST(Recording, AMovingPairGivesTwoOppositeRowsInTheBodiesOwnFrames) {
  RigidWorldOptions options;
  options.gravity_m_s2.setZero();
  RigidWorld world(options);
  RigidBodySpec a = ball("a", 0.01, 0.02), b = cuboid("b", Vector3d::Constant(0.02), 0.05);
  a.position_m = Vector3d(-0.02 - 1e-5, 0, 0);
  a.velocity_m_s = Vector3d(1, 0, 0);
  b.orientation = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ());
  world.add(a);
  world.add(b);
  Recording recording(world);
  run(world, recording, {1e-3});
  ASSERT_EQ(recording.log().impulses.size(), 2u);
  const auto &on_a = recording.log().impulses[0], &on_b = recording.log().impulses[1];
  EXPECT_EQ(on_a.other, on_b.body);
  EXPECT_LE((on_a.impulse_n_s + Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ()) * on_b.impulse_n_s).norm(), 1e-15);
  EXPECT_LE((on_a.point_m - Vector3d(0.01, 0, 0)).norm(), 2e-6);
  EXPECT_LE((on_b.point_m - Vector3d(0, 0.01, 0)).norm(), 2e-6);
  recording.log().validate();
}

TEST(Recording, ASceneThatNeverRestsIsRefusedUnlessItsDurationIsGiven) {
  RigidWorldOptions options;
  options.rate_hz = 1000;
  RigidWorld world(options);
  world.add(ball("ball", 0.01, 0.02));
  Recording recording(world);
  EXPECT_THROW(run(world, recording, {std::nullopt, 0.5}), klang::InputError);
}
