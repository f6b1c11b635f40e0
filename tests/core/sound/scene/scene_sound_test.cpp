#include "core/sound/scene/scene_sound.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <fstream>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/scene/scene_motion.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "tests/core/physics/fracture/dynamic/lattice.hpp"

namespace klang::scene {
namespace {

const std::string kMaterials = R"(
[world.floor]
material = "floor"
[[material]]
name = "chime"
preset = "s02_chime"
restitution = 0.5
friction = 0.3
damping = { model = "rayleigh", rayleigh_stiffness_s = 1e-7 }
[[material]]
name = "floor"
youngs_modulus_pa = 30e9
poissons_ratio = 0.2
density_kg_m3 = 2400
restitution = 0.5
friction = 0.6
[sound]
band_hz = [20, 1000]
)";

std::vector<HeardBody> heard(const Scene& scene) {
  std::vector<HeardBody> bodies;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    bodies.push_back({static_cast<int>(i),
                      std::make_shared<const SoundModel>(sound_model_of(scene, scene.bodies[i]).value()),
                      scene.material_of(scene.bodies[i]).damping_heard()});
  return bodies;
}

/// A file of a hold that never moves.
std::string still_csv() {
  const std::string path = ::testing::TempDir() + "still-" + std::to_string(::getpid()) + ".csv";
  std::ofstream(path) << "time_s,x,y,z\n0,0,0,0\n";
  return path;
}

/// Amplitude of a frequency in a stretch of sound, by a Hann window.
double level(const Eigen::VectorXd& x, double rate_hz, double frequency_hz) {
  std::complex<double> sum = 0.0;
  const auto n = static_cast<double>(x.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    const double window = 1.0 - std::cos(2.0 * kPi * (static_cast<double>(i) + 0.5) / n);
    sum += window * x[i] * std::polar(1.0, -2.0 * kPi * frequency_hz * static_cast<double>(i) / rate_hz);
  }
  return std::abs(sum);
}

/// The frequency near a guess that stands highest.
double peak_hz(const Eigen::VectorXd& x, double rate_hz, double guess_hz) {
  double best = guess_hz, highest = 0.0;
  for (double f = 0.98 * guess_hz; f <= 1.02 * guess_hz; f += 1e-4 * guess_hz) {
    const double here = level(x, rate_hz, f);
    if (here > highest) {
      highest = here;
      best = f;
    }
  }
  return best;
}

// S02 Table 2's longest chime; its fundamental is that of the same tube as a free body.
TEST(SceneSound, ADroppedChimeRingsAtItsFundamental) {
  for (const double length_m : {0.505}) {
    const Scene scene = parse_scene(
        kMaterials + "[[body]]\nname = \"D\"\nmaterial = \"chime\"\nshape = { kind = \"tube\", length_m = " +
            std::to_string(length_m) + ", outer_radius_m = 0.0125, wall_m = 0.001 }\n" +
            "position_m = [0, 0, 0.12]\nrotation_deg = [84, 0, 0]\n",
        "chime.toml");
    const SceneMotion motion = move(scene, 0.9);
    const std::vector<HeardBody> bodies = heard(scene);
    const audio::Signal sound = sound_of(motion.log, bodies, scene.sound, 0.9);
    const double expected_hz = bodies[0].model->modes.frequency_hz()[0];
    const Eigen::VectorXd tail = sound.samples.col(0).tail(static_cast<Eigen::Index>(0.5 * sound.sample_rate_hz));
    EXPECT_LE(std::abs(peak_hz(tail, sound.sample_rate_hz, expected_hz) / expected_hz - 1.0), 5e-4) << length_m;
  }
}

TEST(SceneSound, ABodyAtRestIsSilentBesideADrop) {
  const std::string head = kMaterials;
  const std::string body =
      "[[body]]\nname = \"bar\"\nmaterial = \"chime\"\nshape = { kind = \"box\", length_m = 0.3, width_m = 0.04, "
      "height_m = "
      "0.01 }\nmax_edge_m = 0.03\n";
  const Scene resting = parse_scene(head + body + "position_m = [0, 0, 0.005]\n", "rest.toml");
  const Scene dropped =
      parse_scene(head + body + "position_m = [0, 0, 0.055]\nrotation_deg = [3, 2, 0]\n", "drop.toml");
  const std::vector<HeardBody> bodies = heard(resting);
  const double rest = sound_of(move(resting, 0.3).log, bodies, resting.sound, 0.3).samples.cwiseAbs().maxCoeff();
  const double drop = sound_of(move(dropped, 0.3).log, bodies, dropped.sound, 0.3).samples.cwiseAbs().maxCoeff();
  EXPECT_GT(drop, 1e-4);
  EXPECT_LE(rest, 1e-6 * drop);  // -120 dB
}

// The path is that of the ears: at the moment when it passes a place, what is heard is what one hears who stands there.
TEST(SceneSound, AListenerWhoWalksHearsWhatOneHearsWhoStandsWhereHePasses) {
  const Scene scene = parse_scene(
      kMaterials +
          "[[body]]\nname = \"bar\"\nmaterial = \"chime\"\nshape = { kind = \"box\", length_m = 0.3, width_m = 0.04, "
          "height_m = 0.01 }\nmax_edge_m = 0.03\nposition_m = [0, 0, 0.055]\nrotation_deg = [3, 2, 0]\n"
          "[sound.listener]\npath = [{ time_s = 0.1, position_m = [-2, -1, 1] }, { time_s = 0.5, position_m = [2, -1, "
          "1] "
          "}]\n",
      "walk.toml");
  const events::EventLog log = move(scene, 0.6).log;
  const std::vector<HeardBody> bodies = heard(scene);
  const Eigen::VectorXd walking = sound_of(log, bodies, scene.sound, 0.6).samples.col(0);
  const double peak = walking.cwiseAbs().maxCoeff();
  double most = 0.0, least = HUGE_VAL;
  for (const double time_s : {0.05, 0.2, 0.3, 0.45, 0.55}) {
    SceneSoundOptions standing = scene.sound;
    standing.listener.path.clear();
    standing.listener.position_m = {std::clamp(-2.0 + 10.0 * (time_s - 0.1), -2.0, 2.0), -1.0, 1.0};
    const Eigen::VectorXd there = sound_of(log, bodies, standing, 0.6).samples.col(0);
    const auto at = static_cast<Eigen::Index>(time_s * standing.sample_rate_hz);
    EXPECT_LE((walking - there).segment(at - 20, 41).cwiseAbs().maxCoeff(),
              0.02 * there.segment(at - 200, 401).cwiseAbs().maxCoeff() + 1e-9 * peak)
        << time_s;
    const double level_there = std::abs(there.cwiseAbs().sum());
    most = std::max(most, level_there);
    least = std::min(least, level_there);
  }
  EXPECT_GT(most, 1.3 * least);  // it matters where he is
}

// The lowest mode of a free steel ball of 40 mm: x = 2.50 of its shear speed over its radius, some 63 kHz.
TEST(SceneSound, ABodyWithoutAModeInTheBandIsSilentAndSaidUnlessItsModesWereAskedFor) {
  const auto scene_with = [](const std::string& sound) {
    return parse_scene(
        kMaterials +
            "[[body]]\nname = \"ball\"\nmaterial = \"chime\"\nshape = { kind = \"sphere\", radius_m = 0.02 }\n" +
            "position_m = [0, 0, 0.12]\nsound = \"" + sound + "\"\n",
        "ball.toml");
  };
  std::vector<std::string> said;
  SceneNotes notes;
  notes.warning = [&](const std::string& text) { said.push_back(text); };
  const Scene silent = scene_with("auto");
  EXPECT_FALSE(sound_model_of(silent, silent.bodies[0], notes).has_value());
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0], "body ball is silent: it has no mode in the band, 20 to 1000 Hz");
  const Scene asked = scene_with("modes");
  EXPECT_THROW(sound_model_of(asked, asked.bodies[0]), InputError);
}

