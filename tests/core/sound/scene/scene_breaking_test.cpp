#include "core/sound/scene/scene_breaking.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>

#include "core/foundation/base/output_file.hpp"
#include "core/physics/events/world_impulses.hpp"
#include "core/sound/scene/scene_motion.hpp"
#include "tests/places.hpp"

namespace klang::scene {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes/sb";

/// The tile of tile.toml, that clatters on its corners and parts at the third touch, 9 ms after the first: bounces that would carry its
/// steps on lie not between.
Scene clattering_tile() {
  std::string text = read_file(kScenes / "tile.toml");
  for (const auto& [from, to] :
       {std::pair<std::string, std::string>("rotation_deg = [2, 20, 0]\nangular_velocity_rad_s = [0, 2, 0]",
                                            "rotation_deg = [8, 25, 0]"),
        {"restitution = 0.7", "restitution = 0.4"},
        {"restitution = 0.7", "restitution = 0.4"},
        {"tensile_strength_pa = 300e6", "tensile_strength_pa = 60e6"},
        {"strength_factor = 0.09", "strength_factor = 0.5"},
        {"duration_s = 2.0", "duration_s = 0.9"}})
    text.replace(text.find(from), from.size(), to);
  return parse_scene(text, kScenes / "tile.toml");
}

TEST(SceneBreaking, AScoredTileFallsIntoItsHalvesWhateverTheStep) {
  std::vector<double> times_s, strains_j;
  for (const double rate_hz : {5000.0, 10000.0, 20000.0}) {
    Scene scene = clattering_tile();
    scene.solver.rate_hz = rate_hz;
    const SceneMotion motion = move(scene, 0.5);
    ASSERT_EQ(motion.breaks.size(), 1u) << rate_hz;
    const BreakEvent& event = motion.breaks[0];
    EXPECT_EQ(event.n_pieces, 2);
    EXPECT_LE(std::abs(event.energies.fracture_j - 0.1 * 200 * 0.1 * 0.008), 1e-12);  // factor, G_c, area of the score
    ASSERT_EQ(motion.mass_kg.size(), 3u);
    EXPECT_LE(std::abs(motion.mass_kg[1] - 0.108), 1e-12);
    EXPECT_LE(std::abs(motion.mass_kg[2] - 0.108), 1e-12);
    EXPECT_LE(motion.residual_relative, 1e-9);
    times_s.push_back(event.time_s);
    strains_j.push_back(event.energies.strain_j);
  }
  for (std::size_t i = 1; i < times_s.size(); ++i) {
    EXPECT_LE(std::abs(times_s[i] - times_s[0]), 1e-10);  // at a later touch: bounces do not depend on the step
    EXPECT_LE(std::abs(strains_j[i] / strains_j[0] - 1.0), 1e-4);
  }
}

TEST(SceneBreaking, TheTileRingsWholeAfterItsFirstTouchAndInHalvesAfterALaterOne) {
  const Scene scene = read_scene(kScenes / "tile.toml");
  const SceneMotion motion = move(scene);
  ASSERT_EQ(motion.breaks.size(), 1u);
  double first_s = HUGE_VAL;
  for (const events::Impulse& row : motion.log.impulses) first_s = std::min(first_s, row.time_s);
  EXPECT_GE(motion.breaks[0].time_s - first_s, 0.05);
  EXPECT_GE(motion.end_s - motion.breaks[0].time_s, 0.05);
  ASSERT_EQ(motion.mass_kg.size(), 3u);
  EXPECT_LE(std::abs(motion.mass_kg[1] / motion.mass_kg[2] - 1.0), 1e-12);
}

// Straight elements leave out 1.6 % of this bowl's volume.
TEST(SceneBreaking, PiecesOfARoundBodyHaveItsWholeMass) {
  const SceneMotion motion = move(
      parse_scene(
          "[world]\n[world.floor]\nmaterial = \"glass\"\n[[material]]\nname = \"glass\"\nyoungs_modulus_pa = "
          "7e10\npoissons_ratio = 0.22\ndensity_kg_m3 = 2500\ntensile_strength_pa = 2e7\nfracture_energy_j_m2 = "
          "40\n[[body]]\nname = \"bowl\"\nmodel = \"breakable\"\nmaterial = \"glass\"\nstress_edge_m = "
          "0.012\nposition_m = [0, 0, 0.02]\nrotation_deg = [30, 0, 0]\nvelocity_m_s = [0, 0, -4]\nshape = { kind = "
          "\"bowl\", outer_radius_m = 0.06, wall_m = 0.004, depth_m = 0.05 }\n",
          "bowl.toml"),
      0.02);
  ASSERT_EQ(motion.breaks.size(), 1u);
  double pieces_kg = 0.0;
  for (std::size_t i = 1; i < motion.mass_kg.size(); ++i) pieces_kg += motion.mass_kg[i];
  EXPECT_LE(std::abs(pieces_kg / motion.mass_kg[0] - 1.0), 1e-12);
}

/// The slab of slab.toml with a coarse mesh for its stress.
Scene coarse_slab() {
  Scene scene = read_scene(kScenes / "slab.toml");
  scene.bodies[0].stress_edge_m = 0.02;
  return scene;
}

TEST(SceneBreaking, EnergyOfABreakageComesOutOfWhatItsImpactTook) {
  const SceneMotion motion = move(coarse_slab(), 0.5);
  ASSERT_EQ(motion.breaks.size(), 1u);
  const BreakEvent& event = motion.breaks[0];
  EXPECT_GE(event.n_pieces, 20);
  const fracture::FractureEnergies& e = event.energies;
  EXPECT_LE(e.fracture_j, 0.8 * e.strain_j);
  EXPECT_GT(e.residual_j, 0.0);  // the struck pieces stay strained (erratum 51)
  EXPECT_LE(std::abs(e.strain_j - e.fracture_j - e.kinetic_j - e.vibration_j - e.residual_j), 1e-12 * e.strain_j);
  EXPECT_LE(motion.residual_relative, 1e-9);
  const double scale_j = motion.energy_scale_j;
  for (std::size_t i = 1; i < motion.ledger.size(); ++i) {
    ASSERT_GE(motion.ledger[i].contact_j, motion.ledger[i - 1].contact_j) << i;
    ASSERT_LE(std::abs(motion.ledger[i].work_j), 1e-9 * scale_j) << i;  // nothing comes from outside
    // Breaking never makes motion: kinetic energy rises by what falling gives at most.
    const double gained = motion.ledger[i].kinetic_j + motion.ledger[i].potential_j - motion.ledger[i - 1].kinetic_j -
                          motion.ledger[i - 1].potential_j;
    ASSERT_LE(gained, 1e-3 * scale_j) << i;
  }
  double mass_kg = 0.0;
  for (std::size_t i = 1; i < motion.mass_kg.size(); ++i) mass_kg += motion.mass_kg[i];
  EXPECT_LE(std::abs(mass_kg / motion.mass_kg[0] - 1.0), 1e-12);
}

TEST(SceneBreaking, ABreakageIsAtThePeakOfItsLoadWhateverTheStep) {
  std::vector<double> times_s, strains_j, cracks_j;
  std::vector<int> n_pieces;
  for (const double rate_hz : {5000.0, 10000.0, 20000.0}) {
    Scene scene = clattering_tile();
    scene.bodies[0].score.reset();
    scene.materials[0].tensile_strength_pa = 10e6;
    scene.materials[0].fracture_energy_j_m2 = 25.0;
    scene.solver.rate_hz = rate_hz;
    const SceneMotion motion = move(scene, 0.36);
    ASSERT_EQ(motion.breaks.size(), 1u) << rate_hz;
    times_s.push_back(motion.breaks[0].time_s);
    strains_j.push_back(motion.breaks[0].energies.strain_j);
    cracks_j.push_back(motion.breaks[0].energies.fracture_j);
    EXPECT_LE(std::abs(strains_j.back() / strains_j.front() - 1.0), 1e-9)
        << rate_hz;  // strained as it lay at the touch
    EXPECT_LE(std::abs(cracks_j.back() / cracks_j.front() - 1.0), 1e-9) << rate_hz;
    n_pieces.push_back(motion.breaks[0].n_pieces);
    EXPECT_EQ(n_pieces.back(), n_pieces.front()) << rate_hz;
    EXPECT_GE(n_pieces.back(), 3) << rate_hz;
    double touch_s = 0.0, duration_s = 0.0;
    for (const events::Impulse& impulse : motion.log.impulses)
      if (impulse.body == 0 && impulse.kind == events::ImpulseKind::kImpact) {
        touch_s = impulse.time_s;
        duration_s = impulse.duration_s;
      }
    EXPECT_GE(times_s.back(), touch_s) << rate_hz;
    EXPECT_LE(times_s.back(), touch_s + duration_s) << rate_hz;
    EXPECT_LE(std::abs(times_s.back() - times_s.front()), 25e-6) << rate_hz;
  }
}

TEST(SceneBreaking, ImpulseOverStepStrainsWithTheSquareOfTheRate) {
  std::vector<double> strains_j;
  for (const double rate_hz : {5000.0, 10000.0}) {
    Scene scene = clattering_tile();
    scene.solver.rate_hz = rate_hz;
    scene.force_model = ForceModel::kImpulseOverStep;
    scene.materials[0].tensile_strength_pa = 1e5;
    scene.materials[0].fracture_energy_j_m2 = 1e-3;
    scene.fracture.most_pieces = 2;
    scene.fracture.impulses = false;
    const SceneMotion motion = move(scene, 0.36);
    ASSERT_EQ(motion.breaks.size(), 1u);
    strains_j.push_back(motion.breaks[0].energies.strain_j);
    EXPECT_LE(motion.residual_relative, 1e-9);
    EXPECT_GE(motion.ledger.back().work_j, -1e-9 * motion.energy_scale_j);
  }
  EXPECT_LE(std::abs(strains_j[1] / strains_j[0] - 4.0), 0.4);
}

TEST(SceneBreaking, MomentumIsThatOfTheImpulsesWithPieces) {
  const Scene scene = clattering_tile();
  const SceneMotion motion = move(scene, 0.5);
  Eigen::Vector3d pushed = Eigen::Vector3d::Zero(), carried = Eigen::Vector3d::Zero();
  double taken = 0.0;
  for (const events::WorldImpulse& row : events::world_impulses(motion.log)) {
    const Eigen::Vector3d j(row.jx_n_s, row.jy_n_s, row.jz_n_s);
    pushed += j;  // between pieces they cancel
    taken += j.norm();
  }
  for (std::size_t i = 1; i < motion.mass_kg.size(); ++i) carried += motion.mass_kg[i] * motion.final[i].velocity_m_s;
  const Eigen::Vector3d expected = carried - motion.mass_kg[0] * scene.solver.gravity_m_s2 * motion.end_s;
  EXPECT_LE((pushed - expected).norm(), 1e-9 * taken);
}

TEST(SceneBreaking, CracksPushFromTheMomentOfTheBreakageWhateverTheStep) {
  std::vector<double> times_s;
  for (const double rate_hz : {5000.0, 20000.0}) {
    Scene scene = clattering_tile();
    scene.materials[0].tensile_strength_pa = 10e6;
    scene.solver.rate_hz = rate_hz;
    const SceneMotion motion = move(scene, 0.36);
    ASSERT_EQ(motion.breaks.size(), 1u);
    EXPECT_EQ(motion.log.broken_s(0), motion.breaks[0].time_s);  // the whole body is heard until then
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double size = 0.0;
    for (const events::WorldImpulse& row : events::world_impulses(motion.log)) {
      if (row.kind != events::ImpulseKind::kFracture) continue;
      EXPECT_EQ(row.time_s, motion.breaks[0].time_s);
      const Eigen::Vector3d j(row.jx_n_s, row.jy_n_s, row.jz_n_s);
      sum += j;
      size += j.norm();
    }
    ASSERT_GT(size, 0.0);
    EXPECT_LE(sum.norm(), 1e-13 * size);
    times_s.push_back(motion.breaks[0].time_s);
  }
  EXPECT_LE(std::abs(times_s[1] - times_s[0]), 25e-6);
}

/// A glass disk in free space that a steel ball strikes in the middle of its face; of its mesh the scene says nothing.
Scene struck_disk(double tensile_strength_pa) {
  return parse_scene(R"([world]
gravity_m_s2 = [0, 0, 0]
[[material]]
name = "glass"
youngs_modulus_pa = 6.2e10
poissons_ratio = 0.2
density_kg_m3 = 2600
fracture_energy_j_m2 = 1e-4
tensile_strength_pa = )" +
                         std::to_string(tensile_strength_pa) +
                         R"(
[[material]]
name = "steel"
preset = "steel"
[[body]]
name = "disk"
shape = { kind = "rod", radius_m = 0.04, length_m = 0.008 }
material = "glass"
model = "breakable"
sound = "none"
[[body]]
name = "ball"
shape = { kind = "sphere", radius_m = 0.01 }
material = "steel"
sound = "none"
position_m = [0, 0, 0.01401]
velocity_m_s = [0, 0, -0.05]
)",
                     "disk.toml");
}

