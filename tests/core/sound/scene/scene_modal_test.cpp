// Modal bodies in scenes: touches, rest, holds, what is refused.
#include "core/sound/scene/scene_modal.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/foundation/base/errors.hpp"

namespace klang::scene {
namespace {

class SceneModal : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("modal-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "sway.csv") << "time_s,x,y,z\n0,0,0,0\n0.01,0.002,0,0.001\n0.03,0.002,0,0\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  Scene scene(const std::string& modal, const std::string& solver, const std::string& body,
              const std::string& more = {}) const {
    return parse_scene("duration_s = 0.02\n" + solver +
                           "[[material]]\nname = \"soft\"\nyoungs_modulus_pa = 1e7\npoissons_ratio = 0.3\n"
                           "density_kg_m3 = 1000\nrestitution = 0.6\nfriction = 0.4\n"
                           "[[body]]\nname = \"bar\"\nmaterial = \"soft\"\nmodel = \"modal\"\nsound = \"none\"\n"
                           "max_edge_m = 0.05\n"
                           "shape = { kind = \"box\", length_m = 0.02, width_m = 0.02, height_m = 0.2 }\n" +
                           body + "\n[modal]\n" + modal + "\n" + more,
                       folder_ / "scene.toml");
  }
  std::filesystem::path folder_;
};

const char* const kWeightless =
    "[solver]\nrate_hz = 20000\n[world]\ngravity_m_s2 = [0, 0, 0]\n[world.floor]\nmaterial = \"soft\"\n";
const char* const kFlying = "position_m = [0, 0, 0.11]\nvelocity_m_s = [0, 0, -1]";

TEST_F(SceneModal, WithoutModesItReboundsByTheMaterialsRestitution) {
  const SceneMotion motion = move(scene("n_modes = 0", kWeightless, kFlying));
  EXPECT_LE((motion.final[0].velocity_m_s - 0.6 * Eigen::Vector3d::UnitZ()).norm(), 1e-7);
  EXPECT_LE(std::abs(motion.ledger.back().contact_j / (0.5 * 0.08 * (1 - 0.36)) - 1.0), 1e-7);
  EXPECT_LE(motion.residual_relative, 1e-9);
  EXPECT_LE(*motion.contact_residual, 1e-6);
}

TEST_F(SceneModal, ItsImpulsesAreItsChangeOfMomentumAndEnergyNeverGrows) {
  const SceneMotion motion = move(scene("n_modes = 12", kWeightless, kFlying));
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const events::Impulse& impulse : motion.log.impulses) sum += impulse.impulse_n_s;  // it hardly turns
  const Eigen::Vector3d gained = 0.08 * (motion.final[0].velocity_m_s + Eigen::Vector3d::UnitZ());
  EXPECT_LE(std::abs(sum.z() - gained.z()), 1e-5 * gained.z());
  EXPECT_GT(motion.final[0].velocity_m_s.z(), 0.0);
  EXPECT_LE(*motion.contact_residual, 1e-6);
  EXPECT_LE(motion.residual_relative, 1e-9);
  double before = HUGE_VAL;
  for (const rigid::EnergyLedger& row : motion.ledger) {
    EXPECT_LE(row.kinetic_j + row.strain_j, before * (1 + 1e-12));
    before = row.kinetic_j + row.strain_j;
  }
  EXPECT_NO_THROW(motion.log.validate());
}

TEST_F(SceneModal, ResidualFlexibilityMakesATouchSofterAndEnergyStillNeverGrows) {
  const auto moved = [&](const std::string& modal) {
    Scene flying = scene(modal, kWeightless, kFlying);
    flying.materials[0].friction = 0.0;
    return move(flying);
  };
  const SceneMotion stiff = moved("n_modes = 3"), soft = moved("n_modes = 3\nresidual_flexibility = true");
  EXPECT_GT(soft.final[0].velocity_m_s.z(), stiff.final[0].velocity_m_s.z());
  EXPECT_LE(soft.final[0].velocity_m_s.z(), 1.0);
  EXPECT_LE(soft.residual_relative, 1e-9);
  EXPECT_LE(*soft.contact_residual, 1e-6);
  double before = HUGE_VAL;
  for (const rigid::EnergyLedger& row : soft.ledger) {
    EXPECT_LE(row.kinetic_j + row.strain_j, before * (1 + 1e-9));
    before = row.kinetic_j + row.strain_j;
  }
}

TEST_F(SceneModal, ATiltedBlockComesToRestOnTheFloor) {
  Scene falling = scene("n_modes = 0", "[solver]\nrate_hz = 5000\n[world.floor]\nmaterial = \"soft\"\n",
                        "position_m = [0, 0, 0.13]\nrotation_deg = [30, 20, 0]\nvelocity_m_s = [0.5, 0, 0]");
  falling.duration_s = 0.5;
  const SceneMotion motion = move(falling);
  EXPECT_LE(motion.final[0].velocity_m_s.norm(), 1e-6);
  EXPECT_LE(std::abs(motion.final[0].position_m.z() - 0.01), 1e-3);
  EXPECT_LE(motion.residual_relative, 1e-9);
}

TEST_F(SceneModal, AHeldPlaceFollowsItsPathAndTheWorkIsBooked) {
  const SceneMotion motion = move(scene("n_modes = 6", "[solver]\nrate_hz = 20000\n[world]\ngravity_m_s2 = [0, 0, 0]\n",
                                        "", "[[hold]]\nbody = \"bar\"\nat_m = [0, 0, 0.1]\ncsv = \"sway.csv\"\n"));
  EXPECT_GT(motion.ledger.back().work_j - motion.ledger.front().work_j, 0.0);
  EXPECT_LE(motion.residual_relative, 1e-9);
  EXPECT_GT(motion.final[0].velocity_m_s.norm() + motion.final[0].angular_velocity_rad_s.norm(), 0.0);
}

TEST_F(SceneModal, WhatItCannotDoIsRefused) {
  EXPECT_THROW(scene("n_modes = 2.5", kWeightless, kFlying), InputError);
  EXPECT_THROW(scene("contact = \"guess\"", kWeightless, kFlying), InputError);
  EXPECT_THROW(scene("n_modes = 2", kWeightless, std::string(kFlying) + "\nfixed = true"), InputError);
}

}  // namespace
}  // namespace klang::scene