// A piece is known by its surface alone, and a coarse mesh of it is stiffer than it is (its fifth mode by more than 1 %).
TEST(SceneSound, APieceRingsWithinAThousandthOfTheExactBox) {
  Scene scene = parse_scene(
      kMaterials +
          "[[body]]\nname = \"half\"\nmaterial = \"chime\"\nshape = { kind = \"box\", length_m = 0.1, width_m = 0.05, "
          "height_m = 0.008 }\nposition_m = [0, 0, 0.1]\n",
      "half.toml");
  scene.sound.high_hz = 16000.0;
  const auto exact = sound_model_of(scene, scene.bodies[0]);
  const auto piece = sound_model_of(scene, scene.bodies[0], "half/1",
                                    mesh::boundary_surface(test::lattice({1, 1, 1}, {0.1, 0.05, 0.008})));
  ASSERT_TRUE(exact && piece);
  ASSERT_GE(exact->modes.n_modes(), 3);
  ASSERT_EQ(exact->modes.n_modes(), piece->modes.n_modes());
  for (Eigen::Index m = 0; m < exact->modes.n_modes(); ++m)
    EXPECT_LE(std::abs(piece->modes.frequency_hz()[m] / exact->modes.frequency_hz()[m] - 1.0), 1e-3) << m;
  ASSERT_TRUE(piece->mesh_error.has_value());
  EXPECT_GT(*piece->mesh_error, 1e-3);  // it was no fine mesh
}

