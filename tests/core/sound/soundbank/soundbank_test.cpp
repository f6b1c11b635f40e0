#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "tests/core/sound/soundbank/small_bank.hpp"

using namespace klang;
namespace sb = klang::soundbank;

namespace {

class BankFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("klang_bank_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    path_ = folder_ / "a.bank";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void expect_refused(const std::string& word) const {
    try {
      sb::read_soundbank(path_);
      FAIL() << "not refused";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
  std::filesystem::path folder_, path_;
};

}  // namespace

TEST(Soundbank, UnseenEllipsoidsHaveTheirFrequenciesWithinTheTolerance) {
  const sb::Soundbank& bank = test::small_bank();
  const sb::ProxyFinder finder(bank);
  double state = 0.37;  // shapes of an irrational rotation: none that the build drew
  for (int i = 0; i < 15; ++i) {
    const auto draw = [&] { return state = std::fmod(state + 0.7548776662466927 + 1e-3 * i, 1.0); };
    double u = std::log(0.5) * draw(), v = std::log(0.5) * draw();
    if (v < u) std::swap(u, v);
    const Eigen::Vector3d axes = sb::unit_axes({u, v});
    const sb::EllipsoidModes direct(axes, test::glass(), {8, 12});
    const auto ids = direct.lowest(4);
    const double lowest_hz = direct.angular_frequency_rad_s(ids[0]) / (2.0 * kPi);
    const sb::Proxy proxy = finder.of_axes(axes, lowest_hz);
    EXPECT_LE(std::abs(proxy.scale - 1.0), bank.tolerance);
    const Eigen::VectorXd hz = sb::proxy_frequencies_hz(bank, proxy, 4);
    for (int k = 0; k < 4; ++k)
      EXPECT_LE(std::abs(hz[k] * proxy.scale * 2.0 * kPi / direct.angular_frequency_rad_s(ids[k]) - 1.0),
                bank.tolerance);
    EXPECT_LE(std::abs(hz[0] / lowest_hz - 1.0), 1e-12);
  }
  EXPECT_LE(bank.max_interpolation_error, bank.tolerance);
  EXPECT_GT(bank.max_interpolation_error, 0.0);
}

TEST(Soundbank, IsTheSameOnAnyNumberOfThreads) {
  sb::BuildOptions options = test::small_options();
  options.radiation = true;
  options.modes_per_cell = options.n_checked_modes = 2;
  options.thinnest = 0.7;
  const auto folder = std::filesystem::temp_directory_path() / ("klang_bank_threads_" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  std::string first;
  for (const int threads : {1, 2}) {
    set_thread_count(threads);
    sb::write_soundbank(folder / "b", sb::build_soundbank(options).bank);
    const std::string bytes = read_file(folder / "b");
    if (first.empty()) first = bytes;
    EXPECT_TRUE(bytes == first);
  }
  set_thread_count(0);
  std::filesystem::remove_all(folder);
}

TEST(Soundbank, StoppedBuildGoesOnAndEndsTheSame) {
  struct StopAfter : Monitor {
    mutable int left = 40;
    bool stop_requested() const override { return --left < 0; }
  } stop;
  sb::BuildProgress saved;
  EXPECT_THROW(sb::build_soundbank(test::small_options(), stop, {}, [&](const sb::BuildProgress& p) { saved = p; }),
               Interrupted);
  ASSERT_FALSE(saved.frequencies.empty());
  const std::size_t known = saved.frequencies.size();
  const sb::BuildResult whole = sb::build_soundbank(test::small_options());
  const sb::BuildResult rest = sb::build_soundbank(test::small_options(), silent_monitor(), saved);
  EXPECT_EQ(rest.n_eigen_solves + static_cast<int>(known), whole.n_eigen_solves);
  ASSERT_EQ(rest.bank.cells.size(), whole.bank.cells.size());
  EXPECT_EQ(rest.bank.max_interpolation_error, whole.bank.max_interpolation_error);
}

TEST(Soundbank, SlopesOfTheInterpolationAreItsDifferences) {
  const sb::Soundbank& bank = test::small_bank();
  const sb::ShapePoint at{-0.41, -0.13};
  const double h = 1e-6;
  const auto slopes = sb::node_weight_slopes(bank, sb::locate(bank, at));
  const auto value = [&](double u, double v) {
    const sb::ShapePlace place = sb::locate(bank, {u, v});
    const auto& t = bank.triangles[place.triangle];
    const auto weights = sb::node_weights(place.weights);
    double sum = 0.0;
    for (int i = 0; i < 6; ++i) sum += weights[i] * std::log(bank.node_frequencies[t.nodes[i]][1][0]);
    return sum;
  };
  const auto& t = bank.triangles[sb::locate(bank, at).triangle];
  Eigen::Vector2d found = Eigen::Vector2d::Zero();
  for (int i = 0; i < 6; ++i) found += slopes.row(i).transpose() * std::log(bank.node_frequencies[t.nodes[i]][1][0]);
  const Eigen::Vector2d wanted((value(at.u + h, at.v) - value(at.u - h, at.v)) / (2 * h),
                               (value(at.u, at.v + h) - value(at.u, at.v - h)) / (2 * h));
  EXPECT_GT(wanted.norm(), 0.1);
  EXPECT_LE((found - wanted).norm(), 1e-7 * wanted.norm() + 1e-8);
}

TEST_F(BankFile, ReadsBackEveryBit) {
  sb::write_soundbank(path_, test::small_bank());
  const std::string bytes = read_file(path_);
  const sb::Soundbank back = sb::read_soundbank(path_);
  EXPECT_EQ(back.cells.size(), test::small_bank().cells.size());
  EXPECT_EQ(back.max_interpolation_error, test::small_bank().max_interpolation_error);
  sb::write_soundbank(path_, back);
  EXPECT_TRUE(read_file(path_) == bytes);
}

TEST_F(BankFile, TruncatedDamagedNewerAndForeignFilesAreRefused) {
  sb::write_soundbank(path_, test::small_bank());
  const std::string bytes = read_file(path_);
  write_file(path_, std::string_view(bytes).substr(0, bytes.size() - 1));
  expect_refused("truncated");
  write_file(path_, std::string_view(bytes).substr(0, 20));
  expect_refused("no soundbank");
  std::string damaged = bytes;
  damaged[bytes.size() - 200] = static_cast<char>(damaged[bytes.size() - 200] ^ 1);
  write_file(path_, damaged);
  expect_refused("no whole soundbank");
  std::string newer = bytes;
  newer[8] = 2;
  write_file(path_, newer);
  expect_refused("newer version");
  for (const auto& [what, change] : std::vector<std::pair<const char*, void (*)(sb::Soundbank&)>>{
           {"degree", [](sb::Soundbank& b) { b.degree = 1000000; }},
           {"none of its class", [](sb::Soundbank& b) { b.cells[0].modes[0].id.index = 1000000000; }},
           {"shape of a mode", [](sb::Soundbank& b) { b.cells[0].modes[0].coefficients.resize(1); }},
           {"frequency of a mode",
            [](sb::Soundbank& b) { b.cells[0].modes[0].angular_frequency_rad_s = std::nan(""); }},
           {"a frequency", [](sb::Soundbank& b) { b.node_frequencies[1][2][0] = 1e300; }},
           {"no shape", [](sb::Soundbank& b) { b.nodes[0].u = std::nan(""); }},
           {"Poisson", [](sb::Soundbank& b) { b.poissons_ratio = 0.3; }},
           {"tree", [](sb::Soundbank& b) {
              b.triangles[0].children = {0, 0};
            }}}) {
    sb::Soundbank bank = test::small_bank();
    change(bank);
    sb::write_soundbank(path_, bank);
    expect_refused(what);
  }
  std::string header = bytes;
  const std::size_t kind = header.find("\"soundbank\"");
  ASSERT_NE(kind, std::string::npos);
  write_file(path_, header.replace(kind, 11, "12345678901"));
  expect_refused("another kind");
  write_file(path_, "RIFF....WAVE and much more of a sound that is no bank at all");
  expect_refused("no soundbank");
}

TEST_F(BankFile, OtherPoissonsRatioIsRefused) {
  EXPECT_THROW(sb::check_poissons_ratio(test::small_bank(), 0.3, "body"), InputError);
  EXPECT_NO_THROW(sb::check_poissons_ratio(test::small_bank(), 0.2, "body"));
}