// Plate theory of the free disk (breaking_stress_test.cpp) at the peak of Hertz' force. Glass of a strength 6 % below what the face across from the
// ball gets breaks, of one 6 % above it holds: the mean of an element would be half of it.
TEST(SceneBreaking, AStruckDiskBreaksAtPlateTheorysStress) {
  const SceneMotion whole = move(struck_disk(1e11), 0.001);
  ASSERT_TRUE(whole.breaks.empty());
  ASSERT_GE(whole.log.impulses.size(), 2u);
  const events::Impulse& blow = whole.log.impulses[0];
  const double force_n = 1.839547 * blow.impulse_n_s.norm() / blow.duration_s;
  constexpr double kRadius = 0.04, kThickness = 0.008, kNu = 0.2, kPi = 3.14159265358979323846;
  const double moment_n =
      force_n / (4.0 * kPi) * ((1.0 + kNu) * std::log(kRadius / (0.325 * kThickness)) + 0.25 * (1.0 - kNu));
  const double stress_pa = 6.0 * moment_n / (kThickness * kThickness);
  const SceneMotion weak = move(struck_disk(0.94 * stress_pa), 0.001);
  ASSERT_EQ(weak.breaks.size(), 1u);
  EXPECT_LE(std::abs(weak.breaks[0].largest_stress_pa / stress_pa - 1.0), 0.06);
  const double compression_j = 0.5 * 0.05 * blow.impulse_n_s.norm() / 1.5;
  EXPECT_LE(weak.breaks[0].energies.strain_j, 0.9 * compression_j);  // the blow had more: the force is Hertz'
  EXPECT_TRUE(move(struck_disk(1.06 * stress_pa), 0.001).breaks.empty());
}

