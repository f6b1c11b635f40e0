// Cracking bodies in scenes: a bar that is drawn apart, a ball on a wall, what is refused.
#include "core/sound/scene/scene_cracking.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/sound/scene/scene_check.hpp"
#include "tests/places.hpp"

namespace klang::scene {
namespace {

class SceneCracking : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("cracking-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    write("still.csv", "time_s,x,y,z\n0,0,0,0\n");
    write("pull.csv", "time_s,x,y,z\n0,0,0,0\n0.01,0.1,0,0\n");
    write("jump.csv", "time_s,x,y,z\n0,0.1,0,0\n");
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  Scene scene(const std::string& text) const { return parse_scene(text, folder_ / "scene.toml"); }

  static std::string material() {
    return "[[material]]\nname = \"soft\"\nlame_lambda_pa = 4e6\nlame_mu_pa = 4e6\ndensity_kg_m3 = 1000\n";
  }
  static std::string bar(const std::string& crack, const std::string& pull = "pull.csv") {
    return "duration_s = 0.04\n[world]\ngravity_m_s2 = [0, 0, 0]\n" + material() +
           "[[body]]\nname = \"bar\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = \"none\"\nmax_edge_m = 0.06\n"
           "shape = { kind = \"box\", length_m = 0.3, width_m = 0.1, height_m = 0.1 }\n[crack]\n" +
           crack + "\n[[hold]]\nbody = \"bar\"\nwhere = \"x=min\"\ncsv = \"still.csv\"\n" +
           "[[hold]]\nbody = \"bar\"\nwhere = \"x=max\"\nkind = \"velocity\"\ncsv = \"" + pull + "\"\n";
  }
  std::filesystem::path folder_;
};

const char* const kCrack = "strength_pa = 5e4\nviscosity_mu_pa_s = 400\nviscosity_lambda_pa_s = 400";

TEST_F(SceneCracking, ABarThatIsDrawnApartPartsAtItsStrengthAndEveryJouleIsAccountedFor) {
  const SceneMotion motion = move(scene(bar(kCrack)));
  ASSERT_TRUE(motion.cracks.has_value());
  EXPECT_LE(motion.residual_relative, 1e-3);
  EXPECT_GT(motion.ledger.back().work_j, 0.0);
  EXPECT_GT(motion.ledger.back().viscous_j, 0.0);
  ASSERT_FALSE(motion.cracks->splits.empty());
  EXPECT_LE(std::abs(motion.cracks->splits.front().largest_stress_pa.value() / 5e4 - 1.0), 0.05);
  // Drawn at v from a ramp of 10 ms: strain v (t - 5 ms)/L, Young's modulus 1e7.
  const double strain = 0.1 * (motion.cracks->splits.front().time_s - 0.005) / 0.3;
  EXPECT_LE(std::abs(strain * 1e7 / 5e4 - 1.0), 0.1);
  // What the bar held then is the work of drawing it by that strain, less what waves and viscosity have of it.
  const fracture::SolidEnergies& then = motion.cracks->splits.front().energies;
  EXPECT_LE(std::abs(then.elastic_j / (0.5 * 1e7 * strain * strain * 3e-3) - 1.0), 0.25);
  EXPECT_GT(then.kinetic_j, 0.0);
  EXPECT_GT(then.viscous_j, 0.0);
  EXPECT_LE(then.viscous_j, motion.ledger.back().viscous_j);
  ASSERT_GE(motion.mass_kg.size(), 3u);
  double pieces = 0.0;
  for (std::size_t i = 1; i < motion.mass_kg.size(); ++i) {
    pieces += motion.mass_kg[i];
    EXPECT_EQ(motion.log.bodies[i].parent, 0);
  }
  EXPECT_LE(std::abs(pieces / motion.mass_kg[0] - 1.0), 1e-12);
  EXPECT_LE(std::abs(motion.mass_kg[0] - 3.0), 1e-9);
  EXPECT_NO_THROW(motion.log.validate());
}

TEST_F(SceneCracking, WithoutStressItStaysWholeAndABodyThatFlowsSaysHowMuch) {
  const SceneMotion still = move(scene(bar(kCrack, "still.csv")));
  EXPECT_EQ(still.cracks->n_splits, 0);
  EXPECT_EQ(still.mass_kg.size(), 1u);
  EXPECT_LE(still.residual_relative, 1e-3);
  const SceneMotion flowing =
      move(scene(bar("strength_pa = 1e9\nyield_stress_pa = 2e4\nplastic_strain_limit = 0.1\nviscosity_mu_pa_s = 400")));
  EXPECT_EQ(flowing.cracks->n_splits, 0);
  EXPECT_GT(flowing.cracks->dissipation_j, 0.0);
  EXPECT_GT(flowing.cracks->max_strain, 0.0);
  EXPECT_LE(flowing.cracks->max_strain, 0.1);
  EXPECT_LE(flowing.residual_relative, 1e-3);
}

TEST_F(SceneCracking, ABallGivesItsMomentumToTheBlockThatItStrikes) {
  const std::string text =
      "duration_s = 0.02\n[world]\ngravity_m_s2 = [0, 0, 0]\n" + material() +
      "[[body]]\nname = \"block\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = \"none\"\nmax_edge_m = 0.05\n"
      "shape = { kind = \"box\", length_m = 0.1, width_m = 0.1, height_m = 0.1 }\n"
      "[[body]]\nname = \"ball\"\nmaterial = \"soft\"\nsound = \"none\"\nposition_m = [-0.105, 0.003, 0.002]\n"
      "velocity_m_s = [1, 0, 0]\nshape = { kind = \"sphere\", radius_m = 0.05 }\n[crack]\nstrength_pa = 1e9\n";
  const SceneMotion motion = move(scene(text));
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < 2; ++i) momentum += motion.mass_kg[i] * motion.final[i].velocity_m_s;
  EXPECT_LE((momentum - motion.mass_kg[1] * Eigen::Vector3d::UnitX()).norm(), 1e-9 * motion.mass_kg[1]);
  EXPECT_GT(motion.final[0].velocity_m_s.x(), 0.1);
  EXPECT_LE(motion.residual_relative, 1e-3);
  EXPECT_FALSE(motion.log.impulses.empty());
}

/// Two blocks of the same stuff that fly at each other.
std::string two_blocks(const std::string& crack, double speed_m_s, const std::string& more = "") {
  const auto block = [&](const char* name, double x, double v) {
    std::ostringstream text;
    text << "[[body]]\nname = \"" << name
         << "\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = \"none\"\nmax_edge_m = 0.05\n"
         << "shape = { kind = \"box\", length_m = 0.2, width_m = 0.1, height_m = 0.1 }\nposition_m = [" << x
         << ", 0, 0]\nvelocity_m_s = [" << v << ", 0, 0]\n";
    return text.str();
  };
  return "duration_s = 0.03\n[world]\ngravity_m_s2 = [0, 0, 0]\n[[material]]\nname = \"soft\"\nlame_lambda_pa = 4e6\n"
         "lame_mu_pa = 4e6\ndensity_kg_m3 = 1000\nfriction = 0.3\n" +
         more + block("left", -0.101, speed_m_s) + block("right", 0.101, -speed_m_s) + "[crack]\n" + crack + "\n";
}

TEST_F(SceneCracking, TwoEqualBlocksMeetAndTradeTheirMotion) {
  const SceneMotion motion = move(scene(two_blocks("strength_pa = 1e9", 1.0)));
  const Eigen::Vector3d left = motion.final[0].velocity_m_s, right = motion.final[1].velocity_m_s;
  EXPECT_LE((left + right).norm(), 1e-12);  // of equal masses
  EXPECT_LE(motion.residual_relative, 1e-3);
  // Bars of one length: a wave goes through each once and brings all motion back, but for what corners and sides take.
  EXPECT_LE(left.x(), -0.9);
  EXPECT_GE(left.x(), -1.0);
  EXPECT_LE(left.tail<2>().norm(), 0.01);  // flat on flat: nothing goes sideways, whatever the meshes
  const Eigen::Vector3d shift = motion.final[0].position_m + motion.final[1].position_m;
  EXPECT_LE(shift.norm(), 1e-12);
  EXPECT_LE(motion.ledger.back().contact_j, 1e-9);  // nothing is stored any more
  ASSERT_FALSE(motion.log.impulses.empty());
  EXPECT_EQ(motion.log.impulses.front().kind, events::ImpulseKind::kImpact);
  Eigen::Vector3d given = Eigen::Vector3d::Zero();
  for (const events::Impulse& row : motion.log.impulses)
    if (row.body == 0) given += motion.log.motion_of(0).at(row.time_s + row.duration_s).orientation() * row.impulse_n_s;
  EXPECT_LE(std::abs(given.x() / (motion.mass_kg[0] * (left.x() - 1.0)) - 1.0), 1e-3);
}

TEST_F(SceneCracking, BlocksThatBreakOnEachOtherKeepTheirMomentumAndEveryJoule) {
  const SceneMotion motion = move(scene(two_blocks("strength_pa = 1e4\nviscosity_mu_pa_s = 100", 5.0)));
  ASSERT_GE(motion.mass_kg.size(), 5u);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  std::size_t of_left = 0, between = 0;
  for (std::size_t i = 2; i < motion.mass_kg.size(); ++i) {
    momentum += motion.mass_kg[i] * motion.final[i].velocity_m_s;
    of_left += motion.log.bodies[i].parent == 0 ? 1 : 0;
  }
  EXPECT_GE(of_left, 2u);
  EXPECT_LE(of_left + 2, motion.mass_kg.size() - 2);
  EXPECT_LE(momentum.norm(), 1e-12 * 5.0 * motion.mass_kg[0]);
  EXPECT_LE(motion.residual_relative, 1e-3);
  for (const events::Impulse& row : motion.log.impulses)
    if (row.other >= 2 && row.kind != events::ImpulseKind::kFracture)
      between += motion.log.bodies[static_cast<std::size_t>(row.body)].parent !=
                         motion.log.bodies[static_cast<std::size_t>(row.other)].parent
                     ? 1
                     : 0;
  EXPECT_GE(between, 2u) << "pieces of the one push pieces of the other";
  EXPECT_NO_THROW(motion.log.validate());
}

TEST_F(SceneCracking, FrictionOfABallOnAPlateOnlyTakesAndSpringsGiveBackWhatTheyStore) {
  const auto struck = [&](const char* rate_hz) {
    return move(
        scene("duration_s = 0.01\n[solver]\nrate_hz = " + std::string(rate_hz) +
              "\n[world]\ngravity_m_s2 = [0, 0, 0]\n" + material() +
              "friction = 0.3\n[[material]]\nname = \"hard\"\nyoungs_modulus_pa = 2e11\npoissons_ratio = 0.3\nfriction "
              "= 0.3\n"
              "density_kg_m3 = 7800\n[[body]]\nname = \"plate\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = "
              "\"none\"\n"
              "max_edge_m = 0.02\nshape = { kind = \"box\", length_m = 0.1, width_m = 0.1, height_m = 0.02 }\n"
              "[[body]]\nname = \"ball\"\nmaterial = \"hard\"\nsound = \"none\"\nposition_m = [0.012, 0.005, 0.03]\n"
              "velocity_m_s = [0.5, 0, -2]\nshape = { kind = \"sphere\", radius_m = 0.015 }\n"
              "[crack]\nstrength_pa = 1e9\nviscosity_mu_pa_s = 20\n"));
  };
  const SceneMotion motion = struck("20000");
  const double all_j = motion.ledger.front().kinetic_j;
  for (std::size_t i = 1; i < motion.ledger.size(); ++i)
    EXPECT_GE(motion.ledger[i].friction_j, motion.ledger[i - 1].friction_j - 1e-6 * all_j) << motion.ledger[i].time_s;
  EXPECT_GE(motion.ledger.back().friction_j,
            0.02 * all_j);  // Coulomb's 0.3 of a normal impulse while it slips at 0.5 m/s
  EXPECT_LE(std::abs(motion.ledger.back().contact_j), 1e-3 * all_j);
  EXPECT_TRUE(motion.cracks->warnings.empty());
  // A step of the motion that is as long as the touch makes energy, and the run says so.
  const SceneMotion coarse = struck("1000");
  ASSERT_EQ(coarse.cracks->warnings.size(), 1u);
  EXPECT_NE(coarse.cracks->warnings[0].find("a higher solver.rate_hz"), std::string::npos)
      << coarse.cracks->warnings[0];
}

TEST_F(SceneCracking, PiecesPushOneAnotherEquallyAndStandInTheLogOnBoth) {
  const auto smashed = [&](const char* self_contact) {
    return move(scene(
        "duration_s = 0.02\n[world]\ngravity_m_s2 = [0, 0, 0]\n" + material() +
        "[[body]]\nname = \"block\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = \"none\"\nmax_edge_m = 0.04\n"
        "shape = { kind = \"box\", length_m = 0.1, width_m = 0.1, height_m = 0.1 }\n"
        "[[body]]\nname = \"ball\"\nmaterial = \"soft\"\nsound = \"none\"\nposition_m = [-0.105, 0.003, 0.002]\n"
        "velocity_m_s = [20, 0, 0]\nshape = { kind = \"sphere\", radius_m = 0.05 }\n[crack]\nstrength_pa = 5e4\n"
        "viscosity_mu_pa_s = 200\nself_contact = " +
        std::string(self_contact)));
  };
  const SceneMotion motion = smashed("true");
  ASSERT_GE(motion.mass_kg.size(), 4u);
  EXPECT_LE(motion.residual_relative, 1e-3);
  double n = 0.0, sum = 0.0;
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  // of equal and opposite rows, in the world
  for (const events::Impulse& row : motion.log.impulses) {
    if (row.body < 2 || row.other < 2 || row.kind == events::ImpulseKind::kFracture) continue;
    const double end_s = row.time_s + row.duration_s;
    rest += motion.log.motion_of(row.body).at(end_s).orientation() * row.impulse_n_s;
    sum += row.impulse_n_s.norm();
    ++n;
  }
  EXPECT_GE(n, 20.0);
  EXPECT_LE(rest.norm(), 0.05 * sum);  // poses are kept every few steps, and lie between them here
  Eigen::Vector3d momentum = motion.mass_kg[1] * motion.final[1].velocity_m_s;
  for (std::size_t i = 2; i < motion.mass_kg.size(); ++i) momentum += motion.mass_kg[i] * motion.final[i].velocity_m_s;
  EXPECT_LE((momentum / motion.mass_kg[1] - 20.0 * Eigen::Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_TRUE(motion.cracks->warnings.empty());
  const SceneMotion through = smashed("false");
  ASSERT_EQ(through.cracks->warnings.size(), 1u);
  for (const events::Impulse& row : through.log.impulses)
    EXPECT_TRUE(row.body < 2 || row.other < 2 || row.kind == events::ImpulseKind::kFracture);
}

TEST_F(SceneCracking, ABodyThatCracksAndStaysWholeGoesOnWithItsSlitMeshAndItsCracksPushIt) {
  const auto struck = [&](const char* sound) {
    return move(scene(
        "duration_s = 0.02\n[world]\ngravity_m_s2 = [0, 0, 0]\n" + material() +
        "[[body]]\nname = \"block\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nmax_edge_m = 0.04\nsound = \"" + sound +
        "\"\nshape = { kind = \"box\", length_m = 0.1, width_m = 0.1, height_m = 0.1 }\n"
        "[[body]]\nname = \"ball\"\nmaterial = \"soft\"\nsound = \"none\"\nposition_m = [-0.105, 0.003, 0.002]\n"
        "velocity_m_s = [2, 0, 0]\nshape = { kind = \"sphere\", radius_m = 0.05 }\n[crack]\nstrength_pa = 3e4\n"
        "viscosity_mu_pa_s = 200\n"));
  };
  const SceneMotion silent = struck("none");
  ASSERT_GE(silent.cracks->n_splits, 3);
  ASSERT_EQ(silent.mass_kg.size(), 2u) << "still in one piece, and not heard: nothing changes";
  const SceneMotion heard = struck("modes");
  ASSERT_EQ(heard.mass_kg.size(), 3u);
  EXPECT_EQ(heard.log.bodies[2].parent, 0);
  EXPECT_LE(std::abs(heard.mass_kg[2] / heard.mass_kg[0] - 1.0), 1e-12);
  ASSERT_EQ(heard.pieces.size(), 1u);
  ASSERT_TRUE(heard.pieces[0].mesh.has_value());
  EXPECT_EQ(heard.pieces[0].mesh->n_elements(), heard.cracks->n_elements_end);
  ASSERT_EQ(heard.log.fractures.size(), 1u);
  EXPECT_LE(std::abs(heard.log.fractures[0].time_s - heard.cracks->splits.front().time_s), 2e-4);
  double pulls = 0.0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const events::Impulse& row : heard.log.impulses)
    if (row.kind == events::ImpulseKind::kFracture) {
      EXPECT_EQ(row.body, 2);
      pulls += row.impulse_n_s.norm();
      sum += row.impulse_n_s;
    }
  EXPECT_GT(pulls, 0.0);
  EXPECT_LE(sum.norm(), 1e-9 * pulls) << "both lips of a slit, one pull";
  EXPECT_NO_THROW(heard.log.validate());
}

TEST_F(SceneCracking, AWallThatIsStruckGrowsAsThatOfFigureNineDoes) {  // B99: 1109 elements with 8275
  const auto path = std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes/b99/wall_1_fine.toml";
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const SceneMotion motion = move(parse_scene(text, path), 0.012);
  EXPECT_NEAR(motion.cracks->n_elements_start, 1109, 30);
  EXPECT_GE(motion.cracks->n_elements_end, 5000);
  EXPECT_LE(motion.cracks->n_elements_end, 11000);
  EXPECT_LE(motion.residual_relative, 1e-3);
}

TEST_F(SceneCracking, BowlsOfLowerStrengthComeIntoMorePieces) {  // B99 Figure 11: strengths 4 : 3 : 2.5 : 1
  std::size_t fewer = 1;
  for (const char* bowl : {"bowl_1", "bowl_2", "bowl_3", "bowl_4"}) {
    const auto path = std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes/b99" /
                      (std::string(bowl) + ".toml");
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const SceneMotion motion = move(parse_scene(text, path));
    EXPECT_GT(motion.pieces.size(), fewer) << bowl;
    fewer = motion.pieces.size();
    EXPECT_LE(motion.residual_relative, 1e-3) << bowl;
  }
}

TEST_F(SceneCracking, ScenesOfThePapersCanBeRead) {
  int n = 0;
  for (const char* paper : {"b99", "d02", "h03"})
    for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(klang::test::source_dir()) /
                                                                 "datasets-synthetic/scenes" / paper)) {
      if (entry.path().extension() != ".toml") continue;
      std::ifstream file(entry.path());
      const std::string text{std::istreambuf_iterator<char>(file), {}};
      EXPECT_NO_THROW(parse_scene(text, entry.path())) << entry.path();
      ++n;
    }
  EXPECT_EQ(n, 34);
}

