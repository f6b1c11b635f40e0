#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/bem/radiating_surface.hpp"
#include "core/sound/liquid_scene/bubbles_stage.hpp"
#include "core/sound/liquid_scene/from_recording.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"
#include "core/sound/liquid_scene/sound_stage.hpp"
#include "core/sound/liquid_scene/thick_part.hpp"
#include "core/sound/liquid_scene/transfer_stage.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;

/// A ball of liquid at rest, for a tenth of a second; drops beside it.
class BallFrames : public liquid::LiquidFrames {
 public:
  explicit BallFrames(bool with_drop = false) {
    for (int i = 0; i < 11; ++i) times_.push_back(0.01 * i);
    surface_.surface = acoustics::geodesic_sphere(0.05, 6);
    if (with_drop) {
      const mesh::SurfaceMesh drop = acoustics::geodesic_sphere(0.01, 2);
      const auto n = surface_.surface.vertices_m.rows(), m = surface_.surface.triangles.rows();
      surface_.surface.vertices_m.conservativeResize(n + drop.vertices_m.rows(), 3);
      surface_.surface.vertices_m.bottomRows(drop.vertices_m.rows()) =
          drop.vertices_m.rowwise() + Eigen::RowVector3d(0.2, 0.0, 0.0);
      surface_.surface.triangles.conservativeResize(m + drop.triangles.rows(), 3);
      surface_.surface.triangles.bottomRows(drop.triangles.rows()) = drop.triangles.array() + static_cast<int>(n);
    }
    surface_.region.assign(static_cast<std::size_t>(surface_.surface.triangles.rows()), 0);
  }
  std::span<const double> time_s() const override { return times_; }
  liquid::LiquidSurface boundary(std::size_t) const override { return surface_; }
  double phi_m(std::size_t, const Vector3d& x) const override { return x.norm() - 0.05; }
  std::optional<Vector3d> velocity_m_s(std::size_t, const Vector3d&) const override { return Vector3d(0, 0, 0); }
  double cell_m() const override { return 0.01; }

 private:
  std::vector<double> times_;
  liquid::LiquidSurface surface_;
};

LiquidScene scene_of(const std::string& method) {
  return parse_liquid_scene(
      "[domain]\nsize_m = [0.16, 0.16, 0.16]\ncell_m = 0.02\nduration_s = 0.1\n[[pool]]\ndepth_m = 0.1\n"
      "[transfer]\nmethod = \"" +
          method + "\"\nliquid_loss_factor = 0.0\n[listener]\nmode = \"mono\"\nposition_m = [0.3, 0.2, 0.4]\n",
      "scene.toml", ".");
}

entrainment::BubblePath central(double frequency_hz) {
  entrainment::BubblePath path;
  path.id = 1;
  path.radius_m = 2e-3;
  path.time_s = {0.0, 0.1};
  path.position_m = {Vector3d(0, 0, 0), Vector3d(0, 0, 0)};
  path.phi_m = {-0.05, -0.05};
  path.frequency_hz = {frequency_hz, frequency_hz};
  return path;
}

TEST(LiquidTransfer, OfACentralBubbleIsTheClosedFormAtItsPitchByBothMethods) {
  const BallFrames frames;
  const double f = 1640.0, omega = 2.0 * kPi * f, kf = omega / 1497.0, ka = omega / 343.0, a = 0.05;
  const double distance = Vector3d(0.3, 0.2, 0.4).norm();
  for (const char* method : {"reciprocal", "forward"}) {
    const LiquidScene scene = scene_of(method);
    const LiquidTransfer found = find_transfer(&frames, {central(f)}, scene, 1, silent_monitor());
    EXPECT_GE(found.n_solves, 4);  // frames until a hundredth of the amplitude
    ASSERT_TRUE(found.error_estimate().has_value());
    EXPECT_LE(*found.error_estimate(), 0.05);
    const bubble::TransferSeries series(found.rows[0], "rows");
    const double radius = bubble::bubble_radius_m(f, scene.sound.medium),
                 strength = 4.0 * kPi * 1000.0 * omega * omega * radius * radius;
    const double exact = 1.2041e-3 * strength * kf / (4.0 * kPi * a * std::sin(kf * a)) * a * a /
                         std::sqrt(1.0 + ka * ka * a * a) / distance;
    for (const double t : {0.0, 0.015, 0.03})
      EXPECT_LE(std::abs(std::abs(series.at(t, f)) / exact - 1.0), 0.03) << method << " " << t;
  }
}