TEST(SceneBreaking, AMeshTooCoarseForItsStressIsSaid) {
  Scene scene = struck_disk(1e8);
  EXPECT_TRUE(coarse_stress_warnings(scene).empty());
  scene.bodies[0].stress_edge_m = 0.03;
  ASSERT_EQ(coarse_stress_warnings(scene).size(), 1u);
  EXPECT_NE(coarse_stress_warnings(scene)[0].find("disk"), std::string::npos);
}

/// Two tiles in free space, one flying into the other's face corner first.
Scene tiles_that_meet(bool still_one_first) {
  const std::string material = R"([world]
gravity_m_s2 = [0, 0, 0]
[[material]]
name = "ceramic"
youngs_modulus_pa = 7.2e10
poissons_ratio = 0.19
density_kg_m3 = 2700
restitution = 0.5
friction = 0.4
tensile_strength_pa = 2e6
fracture_energy_j_m2 = 20
damping = { model = "rayleigh", rayleigh_stiffness_s = 3e-8, rayleigh_mass_per_s = 8 }
[sound]
band_hz = [20, 8000]
listener = { position_m = [0, -1, 1], mode = "mono" }
)";
  const std::string common = R"(shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.008 }
material = "ceramic"
model = "breakable"
stress_edge_m = 0.01
)";
  const std::string still = "[[body]]\nname = \"still\"\n" + common;
  const std::string flying = "[[body]]\nname = \"flying\"\n" + common +
                             "position_m = [0.01, 0.02, 0.1]\nrotation_deg = [8, 25, 0]\nvelocity_m_s = [0, 0, -5]\n";
  return parse_scene("duration_s = 0.05\n" + material + (still_one_first ? still + flying : flying + still),
                     "meeting.toml");
}