TEST_F(SceneCracking, WhatItCannotDoIsRefused) {
  EXPECT_THROW(scene(bar("strength_pa = 0")), InputError);
  EXPECT_THROW(scene(bar("")), InputError);
  EXPECT_THROW(scene(bar("strength_pa = 1\ntoughness_n = 1")), InputError);
  EXPECT_THROW(scene(bar("strength_pa = 1\nyield_stress_pa = 1\nplastic_strain_limit = 0.6124")), InputError);
  EXPECT_THROW(scene(bar("strength_pa = 1\nintegrator = \"euler\"")), InputError);
  EXPECT_THROW(scene(bar("strength_pa = 1\nviscosity_mu_pa_s = 3\nviscosity_lambda_pa_s = -2.1")), InputError);
  EXPECT_NO_THROW(scene(bar("strength_pa = 1\nviscosity_mu_pa_s = 3\nviscosity_lambda_pa_s = -2")));
  std::string jumps = bar(kCrack, "jump.csv");
  jumps.replace(jumps.find("velocity"), 8, "position");
  EXPECT_THROW(scene(jumps), InputError);
  std::string endless = bar(kCrack);
  endless.erase(0, endless.find('\n') + 1);
  EXPECT_THROW(scene(endless), InputError);
}

/// What check and run say of a scene; "" where neither complains, an error where they differ.
std::string complaint_of(const Scene& scene) {
  std::string checked, run;
  try {
    check_scene(scene);
  } catch (const InputError& error) {
    checked = error.what();
  }
  try {
    move(scene, 1e-3);
  } catch (const InputError& error) {
    run = error.what();
  }
  EXPECT_EQ(checked, run);
  return checked;
}