TEST(LiquidTransfer, ErrorsIntervalHoldsTheMedianNineTimesOfTen) {
  LiquidTransfer found;
  const auto checked = [&](int n) {
    found.errors.clear();
    for (int e = 0; e < n; ++e)
      found.errors.push_back({1000.0, static_cast<double>((7 * e) % n)});  // 0 to n - 1, mixed
    return found.error_interval();
  };
  for (const int n : {0, 1, 4}) EXPECT_FALSE(checked(n).has_value()) << n;
  // Ranks of the binomial law of 1/2, 5 % at each end at most: P(X <= 1 of 8) = 0.035, P(X <= 9 of 26) = 0.084, P(X <= 8) = 0.038.
  EXPECT_EQ(checked(5), (std::array{0.0, 4.0}));
  EXPECT_EQ(checked(8), (std::array{1.0, 6.0}));
  EXPECT_EQ(checked(26), (std::array{8.0, 17.0}));
  EXPECT_EQ(found.error_estimate(), 13.0);
}

TEST(LiquidTransfer, HalfSpaceNeedsNoFramesAndUnitNoRows) {
  const LiquidTransfer half = find_transfer(nullptr, {central(1640.0)}, scene_of("half_space"), 1, silent_monitor());
  EXPECT_EQ(half.n_solves, 0);
  EXPECT_FALSE(half.rows[0].empty());
  EXPECT_TRUE(find_transfer(nullptr, {central(1640.0)}, scene_of("unit"), 1, silent_monitor()).rows[0].empty());
}

TEST(LiquidTransfer, ABubbleInADropBesideTheBodyFallsBackAndIsCounted) {
  const BallFrames frames(true);
  entrainment::BubblePath away = central(1640.0);
  for (Vector3d& x : away.position_m) x.x() = 0.2;
  const LiquidTransfer found = find_transfer(&frames, {away}, scene_of("reciprocal"), 1, silent_monitor());
  EXPECT_EQ(found.n_half_space, 1U);
  EXPECT_EQ(found.n_solves, 0);
  EXPECT_FALSE(found.rows[0].empty());
}

/// A tank with water to half of its height; a jet of one cell of radius that pours into it from the top.
class TankFrames : public liquid::LiquidFrames {
 public:
  explicit TankFrames(bool with_jet) : with_jet_(with_jet) {
    const liquid::GridShape shape{20, 20, 20, kCell_m};
    liquid::Field phi(20, 20, 20);
    for (int k = 0; k < 20; ++k)
      for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 20; ++i) phi(i, j, k) = phi_m(0, shape.centre_m(i, j, k));
    surface_ = liquid::liquid_surface(shape, phi, {});
  }
  std::span<const double> time_s() const override { return times_; }
  liquid::LiquidSurface boundary(std::size_t) const override { return surface_; }
  double phi_m(std::size_t, const Vector3d& x) const override {
    const double jet = (x - Vector3d(0.08, 0.1, x.z())).norm() - kCell_m;
    return with_jet_ ? std::min(x.z() - 0.1, jet) : x.z() - 0.1;
  }
  std::optional<Vector3d> velocity_m_s(std::size_t, const Vector3d&) const override { return Vector3d(0, 0, 0); }
  double cell_m() const override { return kCell_m; }

 private:
  static constexpr double kCell_m = 0.01;
  const bool with_jet_;
  std::vector<double> times_ = {0.0, 0.01};
  liquid::LiquidSurface surface_;
};

TEST(LiquidTransfer, AJetThatStandsOnTheBodyHardlyChangesABubbleBesideIt) {
  entrainment::BubblePath path = central(1640.0);
  for (Vector3d& x : path.position_m) x = Vector3d(0.12, 0.1, 0.07);
  const LiquidScene scene = scene_of("reciprocal");
  const LiquidTransfer alone =
                           find_transfer(std::make_unique<TankFrames>(false).get(), {path}, scene, 1, silent_monitor()),
                       jet =
                           find_transfer(std::make_unique<TankFrames>(true).get(), {path}, scene, 1, silent_monitor());
  ASSERT_FALSE(alone.rows[0].empty());
  ASSERT_EQ(alone.rows[0].size(), jet.rows[0].size());
  for (std::size_t i = 0; i < alone.rows[0].size(); ++i)
    EXPECT_LE(std::abs(jet.rows[0][i].pressure_pa_per_m - alone.rows[0][i].pressure_pa_per_m),
              0.08 * std::abs(alone.rows[0][i].pressure_pa_per_m))
        << i;
  ASSERT_TRUE(jet.error_estimate().has_value());
  EXPECT_LE(*jet.error_estimate(), 0.1);
}