TEST(SceneBreaking, TwoBodiesThatBreakOnEachOtherKeepEnergyAndMomentumWhicheverIsFirst) {
  std::array<std::map<std::string, double>, 2> strain_j;
  for (const bool still_one_first : {true, false}) {
    const SceneMotion motion = move(tiles_that_meet(still_one_first), 0.05);
    ASSERT_EQ(motion.breaks.size(), 2u);
    EXPECT_LE(motion.residual_relative, 1e-9);
    Eigen::Vector3d carried = Eigen::Vector3d::Zero();
    for (std::size_t i = 2; i < motion.mass_kg.size(); ++i) carried += motion.mass_kg[i] * motion.final[i].velocity_m_s;
    const double momentum = 5.0 * motion.mass_kg[0];
    EXPECT_LE((carried - Eigen::Vector3d(0, 0, -momentum)).norm(), 1e-9 * momentum);
    for (const BreakEvent& event : motion.breaks)
      strain_j[still_one_first][motion.log.bodies[static_cast<std::size_t>(event.body)].name] = event.energies.strain_j;
  }
  for (const std::string name : {"still", "flying"}) {
    EXPECT_GT(strain_j[0][name], 0.0);
    EXPECT_LE(std::abs(strain_j[1][name] / strain_j[0][name] - 1.0), 1e-9) << name;
  }
}