// A bar that is slit along half its length is a fork: its prongs swing against each other at some less than a clamped bar of their size
// does (the root gives), which the whole bar does not. What is pushed apart at the slit's lips rings so, what is pushed along does not.
/// The surface of a box from 0 to the last of each axis' rising corners.
mesh::SurfaceMesh ruled_box(const std::array<std::vector<double>, 3>& corners) {
  std::map<std::array<std::size_t, 3>, int> number;
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  const auto vertex = [&](const std::array<std::size_t, 3>& at) {
    const auto [it, is_new] = number.emplace(at, static_cast<int>(vertices.size()));
    if (is_new) vertices.emplace_back(corners[0][at[0]], corners[1][at[1]], corners[2][at[2]]);
    return it->second;
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const std::size_t end : {std::size_t{0}, corners[axis].size() - 1})
      for (std::size_t j = 0; j + 1 < corners[v].size(); ++j)
        for (std::size_t i = 0; i + 1 < corners[u].size(); ++i) {
          const auto at = [&](std::size_t along_u, std::size_t along_v) {
            std::array<std::size_t, 3> place{};
            place[axis] = end;
            place[u] = along_u;
            place[v] = along_v;
            return vertex(place);
          };
          const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          for (const Eigen::Vector3i& t : {Eigen::Vector3i(a, b, c), Eigen::Vector3i(a, c, d)})
            triangles.push_back(end > 0 ? t : Eigen::Vector3i(t[0], t[2], t[1]));
        }
  }
  mesh::SurfaceMesh surface;
  surface.vertices_m.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t k = 0; k < vertices.size(); ++k)
    surface.vertices_m.row(static_cast<Eigen::Index>(k)) = vertices[k].transpose();
  surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t k = 0; k < triangles.size(); ++k)
    surface.triangles.row(static_cast<Eigen::Index>(k)) = triangles[k].transpose();
  return surface;
}

TEST(SceneSound, SliversOfAPieceAreSmoothedAndThatIsSaid) {
  std::vector<std::string> said;
  SceneNotes notes;
  notes.warning = [&](const std::string& text) { said.push_back(text); };
  Scene scene = parse_scene(kMaterials +
                                "[[body]]\nname = \"half\"\nmaterial = \"chime\"\n"
                                "shape = { kind = \"box\", length_m = 0.15, width_m = 0.02, height_m = 0.01 }\n",
                            "half.toml");
  scene.sound.high_hz = 3000.0;
  const std::vector<double> across{0.0, 0.005, 0.01, 0.015, 0.02}, high{0.0, 0.005, 0.01};
  std::vector<double> along;
  for (int i = 0; i <= 30; ++i) along.push_back(0.005 * i);
  const auto even = sound_model_of(scene, scene.bodies[0], "even", ruled_box({along, across, high}), notes);
  EXPECT_TRUE(said.empty());
  along.insert(along.begin() + 8, 0.035 + 1e-6);  // a strip a micrometre wide around it
  const auto ruled = sound_model_of(scene, scene.bodies[0], "ruled", ruled_box({along, across, high}), notes);
  ASSERT_EQ(said.size(), 1U);
  EXPECT_NE(said[0].find("slivers"), std::string::npos) << said[0];
  ASSERT_TRUE(even && ruled);
  ASSERT_EQ(even->modes.n_modes(), ruled->modes.n_modes());
  for (Eigen::Index k = 0; k < even->modes.n_modes(); ++k)
    EXPECT_NEAR(ruled->modes.frequency_hz()[k] / even->modes.frequency_hz()[k], 1.0, 2e-3) << k;
}

