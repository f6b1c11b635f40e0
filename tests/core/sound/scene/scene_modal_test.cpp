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
  // Touches that last are held over each small step: what that costs, either way, is of the second order in it.
  double least = HUGE_VAL;
  for (const rigid::EnergyLedger& row : motion.ledger) {
    EXPECT_LE(row.kinetic_j + row.strain_j, least + 1e-4 * motion.ledger.front().kinetic_j);
    least = std::min(least, row.kinetic_j + row.strain_j);
  }
  EXPECT_NO_THROW(motion.log.validate());
}

TEST_F(SceneModal, ShocksAreHeardAsPulsesNotAsForcesThatLast) {
  // A force that is held leaves its own shape in whatever sample a small step falls into: a click.
  const SceneMotion motion = move(scene("n_modes = 12", kWeightless, kFlying));
  int n_shocks = 0;
  for (const events::Impulse& impulse : motion.log.impulses) {
    if (impulse.kind != events::ImpulseKind::kImpact) continue;
    ++n_shocks;
    EXPECT_EQ(impulse.shape, events::PulseShape::kGaussian) << impulse.time_s;
    EXPECT_GT(impulse.duration_s, 0.0);
  }
  EXPECT_GE(n_shocks, 1);
}

TEST_F(SceneModal, ResidualFlexibilityMakesATouchSofterThatTakesNoEnergy) {
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
  // Springs give back what they took: what the steps' size costs or gives meanwhile is of their second order.
  for (const rigid::EnergyLedger& row : soft.ledger)
    EXPECT_LE(row.kinetic_j + row.strain_j, soft.ledger.front().kinetic_j * (1 + 1e-3));
  EXPECT_LE(std::abs(soft.ledger.back().contact_j), 1e-4 * soft.ledger.front().kinetic_j);
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

/// A bar without Poisson's ratio, so that its end stays plane, without friction and restitution.
const char* const kBar =
    "duration_s = 0.003\n[[material]]\nname = \"m\"\nyoungs_modulus_pa = 1e9\npoissons_ratio = 0\ndensity_kg_m3 = "
    "1000\n"
    "restitution = 0\nfriction = 0\ndamping = { model = \"loss_factor\", loss_factor = 0 }\n[[body]]\nname = \"bar\"\n"
    "material = \"m\"\nmodel = \"modal\"\nsound = \"none\"\nmodal = { n_modes = 6 }\n";

TEST_F(SceneModal,
       ABarOnAWallReboundsWithTwoThirdsWhateverTheStep) {  // one longitudinal mode: a third is lost at the touch
  double last = HUGE_VAL;
  for (const int rate : {20000, 80000}) {
    const std::string text = kBar +
                             std::string(
                                 "max_edge_m = 0.05\nposition_m = [0, 0, 0.1005]\nrotation_deg = [0, 90, 0]\n"
                                 "velocity_m_s = [0, 0, -1]\n"
                                 "shape = { kind = \"box\", length_m = 0.2, width_m = 0.05, height_m = 0.05 }\n"
                                 "[world]\ngravity_m_s2 = [0, 0, 0]\n[world.floor]\nmaterial = \"m\"\n") +
                             "[solver]\nrate_hz = " + std::to_string(rate) + "\n";
    const SceneMotion motion = move(parse_scene(text, folder_ / "scene.toml"));
    const double error = std::abs(motion.final[0].velocity_m_s.z() - 2.0 / 3.0);
    EXPECT_LE(error, 1e-4);
    EXPECT_LE(error, last);
    EXPECT_LE(std::abs(motion.ledger.back().contact_j / motion.ledger.front().kinetic_j - 1.0 / 3.0), 1e-3);
    EXPECT_LE(motion.residual_relative, 1e-9);
    last = error;
  }
}

TEST_F(SceneModal, ABarThatIsHeldStillInDependentPlacesSwaysUnderItsWeight) {
  std::string text = kBar + std::string(
                                "max_edge_m = 0.02\nshape = { kind = \"box\", length_m = 0.2, width_m = 0.02, "
                                "height_m = 0.02 }\n[solver]\nrate_hz = 10000\n[world]\ngravity_m_s2 = [0, 0, -10]\n");
  text.replace(text.find("0.003"), 5, "0.02");
  const auto hold = [](const char* at, const char* csv) {
    return std::string("[[hold]]\nbody = \"bar\"\nat_m = ") + at + "\ncsv = \"" + csv + "\"\n";
  };
  std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n";
  std::ofstream(folder_ / "apart.csv") << "time_s,x,y,z\n0,0,0,0\n0.01,2,0,0\n";
  const SceneMotion motion =
      move(parse_scene(text + hold("[-0.1, -0.01, -0.01]", "still.csv") + hold("[-0.1, 0.01, -0.01]", "still.csv") +
                           hold("[-0.1, -0.01, 0.01]", "still.csv"),
                       folder_ / "scene.toml"));
  // A clamped bar swings up to twice its sag w L^4/(8 E I), with 4 times the strain energy w^2 L^5/(40 E I) of it.
  const double weight_n_m = 0.4 * 10.0, stiffness = 1e9 * std::pow(0.02, 4) / 12.0,
               most_j = 4.0 * weight_n_m * weight_n_m * std::pow(0.2, 5) / (40.0 * stiffness);
  double strain_j = 0.0;
  for (const rigid::EnergyLedger& row : motion.ledger) {
    strain_j = std::max(strain_j, row.strain_j);
    EXPECT_LE(row.kinetic_j, most_j);
  }
  EXPECT_LE(strain_j, most_j);
  EXPECT_GT(strain_j, 0.02 * most_j);  // few modes: a stiffer bar
  EXPECT_LE(motion.residual_relative, 1e-9);
  // Ends that are drawn apart by ten times its length are no linear modes' affair.
  EXPECT_THROW(
      move(parse_scene(text + hold("[-0.1, -0.01, -0.01]", "still.csv") + hold("[0.1, 0.01, 0.01]", "apart.csv"),
                       folder_ / "scene.toml")),
      NumericalError);
}

TEST_F(SceneModal, AWholeEndThatIsHeldClampsABarWhateverTheNumberOfModes) {
  std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n";
  std::ofstream(folder_ / "out.csv") << "time_s,x,y,z\n0,0,0,0\n0.02,0.0002,0,0\n1,0.0002,0,0\n";
  std::string text = kBar + std::string(
                                "max_edge_m = 0.02\nshape = { kind = \"box\", length_m = 0.2, width_m = 0.02, "
                                "height_m = 0.02 }\n[solver]\nrate_hz = 10000\n[world]\ngravity_m_s2 = [0, 0, -10]\n"
                                "[[hold]]\nbody = \"bar\"\nwhere = \"x=min\"\ncsv = \"still.csv\"\n");
  const auto with = [&](int n_modes, double duration_s, const std::string& more) {
    std::string made = text + more;
    made.replace(made.find("n_modes = 6"), 11, "n_modes = " + std::to_string(n_modes));
    made.replace(made.find("0.003"), 5, std::to_string(duration_s));
    std::vector<std::string> warnings;
    SceneNotes notes;
    notes.warning = [&](const std::string& warning) { warnings.push_back(warning); };
    SceneMotion motion = move(parse_scene(made, folder_ / "scene.toml"), duration_s, 1, notes);
    for (const std::string& warning : warnings) EXPECT_EQ(warning.find("stiffer"), std::string::npos) << warning;
    EXPECT_LE(motion.residual_relative, 1e-9);
    return motion;
  };
  // Bernoulli's bar: omega = 3.5160 sqrt(EI/(rho A L^4)); its shear lengthens the period by less than a percent at L/h = 10.
  const double period_s = 2.0 * M_PI / (3.5160 * std::sqrt(1e9 * 0.02 * 0.02 / 12.0 / 1000.0) / 0.04);
  for (const int n_modes : {2, 8, 20}) {
    const SceneMotion motion = with(n_modes, 0.016, "");
    // The first time that it has come back: where its kinetic energy is least after half a period.
    const auto from = static_cast<std::ptrdiff_t>(0.8 * period_s * 1e4);
    const auto least = std::min_element(motion.ledger.begin() + from, motion.ledger.end(),
                                        [](const auto& a, const auto& b) { return a.kinetic_j < b.kinetic_j; });
    EXPECT_NEAR(least->time_s / period_s, 1.0, 0.013) << n_modes;  // rows stand 0.8 % apart
  }
  // Drawn by its other end slowly: E A d^2/(2 L).
  const SceneMotion drawn = with(4, 0.04, "[[hold]]\nbody = \"bar\"\nwhere = \"x=max\"\ncsv = \"out.csv\"\n");
  const double weight_j = drawn.ledger.back().strain_j - 1e9 * 4e-4 * 4e-8 / (2.0 * 0.2);
  EXPECT_GE(weight_j, -1e-3 * drawn.ledger.back().strain_j);
  EXPECT_LE(weight_j, 0.05 * drawn.ledger.back().strain_j);
}

TEST_F(SceneModal, ABarThatIsClampedDecaysAtTheFrequencyThatItHasAsHeldAndStillHoldsDoNoWork) {
  std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n";
  std::string text = kBar + std::string(
                                "max_edge_m = 0.02\nshape = { kind = \"box\", length_m = 0.2, width_m = 0.02, "
                                "height_m = 0.02 }\n[solver]\nrate_hz = 10000\n[world]\ngravity_m_s2 = [0, 0, -10]\n"
                                "[[hold]]\nbody = \"bar\"\nwhere = \"x=min\"\ncsv = \"still.csv\"\n");
  text.replace(text.find("0.003"), 5, "0.035");
  text.replace(text.find("loss_factor = 0 }"), 17, "loss_factor = 0.2 }");
  std::vector<double> peaks;
  const SceneMotion motion = move(parse_scene(text, folder_ / "scene.toml"));
  const auto& rows = motion.ledger;
  for (std::size_t k = 1; k + 1 < rows.size(); ++k)
    if (rows[k].strain_j > rows[k - 1].strain_j && rows[k].strain_j >= rows[k + 1].strain_j &&
        rows[k].strain_j > 0.5 * rows.back().strain_j)
      peaks.push_back(std::sqrt(rows[k].strain_j));
  ASSERT_GE(peaks.size(), 3u);
  // It swings about its rest by exp(-loss factor omega t/2), and its peaks are a period apart.
  EXPECT_LE(std::abs((peaks[0] - peaks[1]) / (peaks[1] - peaks[2]) / std::exp(0.2 * M_PI) - 1.0), 0.05);
  EXPECT_LE(std::abs(rows.back().work_j), 0.01 * rows.back().viscous_j);
  EXPECT_LE(motion.residual_relative, 1e-9);
}

TEST_F(SceneModal, APlateWhoseHoldsKeepAllOfItsMotionsIsStill) {
  std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n";
  std::string holds;
  for (const char* at : {"0.01, 0.01, 0.1", "0.01, -0.01, 0.1", "-0.01, 0.01, 0.1", "-0.01, -0.01, -0.1"})
    holds += std::string("[[hold]]\nbody = \"bar\"\nat_m = [") + at + "]\ncsv = \"still.csv\"\n";
  Scene held = scene("n_modes = 3", "[solver]\nrate_hz = 20000\n", "", holds);
  held.materials[0].damping = damping::assumed_damping();
  const SceneMotion motion = move(held);
  EXPECT_LE(motion.final[0].velocity_m_s.norm(), 1e-9);
  EXPECT_LE(motion.residual_relative, 1e-9);
}

TEST_F(SceneModal, ABoxThatSlidesDoesNotSinkAndStopsWhereItShould) {  // more corners than it has motions
  Scene sliding = scene("n_modes = 6", "[solver]\nrate_hz = 5000\n[world.floor]\nmaterial = \"soft\"\n",
                        "position_m = [0, 0, 0.01]\nrotation_deg = [0, 90, 0]\nvelocity_m_s = [0.5, 0, 0]");
  sliding.duration_s = 0.15;
  const SceneMotion motion = move(sliding);
  EXPECT_LE(std::abs(motion.final[0].position_m.z() - 0.01), 2e-5);  // as soft as it is it sags by rho g h^2/(2 E)
  EXPECT_LE(std::abs(motion.final[0].position_m.x() / (0.25 / (2.0 * 0.4 * 9.81)) - 1.0), 2e-2);
  EXPECT_LE(motion.final[0].velocity_m_s.norm(), 1e-3);
  EXPECT_LE(*motion.contact_residual, 1e-6);
}

TEST_F(SceneModal, WhatIsDrawnFasterHasTheSpeedOfThatMoment) {
  std::ofstream(folder_ / "faster.csv") << "time_s,x,y,z\n0,2,0,0\n1,2,0,0\n";
  const SceneMotion motion =
      move(scene("n_modes = 0", "[solver]\nrate_hz = 10000\n[world]\ngravity_m_s2 = [0, 0, 0]\n", "",
                 "[[hold]]\nbody = \"bar\"\nat_m = [0, 0, 0.1]\nkind = \"acceleration\"\ncsv = \"faster.csv\"\n"
                 "[[hold]]\nbody = \"bar\"\nat_m = [0, 0, -0.1]\nkind = \"acceleration\"\ncsv = \"faster.csv\"\n"));
  EXPECT_LE(std::abs(motion.final[0].velocity_m_s.x() / (2.0 * 0.02) - 1.0), 1e-9);
  EXPECT_LE(std::abs(motion.ledger.back().work_j / (0.5 * 0.08 * 0.04 * 0.04) - 1.0), 1e-9);
}

TEST_F(SceneModal, WhatIsHeldByItsAccelerationKeepsItsSpeed) {
  std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n1,0,0,0\n";
  const SceneMotion motion = move(scene(
      "n_modes = 3", "[solver]\nrate_hz = 10000\n[world]\ngravity_m_s2 = [0, 0, 0]\n", "velocity_m_s = [0.5, 0, 0]",
      "[[hold]]\nbody = \"bar\"\nwhere = \"z=min\"\nkind = \"acceleration\"\ncsv = \"still.csv\"\n"));
  EXPECT_LE((motion.final[0].velocity_m_s - Eigen::Vector3d(0.5, 0, 0)).norm(), 1e-9);
  EXPECT_LE((motion.final[0].position_m - Eigen::Vector3d(0.01, 0, 0)).norm(), 1e-9);
  EXPECT_LE(std::abs(motion.ledger.back().work_j - motion.ledger.front().work_j), 1e-12);
}

TEST_F(SceneModal, WhatItCannotDoIsRefused) {
  EXPECT_THROW(scene("n_modes = 2.5", kWeightless, kFlying), InputError);
  EXPECT_THROW(scene("contact = \"guess\"", kWeightless, kFlying), InputError);
  EXPECT_THROW(scene("n_modes = 2", kWeightless, std::string(kFlying) + "\nfixed = true"), InputError);
}

}  // namespace
}  // namespace klang::scene