TEST(SceneBreaking, LoadsThatCannotReachTheStrengthAreSkippedAndNothingChanges) {
  // A grain that touches one of the tiles before they meet: too gently to break anything.
  Scene scene = tiles_that_meet(true);
  SceneBody grain = scene.bodies[0];
  grain.name = "grain";
  grain.model = BodyModel::kRigid;
  grain.shape->kind = "sphere";
  grain.shape->dims = {{"radius_m", 0.001}};
  grain.position_m = {0.02, 0.01, -0.0051};
  grain.velocity_m_s = {0.0, 0.0, 0.02};
  scene.bodies.push_back(grain);
  const SceneMotion skipped = move(scene, 0.05);
  scene.skip_harmless_loads = false;
  const SceneMotion solved = move(scene, 0.05);
  EXPECT_LT(skipped.n_stress_solves, solved.n_stress_solves);
  ASSERT_EQ(skipped.breaks.size(), solved.breaks.size());
  ASSERT_GE(skipped.breaks.size(), 1u);
  for (std::size_t i = 0; i < solved.breaks.size(); ++i) {
    EXPECT_EQ(skipped.breaks[i].time_s, solved.breaks[i].time_s);
    EXPECT_EQ(skipped.breaks[i].n_pieces, solved.breaks[i].n_pieces);
    EXPECT_EQ(skipped.breaks[i].energies.strain_j, solved.breaks[i].energies.strain_j);
    EXPECT_EQ(skipped.breaks[i].largest_stress_pa, solved.breaks[i].largest_stress_pa);
  }
  ASSERT_EQ(skipped.final.size(), solved.final.size());
  for (std::size_t i = 0; i < solved.final.size(); ++i)
    EXPECT_EQ(skipped.final[i].position_m, solved.final[i].position_m);
}