TEST(ThickPart, HoldsThePoolAndNoJetNorABubbleInIt) {
  const TankFrames frames(true);
  const bubble::LiquidBoundary boundary(main_body(frames.boundary(0), frames.cell_m()));
  const ThickPart thick(frames, 0, boundary);
  ASSERT_TRUE(thick.is_body());
  EXPECT_TRUE(thick.holds({0.12, 0.1, 0.095}));
  EXPECT_TRUE(thick.holds({0.08, 0.1, 0.095}));
  EXPECT_FALSE(thick.holds({0.08, 0.1, 0.15}));
  double in_pool = 0.0, pool = 0.0, in_jet = 0.0;
  for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
    const double counts = thick.sample_counts()[static_cast<Eigen::Index>(i)], z = boundary.samples()[i].point_m.z();
    if (z > 0.125) in_jet += counts;
    if (z > 0.1 + 1e-6) continue;
    in_pool += counts;
    ++pool;
  }
  EXPECT_EQ(in_jet, 0.0);
  EXPECT_EQ(in_pool, pool);
}

TEST(MainBody, IsTheLargestWithItsHollowsAndWithoutDrops) {
  const bubble::BoundaryMesh body = main_body(BallFrames(true).boundary(0), 0.01);
  EXPECT_EQ(body.surface.triangles.rows(), 20 * 36);
  EXPECT_LE(std::abs(bubble::LiquidBoundary(body).volume_m3() / (4.0 / 3.0 * kPi * 1.25e-4) - 1.0), 1e-6);
}

TEST(FromRecording, PitchIsTheTwoCombinationsAndWhatDoesNotSayThemIsRefused) {
  const auto file = std::filesystem::temp_directory_path() / ("klang-drops-" + std::to_string(::getpid()) + ".json");
  write_file(file,
             R"({"bubbles": [{"radius_m": 0.001}, {"radius_m": 0.002}], "pitch": {"status": "fitted", "identifiable": [
      {"combination": "eta / |phi0| [1/m]", "value": 155.0}, {"combination": "k_delta * exp(eta) [1/m]", "value": 252.0}]}})");
  EXPECT_EQ(recorded_radii(file), (std::vector<double>{0.001, 0.002}));
  bubble::PitchModel pitch;
  take_recorded_pitch(file, pitch);
  EXPECT_LE(std::abs(pitch.eta / -pitch.phi0_m - 155.0), 1e-9);
  EXPECT_LE(std::abs(pitch.k_delta_per_m * std::exp(pitch.eta) - 252.0), 1e-9);
  pitch.kind = bubble::PitchKind::kStrasberg;
  EXPECT_THROW(take_recorded_pitch(file, pitch), InputError);
  write_file(file, R"({"bubbles": [], "pitch": {"status": "sound_only", "identifiable": []}})");
  pitch.kind = bubble::PitchKind::kHarmonicFluids;
  EXPECT_THROW(take_recorded_pitch(file, pitch), InputError);
  EXPECT_THROW(recorded_radii(file), InputError);
  std::filesystem::remove(file);
}

/// A folder as after the stage bubbles, of one bubble of this pitch, and the sound of it.
TEST(SoundStage, RingsAtThePitchOfThePathAndIsTheSameTwice) {
  const auto path = std::filesystem::temp_directory_path() / ("klang-heard-" + std::to_string(::getpid()));
  std::filesystem::create_directories(path);
  const RunFolder folder(path);
  entrainment::BubblePath rising = central(1500.0);
  rising.time_s = {0.0, 0.01, 0.02, 0.03, 0.1};
  rising.position_m.assign(5, Vector3d(0, 0, 0));
  rising.phi_m.assign(5, -0.05);
  rising.frequency_hz = {1500.0, 1500.0, 1500.0, 1500.0, 1500.0};
  entrainment::write_tracked_bubbles(folder.file("bubbles.trk"), {rising});
  const LiquidScene scene = scene_of("unit");
  std::string first;
  for (int turn = 0; turn < 2; ++turn) {
    RunDocument document;
    document.n_bubbles = 1;
    StageRun run{scene, folder, document, 1, 0.1, 60.0, false, silent_monitor(), [](const std::string&) {}};
    run_transfer(run);
    EXPECT_EQ(document.transfer->method, "unit");
    run_sound(run);
    EXPECT_GT(document.sound->peak_pressure_pa, 0.0);
    const std::string bytes = read_file(folder.file("sound.wav"));
    if (turn == 0) first = bytes;
    EXPECT_EQ(bytes, first);
  }
  const audio::Signal sound = audio::read_sound(folder.file("sound.wav"));
  int n_turns = 0;  // of sign, in 30 ms
  const auto n = static_cast<Eigen::Index>(0.03 * sound.sample_rate_hz);
  for (Eigen::Index i = 1; i < n; ++i) n_turns += sound.samples(i - 1, 0) * sound.samples(i, 0) < 0.0 ? 1 : 0;
  EXPECT_LE(std::abs(n_turns - 90), 1);
  std::filesystem::remove_all(path);
}

}  // namespace
}  // namespace klang::liquid_scene