TEST_F(SceneCracking, ACheckRefusesWhatARunRefusesAndNamesThePlaceOnce) {
  EXPECT_EQ(complaint_of(scene(bar(kCrack))), "");
  const auto held = [&](const std::string& where) {
    return bar(kCrack) + "[[hold]]\nbody = \"bar\"\n" + where + "\ncsv = \"still.csv\"\n";
  };
  for (const char* where :
       {"where = \"x=max\"", "where = \"x>5\"", "at_m = [0.15, 0, 0.5]", "at_m = [0.15, 0.05, 0.05]"}) {
    const std::string text = complaint_of(scene(held(where)));
    EXPECT_EQ(text.rfind("scene.toml:", 0), 0u) << text;
    EXPECT_EQ(text.find("scene.toml:", 1), std::string::npos) << text;
    EXPECT_NE(text.find("hold[3]: "), std::string::npos) << text;
  }
  std::string fine = bar(kCrack);
  fine.replace(fine.find("max_edge_m = 0.06"), 17, "max_edge_m = 0.0003");
  const std::string text = complaint_of(scene(fine));
  EXPECT_NE(text.find("body[1]: max_edge_m: gives too many elements"), std::string::npos) << text;
}

TEST_F(SceneCracking, ACheckLooksAtTheHoldsOfModalBodiesToo) {
  std::string text = bar("strength_pa = 1");
  text.replace(text.find("\"cracking\""), 10, "\"modal\"\nmodal = { n_modes = 3 }");
  text.erase(text.find("[crack]"), std::string("[crack]\nstrength_pa = 1\n").size());
  EXPECT_EQ(complaint_of(scene(text)), "");
  for (const char* where : {"where = \"x=max\"", "where = \"x>5\""})
    EXPECT_NE(
        complaint_of(scene(text + "[[hold]]\nbody = \"bar\"\n" + where + "\ncsv = \"still.csv\"\n")).find("hold[3]: "),
        std::string::npos);
}