TEST(SceneSound, APieceWithASlitRingsAsAFork) {
  const Scene scene = parse_scene(
      kMaterials +
          "[[body]]\nname = \"bar\"\nmaterial = \"chime\"\nshape = { kind = \"box\", length_m = 0.2, width_m = 0.01, "
          "height_m = 0.01 }\nposition_m = [0, 0, 0.1]\n",
      "fork.toml");
  SceneBody body = scene.bodies[0];
  Scene wide = scene;
  wide.sound.high_hz = 3000.0;
  const mesh::TetMesh whole = test::lattice({40, 2, 2}, {0.2, 0.01, 0.01});
  const mesh::TetMesh slit = test::slit_at(whole, 0.005, 0.1);
  const solid::Material& chime = scene.material_of(body).elastic;
  const double thick_m = 0.005, long_m = 0.1;
  const double clamped_hz = 1.8751 * 1.8751 / (2.0 * kPi) * thick_m / (std::sqrt(12.0) * long_m * long_m) *
                            std::sqrt(chime.youngs_modulus_pa() / chime.density_kg_m3);
  const auto near_clamped = [&](const SoundModel& model) {
    std::vector<Eigen::Index> found;
    for (Eigen::Index m = 0; m < model.modes.n_modes(); ++m)
      if (const double f = model.modes.frequency_hz()[m]; f > 0.85 * clamped_hz && f < clamped_hz) found.push_back(m);
    return found;
  };
  std::string warned;
  SceneNotes notes;
  notes.warning = [&](const std::string& text) { warned += text; };
  const auto fork = sound_model_of(wide, body, "fork", slit, notes),
             bar = sound_model_of(wide, body, "bar", whole, notes);
  ASSERT_TRUE(fork && bar);
  EXPECT_EQ(warned, "");
  EXPECT_TRUE(near_clamped(*bar).empty());
  const std::vector<Eigen::Index> prongs = near_clamped(*fork);
  ASSERT_FALSE(prongs.empty());
  ASSERT_EQ(static_cast<Eigen::Index>(fork->transfer.modes.size()), fork->modes.n_modes());
  for (const acoustics::ModeTransfer& mode : fork->transfer.modes) EXPECT_GT(mode.radiated_power_w, 0.0);
  const stage::ModalPush push = stage::push_at_nearest_node(fork->modes);
  const Eigen::Vector3d above(0.2, 0.005, 0.0050001), below(0.2, 0.005, 0.0049999), up(0.0, 0.0, 1.0);
  double apart = 0.0, along = 0.0;
  for (const Eigen::Index m : prongs) {
    apart = std::max(apart, std::abs((push(above, up) - push(below, up))[m]));
    along = std::max(along, std::abs((push(above, up) + push(below, up))[m]));
  }
  EXPECT_GT(apart, 20.0 * along);
}

TEST(SceneSound, AMaterialWithoutDampingIsHeardWithALossFactorOfAThousandthAndSaid) {
  const std::string damping = "damping = { model = \"rayleigh\", rayleigh_stiffness_s = 1e-7 }\n";
  std::string text = kMaterials + "[[body]]\nname = \"D\"\nmaterial = \"chime\"\nposition_m = [0, 0, 0.12]\n" +
                     "shape = { kind = \"tube\", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }\n";
  text.erase(text.find(damping), damping.size());
  const Scene scene = parse_scene(text, "chime.toml");
  std::vector<std::string> said;
  SceneNotes notes;
  notes.warning = [&](const std::string& words) { said.push_back(words); };
  warn_of_assumed_damping(scene, notes);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0], "no damping was measured (material chime): a loss factor of 1/1000 is assumed");
  const HeardBody body = heard(scene)[0];
  const Eigen::VectorXd decay = decay_per_s(body, false);
  const Eigen::VectorXd expected = 0.5e-3 * body.model->modes.angular_frequency_rad_s;
  EXPECT_LE((decay - expected).norm(), 1e-12 * expected.norm());
}

/// A steel bar upright, struck at its upper end by a ball; more: what keeps it.
Scene struck_bar(const std::string& more, const std::string& edge_m = "0.02") {
  return parse_scene(
      "duration_s = 0.008\n[solver]\nrate_hz = 20000\n[world]\ngravity_m_s2 = [0, 0, 0]\n[sound]\nband_hz = [20, "
      "4000]\n"
      "[[material]]\nname = \"steel\"\nyoungs_modulus_pa = 210e9\npoissons_ratio = 0.3\ndensity_kg_m3 = 7850\n"
      "[[material]]\nname = \"rubber\"\nyoungs_modulus_pa = 1e8\npoissons_ratio = 0.4\ndensity_kg_m3 = 1500\n"
      "[[body]]\nname = \"bar\"\nmaterial = \"steel\"\nmodel = \"modal\"\nmax_edge_m = " +
          edge_m +
          "\n"
          "shape = { kind = \"box\", length_m = 0.02, width_m = 0.01, height_m = 0.2 }\n"
          "[[body]]\nname = \"ball\"\nmaterial = \"rubber\"\nsound = \"none\"\n"
          "shape = { kind = \"sphere\", radius_m = 0.005 }\nposition_m = [0, 0.01001, 0.09]\n"
          "velocity_m_s = [0, -1, 0]\n[modal]\nn_modes = 12\n" +
          more,
      "bar.toml");
}