TEST(SceneBreaking, PiecesBreakInTheirTurnAndMassMomentumAndEnergyAreKept) {
  Scene scene = tiles_that_meet(true);
  // A block that the pieces fly at.
  SceneBody block = scene.bodies[0];
  block.name = "block";
  block.model = BodyModel::kRigid;
  block.shape->dims = {{"length_m", 0.4}, {"width_m", 0.4}, {"height_m", 0.4}};
  block.position_m = {0.0, 0.0, -0.3};
  scene.bodies.push_back(block);
  scene.fracture.smallest_piece_m = 0.025;
  const SceneMotion once = move(scene, 0.06);
  scene.fracture.generations = 2;
  const SceneMotion often = move(scene, 0.06);
  ASSERT_EQ(once.breaks.size(), 2u);
  ASSERT_GT(often.breaks.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(often.breaks[i].n_pieces, once.breaks[i].n_pieces);
  EXPECT_LE(often.residual_relative, 1e-9);
  std::vector<double> of_pieces(often.mass_kg.size(), 0.0);
  std::vector<char> broken(often.mass_kg.size(), 0);
  for (const BreakEvent& event : often.breaks) broken[static_cast<std::size_t>(event.body)] = 1;
  Eigen::Vector3d carried = Eigen::Vector3d::Zero();
  int deepest = 0;
  for (std::size_t i = 0; i < often.mass_kg.size(); ++i) {
    int depth = 0;
    for (std::size_t k = i; often.log.bodies[k].parent >= 0; ++depth)
      k = static_cast<std::size_t>(often.log.bodies[k].parent);
    deepest = std::max(deepest, depth);
    if (broken[i] == 0) carried += often.mass_kg[i] * often.final[i].velocity_m_s;
    if (often.log.bodies[i].parent >= 0)
      of_pieces[static_cast<std::size_t>(often.log.bodies[i].parent)] += often.mass_kg[i];
  }
  EXPECT_EQ(deepest, 2);
  for (const BreakEvent& event : often.breaks) {
    const auto row = static_cast<std::size_t>(event.body);
    EXPECT_LE(std::abs(of_pieces[row] / often.mass_kg[row] - 1.0), 1e-12);
  }
  const double momentum = 5.0 * often.mass_kg[0];
  EXPECT_LE((carried - Eigen::Vector3d(0, 0, -momentum)).norm(), 1e-9 * momentum);
}

TEST(SceneBreaking, SameSeedSameBitsAndAStrongTileStaysWhole) {
  const Scene scene = coarse_slab();
  const SceneMotion one = move(scene, 0.46, 7), two = move(scene, 0.46, 7), other = move(scene, 0.46, 8);
  ASSERT_EQ(one.final.size(), two.final.size());
  for (std::size_t i = 0; i < one.final.size(); ++i) EXPECT_EQ(one.final[i].position_m, two.final[i].position_m);
  EXPECT_TRUE(one.final.size() != other.final.size() || one.final[1].position_m != other.final[1].position_m);
  Scene strong = clattering_tile();
  strong.materials[0].tensile_strength_pa = 1e12;
  EXPECT_TRUE(move(strong, 0.5).breaks.empty());
}

TEST(SceneBreaking, ABodyThatReachedItsStrengthAndStayedWholeIsSaid) {
  std::vector<std::string> said;
  const SceneNotes notes{[](const std::string&) {}, [&](const std::string& text) { said.push_back(text); }};
  const auto times = [&] {
    return std::count_if(said.begin(), said.end(), [](const std::string& text) {
      return text.find("stayed whole, though its stress reached its strength") != std::string::npos;
    });
  };
  Scene tough = coarse_slab();
  for (SceneMaterial& material : tough.materials) material.fracture_energy_j_m2 = 1e7;
  EXPECT_TRUE(move(tough, 0.46, 7, notes).breaks.empty());
  EXPECT_EQ(times(), 1);
  said.clear();
  EXPECT_EQ(move(coarse_slab(), 0.46, 7, notes).breaks.size(), 1U);
  EXPECT_EQ(times(), 0);
}

// One cell costs nothing and parts nothing: with a score that runs beside the body it is tried alone.
TEST(SceneBreaking, ABodyWhoseCracksPartNothingIsSaid) {
  std::vector<std::string> said;
  const SceneNotes notes{[](const std::string&) {}, [&](const std::string& text) { said.push_back(text); }};
  Scene scene = clattering_tile();
  for (SceneBody& body : scene.bodies)
    if (body.score) body.score->plane.offset_m = 1.0;
  for (SceneMaterial& material : scene.materials) {
    material.tensile_strength_pa = 20e6;
    material.fracture_energy_j_m2 = 1e7;
  }
  EXPECT_TRUE(move(scene, 0.5, 7, notes).breaks.empty());
  EXPECT_EQ(std::count_if(said.begin(), said.end(),
                          [](const std::string& text) { return text.find("or part nothing") != std::string::npos; }),
            1);
}

// A tile on a hinge breaks when the ball is as fast as the place that it strikes, w = m v a / (m a^2 + I): what the hinge held until then stays in the
// pieces' momentum, what the rebound brought does not.
TEST(SceneBreaking, ABodyOnAHingeBreaksWithTheMomentumAtItsLargestCompression) {
  const Scene scene = parse_scene(
      "duration_s = 0.004\n[world]\ngravity_m_s2 = [0, 0, 0]\n[[material]]\nname = \"ceramic\"\nyoungs_modulus_pa = "
      "7.2e10\npoissons_ratio = 0.19\ndensity_kg_m3 = 2700\nrestitution = 0.7\nfriction = 0\ntensile_strength_pa = "
      "20e6\nfracture_energy_j_m2 = 10\n[[body]]\nname = \"tile\"\nshape = { kind = \"box\", length_m = 0.1, width_m = "
      "0.1, height_m = 0.008 }\nmaterial = \"ceramic\"\nmodel = \"breakable\"\nstress_edge_m = 0.01\n[[body]]\nname = "
      "\"ball\"\nmaterial = \"ceramic\"\nshape = { kind = \"sphere\", radius_m = 0.01 }\nposition_m = [0.01, 0, "
      "0.0145]\nvelocity_m_s = [0, 0, -5]\n[[hinge]]\nbody = \"tile\"\nat_m = [-0.05, 0, 0]\naxis = [0, 1, 0]\n",
      "hinged.toml");
  const SceneMotion motion = move(scene, 0.004);
  ASSERT_EQ(motion.breaks.size(), 1U);
  double momentum = 0.0;
  for (std::size_t i = 1; i < motion.final.size(); ++i)
    momentum += motion.mass_kg[i] * motion.final[i].velocity_m_s.z();
  const double tile = motion.mass_kg[0], ball = motion.mass_kg[1], arm = 0.06;
  const double inertia = tile * ((0.1 * 0.1 + 0.008 * 0.008) / 12 + 0.05 * 0.05);
  const double spin = ball * 5.0 * arm / (ball * arm * arm + inertia);
  EXPECT_NEAR(momentum / -(ball * spin * arm + tile * spin * 0.05), 1.0, 1e-3);
  EXPECT_LE(motion.residual_relative, 1e-9);
}

}  // namespace
}  // namespace klang::scene
