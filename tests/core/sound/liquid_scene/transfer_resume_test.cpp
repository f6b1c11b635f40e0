#include <gtest/gtest.h>

#include <sys/resource.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/sealed_file.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;

/// Water to half of a tank, its surface swings; a ball hangs in it. Cells do not take it where walls lean.
class SwingingFrames : public liquid::LiquidFrames {
 public:
  SwingingFrames(std::size_t n, bool leans) : lean_(leans ? 0.2 : 0.0) {
    for (std::size_t k = 0; k < n; ++k) times_.push_back(0.01 * static_cast<double>(k));
  }
  std::span<const double> time_s() const override { return times_; }
  liquid::LiquidSurface boundary(std::size_t frame) const override {
    const liquid::GridShape shape{12, 12, 12, cell_m()};
    liquid::Field phi(12, 12, 12), solid(12, 12, 12);
    for (int k = 0; k < 12; ++k)
      for (int j = 0; j < 12; ++j)
        for (int i = 0; i < 12; ++i) {
          const Vector3d x = shape.centre_m(i, j, k);
          phi(i, j, k) = phi_m(frame, {x.x() + lean_ * x.z(), x.y(), x.z()});
          solid(i, j, k) = (shape.centre_m(i, j, k) - Vector3d(0.06, 0.12, 0.05)).norm() - 0.03;
        }
    liquid::LiquidSurface surface = liquid::liquid_surface(shape, phi, solid);
    surface.surface.vertices_m.col(0) += lean_ * surface.surface.vertices_m.col(2);
    return surface;
  }
  double phi_m(std::size_t frame, const Vector3d& x) const override {
    return x.z() - 0.09 -
           0.01 * std::sin(0.9 * static_cast<double>(frame)) * std::cos(kPi * (x.x() - lean_ * x.z()) / 0.18);
  }
  std::optional<Vector3d> velocity_m_s(std::size_t, const Vector3d&) const override { return Vector3d(0, 0, 0); }
  double cell_m() const override { return 0.015; }

 private:
  const double lean_;
  std::vector<double> times_;
};

LiquidScene scene() {
  return parse_liquid_scene(
      "[domain]\nsize_m = [0.18, 0.18, 0.18]\ncell_m = 0.015\nduration_s = 0.2\n[[pool]]\ndepth_m = 0.09\n"
      "[transfer]\nbins_per_octave = 2\n[listener]\nmode = \"mono\"\nposition_m = [0.09, -0.4, 0.5]\n",
      "scene.toml", ".");
}

entrainment::BubblePath path(std::int64_t id, double birth_s, double frequency_hz, const Vector3d& place) {
  entrainment::BubblePath path;
  path.id = id;
  path.radius_m = 3.26 / frequency_hz;
  path.time_s = {birth_s, birth_s + 0.1};
  path.position_m = {place, place + Vector3d(0, 0, 0.005)};
  path.phi_m = {-0.04, -0.035};
  path.frequency_hz = {frequency_hz, 1.05 * frequency_hz};
  return path;
}

bool same(const LiquidTransfer& a, const LiquidTransfer& b) {
  if (a.rows.size() != b.rows.size() || a.n_solves != b.n_solves || a.n_iterations != b.n_iterations ||
      a.n_airs != b.n_airs || a.errors.size() != b.errors.size() || a.modes_hz != b.modes_hz)
    return false;
  for (std::size_t i = 0; i < a.rows.size(); ++i) {
    if (a.rows[i].size() != b.rows[i].size()) return false;
    for (std::size_t r = 0; r < a.rows[i].size(); ++r)
      if (a.rows[i][r].time_s != b.rows[i][r].time_s ||
          a.rows[i][r].pressure_pa_per_m != b.rows[i][r].pressure_pa_per_m)
        return false;
  }
  for (std::size_t i = 0; i < a.errors.size(); ++i)
    if (a.errors[i].relative != b.errors[i].relative) return false;
  return true;
}

class TransferResume : public ::testing::TestWithParam<bool> {};

