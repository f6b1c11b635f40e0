#include "core/sound/scene/scene_motion.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/physics/events/world_impulses.hpp"
#include "tests/places.hpp"

namespace klang::scene {
namespace {

const std::filesystem::path kScenes =
    std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes/s02";

/// The scene with every length times 4, every time times 2: gravity stays.
Scene scaled_by_four(Scene scene) {
  scene.solver.rate_hz /= 2.0;
  scene.pose_rate_hz /= 2.0;
  if (scene.duration_s) *scene.duration_s *= 2.0;
  for (SceneBody& body : scene.bodies) {
    for (auto& [name, value] : body.shape->dims) value *= 4.0;
    body.position_m *= 4.0;
    body.velocity_m_s *= 2.0;
    body.angular_velocity_rad_s /= 2.0;
  }
  return scene;
}

TEST(SceneMotion, BlocksFourTimesAsLargeMoveInTheSameBits) {
  const Scene scene = read_scene(kScenes / "blocks.toml");
  const SceneMotion small = move(scene, 0.5), large = move(scaled_by_four(scene), 1.0);
  ASSERT_EQ(small.n_steps, large.n_steps);
  for (std::size_t i = 0; i < small.final.size(); ++i) {
    EXPECT_EQ(4.0 * small.final[i].position_m, large.final[i].position_m) << i;
    EXPECT_EQ(small.final[i].orientation_wxyz, large.final[i].orientation_wxyz) << i;
    EXPECT_EQ(2.0 * small.final[i].velocity_m_s, large.final[i].velocity_m_s) << i;
  }
  ASSERT_GT(small.log.impulses.size(), 100u);
  ASSERT_EQ(small.log.impulses.size(), large.log.impulses.size());
}

TEST(SceneMotion, EnergyIsAccountedForAndLossesNeverFall) {
  const SceneMotion motion = move(read_scene(kScenes / "chimes.toml"), 0.6);
  EXPECT_LE(motion.residual_relative, 1e-9);
  for (std::size_t i = 1; i < motion.ledger.size(); ++i) {
    ASSERT_GE(motion.ledger[i].contact_j, motion.ledger[i - 1].contact_j) << i;
    ASSERT_GE(motion.ledger[i].friction_j, motion.ledger[i - 1].friction_j) << i;
  }
  EXPECT_GT(motion.ledger.back().contact_j, 0.1 * motion.energy_scale_j);
}

TEST(SceneMotion, ChimesHangOnTheirCordsUntilTheClapperStrikesThem) {
  const Scene scene = read_scene(kScenes / "chimes_hung.toml");
  const SceneMotion motion = move(scene, 1.2);
  EXPECT_LE(motion.residual_relative, 1e-9);
  std::vector<int> struck(scene.bodies.size(), 0);
  for (const events::Impulse& row : motion.log.impulses) ++struck[static_cast<std::size_t>(row.body)];
  EXPECT_GT(struck[0], 2);
  int n_struck = 0;
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    const Eigen::Vector3d rest_m = scene.bodies[i].position_m;
    n_struck += struck[i] > 0 ? 1 : 0;
    if (struck[i] == 0)
      EXPECT_LE((motion.final[i].position_m - rest_m).norm(), 2e-4) << i;  // cords lean by the digits of the file
    else
      EXPECT_LE(motion.final[i].position_m.z() - rest_m.z(), 0.05) << i;
  }
  EXPECT_GE(n_struck, 2);
  EXPECT_LT(n_struck, 6);
}

TEST(SceneMotion, ImpulsesInTheWorldSumToTheMomentum) {
  const Scene scene = read_scene(kScenes / "bowl_1.toml");
  const SceneMotion motion = move(scene, 0.8);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double taken = 0.0;
  for (const events::WorldImpulse& row : events::world_impulses(motion.log)) {
    sum += Eigen::Vector3d(row.jx_n_s, row.jy_n_s, row.jz_n_s);
    taken += Eigen::Vector3d(row.jx_n_s, row.jy_n_s, row.jz_n_s).norm();
  }
  const double mass = motion.mass_kg[0];
  const Eigen::Vector3d expected =
      mass * (motion.final[0].velocity_m_s - scene.bodies[0].velocity_m_s - scene.solver.gravity_m_s2 * motion.end_s);
  EXPECT_LE((sum - expected).norm(), 1e-12 * taken);
  EXPECT_GT(expected.norm(), 0.1 * mass);
}

TEST(SceneMotion, TwoMaterialsOfABowlMoveAlike) {
  const SceneMotion metal = move(read_scene(kScenes / "bowl_1.toml"), 0.5);
  const SceneMotion oak = move(read_scene(kScenes / "bowl_2.toml"), 0.5);
  EXPECT_LE((metal.final[0].position_m - oak.final[0].position_m).norm(), 1e-9);
  EXPECT_GT(metal.mass_kg[0], 3.0 * oak.mass_kg[0]);
}

TEST(SceneMotion, ASceneThatNeverRestsIsRefused) {
  Scene scene = read_scene(kScenes / "bowl_1.toml");
  scene.duration_s.reset();
  scene.longest_s = 0.3;
  EXPECT_THROW(move(scene), InputError);
}

}  // namespace
}  // namespace klang::scene