TEST_F(SceneCracking, ABodyThatInvertsIsNamed) {
  write("press.csv", "time_s,x,y,z\n0,0,0,0\n0.001,-20,0,0\n");
  try {
    move(scene(bar("strength_pa = 1e12", "press.csv")));
    ADD_FAILURE();
  } catch (const NumericalError& error) {
    EXPECT_EQ(std::string(error.what()).rfind("body bar: element ", 0), 0u) << error.what();
  }
}

/// A plate of 8 x 4 x 2 cubes of six tetrahedra; on the plane y = 0 the nodes left of x = 0 stand twice, one for each lip.
mesh::TetMesh slit_plate() {
  constexpr int kX = 8, kY = 4, kZ = 2;
  mesh::TetMesh mesh;
  std::vector<Eigen::Vector3d> nodes;
  std::map<std::array<int, 4>, int> number;  // i, j, k, lip
  const auto node = [&](int i, int j, int k, bool below) {
    const int lip = j == kY / 2 && i < kX / 2 && below ? 1 : 0;
    const auto [entry, is_new] = number.try_emplace({i, j, k, lip}, static_cast<int>(nodes.size()));
    if (is_new) nodes.emplace_back(0.01 * (i - kX / 2), 0.01 * (j - kY / 2), 0.01 * k);
    return entry->second;
  };
  std::vector<std::array<int, 4>> elements;
  for (int cube = 0; cube < kX * kY * kZ; ++cube) {
    const int i = cube % kX, j = cube / kX % kY, k = cube / (kX * kY);
    std::array<int, 3> axes = {0, 1, 2};
    do {  // the path from one corner to the opposite one, axis by axis
      std::array<int, 3> at = {i, j, k};
      std::array<int, 4> corners{};
      for (std::size_t c = 0; c < 4; ++c) {
        if (c > 0) ++at[static_cast<std::size_t>(axes[c - 1])];
        corners[c] = node(at[0], at[1], at[2], j < kY / 2);
      }
      const int turns = (axes[0] > axes[1]) + (axes[0] > axes[2]) + (axes[1] > axes[2]);
      if (turns % 2 == 1) std::swap(corners[2], corners[3]);
      elements.push_back(corners);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  mesh.nodes_m.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n) mesh.nodes_m.row(static_cast<Eigen::Index>(n)) = nodes[n].transpose();
  mesh.elements.resize(static_cast<Eigen::Index>(elements.size()), 4);
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int c = 0; c < 4; ++c)
      mesh.elements(static_cast<Eigen::Index>(e), c) = elements[e][static_cast<std::size_t>(c)];
  return mesh;
}