TEST_P(TransferResume, FromAnyFrameGivesTheSameBitsOnOneThreadOrTwo) {
  const SwingingFrames frames(GetParam() ? 7 : 13, GetParam());
  const LiquidScene of = scene();
  const std::vector<entrainment::BubblePath> paths = {path(1, 0.0, 800.0, {0.05, 0.06, 0.04}),
                                                      path(2, 0.03, 2500.0, {0.1, 0.12, 0.05}),
                                                      path(3, 0.07, 1100.0, {0.12, 0.05, 0.06})};
  std::vector<TransferCheckpoint> kept;
  TransferKeep keep;
  keep.due = [] { return true; };
  keep.keep = [&](TransferCheckpoint now) { kept.push_back(std::move(now)); };
  set_thread_count(2);
  const LiquidTransfer whole = find_transfer(&frames, paths, of, 1, silent_monitor(), keep);
  ASSERT_EQ(kept.size(), frames.time_s().size());
  EXPECT_EQ(kept.back().by_cells, !GetParam());
  EXPECT_GE(whole.n_solves, 10);
  EXPECT_GE(whole.n_airs, 2);
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / ("transfer_resume_" + std::to_string(GetParam()));
  const std::string key(64, 'a');
  set_thread_count(1);
  for (const std::size_t k : {std::size_t{1}, kept.size() / 2, kept.size() - 2}) {
    write_transfer_checkpoint(file, key, kept[k]);
    EXPECT_FALSE(read_transfer_checkpoint(file, std::string(64, 'b')).has_value());
    TransferKeep from;
    from.from = read_transfer_checkpoint(file, key);
    ASSERT_TRUE(from.from.has_value());
    EXPECT_EQ(from.from->next_frame, k + 1);
    EXPECT_TRUE(same(find_transfer(&frames, paths, of, 1, silent_monitor(), std::move(from)), whole)) << k;
  }
  set_thread_count(0);
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 5);
  EXPECT_THROW(read_transfer_checkpoint(file, key), InputError);
  std::filesystem::remove(file);
  EXPECT_FALSE(read_transfer_checkpoint(file, key).has_value());
}

long most_kib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

/// Where a reader sees that bytes are not what they were: by the seal; a sealed file that lies, by what it has room for.
TEST(TransferCheckpointFile, DamagedBytesAreRefusedBeforeMemoryIsAskedFor) {
  TransferCheckpoint checkpoint;
  checkpoint.found.rows = {{{0.1, 440.0, {1.0, 2.0}}}, {}, {{0.2, 441.0, {3.0, 4.0}}, {0.3, 442.0, {5.0, 6.0}}}};
  checkpoint.found.errors = {{500.0, 0.1, 0.1, 0.2, 0.3, 0.4}};
  checkpoint.found.bad_frame = "a frame";
  checkpoint.found.modes_hz = {1248.0};
  checkpoint.cells.q[7] = Eigen::MatrixXcd::Constant(5, 1, 1.0);
  checkpoint.cells.n_cells = 100;
  checkpoint.cells.wet = {3, 4, 5};
  checkpoint.cells.waves[2] = {440.0, {1.0F, 2.0F, 3.0F}};
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "transfer_damaged";
  const std::string key(64, 'a');
  write_transfer_checkpoint(file, key, checkpoint);
  const std::string whole = read_file(file);
  const std::size_t n_head = 8 + 8 + key.size(), n_seal = 40;
  for (std::size_t at = n_head; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ 0x10);
    write_file(file, bytes);
    EXPECT_THROW(read_transfer_checkpoint(file, key), InputError) << at;
  }
  const long before_kib = most_kib();
  int n_refused = 0;
  for (std::size_t at = 8; at + 8 + n_seal <= whole.size(); ++at)
    for (const std::uint64_t lie : {std::uint64_t{1} << 62, std::uint64_t{999'999'999}, std::uint64_t{whole.size()}}) {
      std::string bytes = whole.substr(0, whole.size() - n_seal);
      std::memcpy(bytes.data() + at, &lie, sizeof lie);
      write_file(file, bytes);
      seal_file(file);
      try {
        read_transfer_checkpoint(file, key);
      } catch (const InputError&) {
        ++n_refused;
      }
    }
  EXPECT_GE(n_refused, 100);
  EXPECT_LE(most_kib() - before_kib, 100 * 1024);
  std::filesystem::remove(file);
}

INSTANTIATE_TEST_SUITE_P(CellsAndWavesAboutTheCentre, TransferResume, ::testing::Bool());

}  // namespace
}  // namespace klang::liquid_scene
