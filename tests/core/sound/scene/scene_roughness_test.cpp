#include "core/sound/scene/scene_roughness.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/sound/scene/scene_motion.hpp"

namespace klang::scene {
namespace {

constexpr double kLengthM = 1e-3;

TEST(RoughField, HasVarianceOneAndAGaussianCorrelation) {
  constexpr int kFields = 4000;
  for (const double distance_m : {0.0, 0.5 * kLengthM, kLengthM, 2.0 * kLengthM}) {
    double product = 0.0, sum = 0.0;
    for (int seed = 0; seed < kFields; ++seed) {
      const RoughField field(kLengthM, static_cast<std::uint64_t>(seed));
      const double here = field.at({0.01, 0.02, -0.01});
      sum += here;
      product += here * field.at({0.01, 0.02 + distance_m, -0.01});
    }
    const double expected = std::exp(-0.5 * std::pow(distance_m / kLengthM, 2));
    EXPECT_LE(std::abs(product / kFields - expected), 5.0 * std::sqrt(2.0 / kFields)) << distance_m;
    EXPECT_LE(std::abs(sum / kFields), 5.0 / std::sqrt(kFields));
  }
}

TEST(RoughField, ItsMeanOverAWayIsTheIntegral) {
  const RoughField field(kLengthM, 5);
  const Eigen::Vector3d from(0.0, 0.0, 0.0), to(0.002, -0.001, 0.0005);
  double sum = 0.0;
  constexpr int kParts = 20000;
  for (int i = 0; i < kParts; ++i) sum += field.at(from + (i + 0.5) / kParts * (to - from)) / kParts;
  EXPECT_LE(std::abs(field.mean(from, to) - sum), 1e-6);
}

/// A cube that slides over a floor (or stands on it), for a second.
Scene sliding_cube(double speed_m_s, double roughness_of_floor) {
  return parse_scene(R"(duration_s = 1
[solver]
rate_hz = 2000
[world.floor]
material = "floor"
[[material]]
name = "cube"
preset = "steel"
restitution = 0
friction = 0
damping = { model = "loss_factor", loss_factor = 1e-3 }
[[material]]
name = "floor"
preset = "steel"
restitution = 0
friction = 0
roughness_length_m = 1e-2
roughness = )" + std::to_string(roughness_of_floor) +
                         R"(
[[body]]
name = "cube"
shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.1 }
material = "cube"
position_m = [0, 0, 0.05]
velocity_m_s = [)" + std::to_string(speed_m_s) +
                         ", 0, 0]\n",
                     "cube.toml");
}

TEST(SceneRoughness, ForcesOfASlidingCubeVaryByTheRoughnessAndStandStillWithIt) {
  constexpr double kRoughness = 0.2;
  for (const double speed_m_s : {0.0, 4.0}) {
    const Scene scene = sliding_cube(speed_m_s, kRoughness);
    const events::EventLog log = move(scene).log;
    const events::EventLog rough = with_roughness(scene, log);
    ASSERT_EQ(rough.impulses.size(), log.impulses.size());
    double square = 0.0, first = 0.0, largest_change = 0.0;
    int n = 0;
    for (std::size_t i = 0; i < log.impulses.size(); ++i) {
      const events::Impulse& row = log.impulses[i];
      if (row.kind != events::ImpulseKind::kLasting || !(row.point_m.x() > 0.0) || !(row.point_m.y() > 0.0)) continue;
      if (!(row.impulse_n_s.norm() > 0.0)) continue;
      const double change = rough.impulses[i].impulse_n_s.norm() / row.impulse_n_s.norm() - 1.0;
      if (n == 0) first = change;
      largest_change = std::max(largest_change, std::abs(change - first));
      square += change * change;
      ++n;
    }
    ASSERT_GT(n, 1000);
    if (speed_m_s == 0.0)
      EXPECT_LE(largest_change, 1e-9);
    else  // 4 m of a field that is alike over 1 cm: some 200 independent places
      EXPECT_LE(std::abs(std::sqrt(square / n) / kRoughness - 1.0), 0.2);
  }
}

TEST(SceneRoughness, ASmoothSceneIsLeftToTheLastBit) {
  const Scene scene = sliding_cube(4.0, 0.0);
  const events::EventLog log = move(scene, 0.1).log, same = with_roughness(scene, log);
  for (std::size_t i = 0; i < log.impulses.size(); ++i)
    ASSERT_EQ(log.impulses[i].impulse_n_s, same.impulses[i].impulse_n_s);
}

TEST(SceneRoughness, BothBodiesOfAContactFeelTheSameForce) {
  Scene scene = sliding_cube(4.0, 0.3);
  scene.materials[0].roughness = 0.3;
  SceneBody slab = scene.bodies[0];
  slab.name = "slab";
  slab.shape->dims = {{"length_m", 2.0}, {"width_m", 1.0}, {"height_m", 0.2}};
  slab.position_m = {0.5, 0, 0.1};
  slab.velocity_m_s.setZero();
  scene.bodies[0].position_m.z() = 0.25;
  scene.bodies.push_back(slab);
  const events::EventLog log = move(scene, 0.1).log, rough = with_roughness(scene, log);
  int n = 0, changed = 0;
  for (std::size_t i = 0; i + 1 < log.impulses.size(); ++i) {
    const events::Impulse &a = rough.impulses[i], &b = rough.impulses[i + 1];
    if (a.kind != events::ImpulseKind::kLasting || a.other < 0 || b.body != a.other || b.time_s != a.time_s) continue;
    ASSERT_LE(std::abs(a.impulse_n_s.norm() - b.impulse_n_s.norm()), 1e-12 * a.impulse_n_s.norm());
    changed += a.impulse_n_s != log.impulses[i].impulse_n_s;
    ++n;
    ++i;
  }
  EXPECT_GT(n, 100);
  EXPECT_GT(changed, n / 2);
}

}  // namespace
}  // namespace klang::scene