TEST_F(SceneCracking, TheLipsOfASlitHaveNoHangingNodesAndItOpens) {
  mesh::write_tet_mesh(folder_ / "slit.vtu", slit_plate());
  write("apart.csv", "time_s,x,y,z\n0,0,0,0\n0.01,0,0.0002,0\n");
  const std::string text =
      "duration_s = 0.01\n[world]\ngravity_m_s2 = [0, 0, 0]\n[frames]\nrate_hz = 100\n" + material() +
      "[[body]]\nname = \"plate\"\nmaterial = \"soft\"\nmodel = \"cracking\"\nsound = \"none\"\nmesh = \"slit.vtu\"\n"
      "[crack]\nstrength_pa = 1e9\nviscosity_mu_pa_s = 400\n[[hold]]\nbody = \"plate\"\nwhere = \"y=min\"\n"
      "csv = \"still.csv\"\n[[hold]]\nbody = \"plate\"\nwhere = \"y=max\"\ncsv = \"apart.csv\"\n";
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SceneMotion motion = move(scene(text), {}, seed);
    EXPECT_EQ(motion.cracks->n_splits, 0);
    EXPECT_LE(motion.residual_relative, 1e-3);
    // At the mouth the lips lie on one another at first and are apart by most of the way at the end.
    const std::vector<float>&start = motion.shapes.bodies[0].frames.front().places_m,
          &end = motion.shapes.bodies[0].frames.back().places_m;
    int n_mouth = 0;
    double least_m = HUGE_VAL;
    for (std::size_t a = 0; a < start.size(); a += 3)
      for (std::size_t b = 0; b < a; b += 3) {
        if (!(start[a] < -0.0399F) || start[a + 1] != start[b + 1] || start[a + 2] != start[b + 2]) continue;
        if (start[a] != start[b]) continue;
        ++n_mouth;
        least_m = std::min(least_m, static_cast<double>(std::abs(end[a + 1] - end[b + 1])));
      }
    EXPECT_EQ(n_mouth, 3);
    EXPECT_GE(least_m, 1e-4);
    EXPECT_LE(least_m, 2.5e-4);
  }
}

}  // namespace
}  // namespace klang::scene