// 0.5596 is (k L)^2 / 2 pi of a clamped bar's first bending; shear and turning sections lower it by 0.2 %.
TEST(SceneSound, AModalBarThatIsClampedIsHeardByItsClampedModesWithTheEnergyThatItMovesWith) {
  const Scene scene =
      struck_bar("[[hold]]\nbody = \"bar\"\nwhere = \"z=min\"\nkind = \"position\"\ncsv = \"" + still_csv() + "\"\n");
  const SceneMotion motion = move(scene);
  const modal::ModalModel modes = sound_model_of(scene, scene.bodies[0]).value().modes;
  const double bernoulli_hz = 0.5596 * std::sqrt(210e9 / 7850.0 / 12.0) * 0.01 / (0.2 * 0.2);
  EXPECT_LE(std::abs(modes.frequency_hz()[0] / bernoulli_hz - 1.0), 0.01);
  Eigen::VectorXcd swing = Eigen::VectorXcd::Zero(modes.n_modes());  // v + i w q, turned back to time 0
  for (const events::Impulse& row : motion.log.impulses) {
    if (row.body != 0) continue;
    Eigen::Index node = 0;
    (modes.mesh.nodes_m.rowwise() - row.point_m.transpose()).rowwise().squaredNorm().minCoeff(&node);
    const double time_s = row.time_s + (row.shape == events::PulseShape::kHeld ? 0.5 * row.duration_s : 0.0);
    for (Eigen::Index k = 0; k < modes.n_modes(); ++k)
      swing[k] += modes.shapes.col(k).segment<3>(3 * node).dot(row.impulse_n_s) *
                  std::polar(1.0, -modes.angular_frequency_rad_s[k] * time_s);
  }
  const double ball_j = 0.5 * motion.mass_kg[1] * motion.final[1].velocity_m_s.squaredNorm();
  const double moves_j = motion.ledger.back().kinetic_j + motion.ledger.back().strain_j - ball_j;
  EXPECT_GT(moves_j, 0.03 * motion.ledger.front().kinetic_j);
  EXPECT_LE(std::abs(0.5 * swing.squaredNorm() / moves_j - 1.0), 0.05);
}

TEST(SceneSound, AModalBarThatIsJoinedToTheWorldIsHeardAsOneThatIsPinned) {
  const Scene scene = struck_bar("[[joint]]\nbody = \"bar\"\nat_m = [0, 0, -0.1]\n", "0.005");  // a corner on the axis
  const modal::ModalModel modes = sound_model_of(scene, scene.bodies[0]).value().modes;
  // A bar pinned at one end and free at the other: (k L)^2 = 15.4182 for its first bending.
  const double bernoulli_hz = 15.4182 / (2.0 * kPi) * std::sqrt(210e9 / 7850.0 / 12.0) * 0.01 / (0.2 * 0.2);
  EXPECT_LE(std::abs(modes.frequency_hz()[0] / bernoulli_hz - 1.0), 0.02);
}

TEST(SceneSound, SoundOfTwoBodiesIsTheSumOfEach) {
  std::string toml = kMaterials;
  for (const char* name : {"a", "b"})
    toml += std::string("[[body]]\nname = \"") + name +
            "\"\nmaterial = \"chime\"\nshape = { kind = \"box\", length_m = 0.3, width_m = 0.04, height_m = 0.01 "
            "}\nposition_m = [" +
            (name[0] == 'a' ? "-0.4" : "0.4") + ", 0, 0.1]\nrotation_deg = [10, 5, 0]\n";
  const Scene scene = parse_scene(toml, "two.toml");
  const SceneMotion motion = move(scene, 0.3);
  const std::vector<HeardBody> bodies = heard(scene);
  const Eigen::MatrixXd both = sound_of(motion.log, bodies, scene.sound, 0.3).samples;
  const Eigen::MatrixXd sum = sound_of(motion.log, {bodies[0]}, scene.sound, 0.3).samples +
                              sound_of(motion.log, {bodies[1]}, scene.sound, 0.3).samples;
  EXPECT_LE((both - sum).cwiseAbs().maxCoeff(), 1e-12 * both.cwiseAbs().maxCoeff());
  EXPECT_EQ(sound_model_numbers(scene)[0], sound_model_numbers(scene)[1]);
}

}  // namespace
}  // namespace klang::scene
