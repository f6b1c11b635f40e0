#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/entrainment/entrainment.hpp"
#include "tests/core/physics/entrainment/analytic_frames.hpp"

namespace klang::entrainment {
namespace {

using Eigen::Vector3d;
using test::PoolFrames;

std::vector<double> drawn(const RadiusDistribution& radii, int n) {
  RandomStream random(1, 2);
  std::vector<double> list;
  for (int i = 0; i < n; ++i) list.push_back(radii.draw(random));
  return list;
}
double mean_of(const std::vector<double>& list) {
  return std::accumulate(list.begin(), list.end(), 0.0) / static_cast<double>(list.size());
}

TEST(Radii, OfDeaneAndStokesHaveTheClosedFormsMoments) {
  std::vector<double> list = drawn({}, 200000);  // 0.3 to 5 mm
  EXPECT_LE(std::abs(mean_of(list) / 0.0007569138597257345 - 1.0), 0.005);
  std::sort(list.begin(), list.end());
  EXPECT_LE(std::abs(list[100000] / 0.0005842905852665702 - 1.0), 0.005);
  const auto below = std::lower_bound(list.begin(), list.end(), 1e-3) - list.begin();
  EXPECT_LE(std::abs(static_cast<double>(below) / 2e5 - 0.797806680721576), 0.004);
  EXPECT_GE(list.front(), 3e-4);
  EXPECT_LE(list.back(), 5e-3);
  RadiusDistribution wide;
  wide.smallest_m = 2e-4;
  wide.largest_m = 1e-2;
  EXPECT_LE(std::abs(mean_of(drawn(wide, 200000)) / 0.0006281262303988152 - 1.0), 0.01);
}

TEST(Radii, OfAGaussianStayWithinTheLimits) {
  RadiusDistribution radii;
  radii.kind = RadiusDistribution::Kind::kGaussian;
  radii.mean_m = 1e-3;
  radii.std_m = 5e-4;
  radii.smallest_m = 5e-4;
  radii.largest_m = 1.5e-3;
  const std::vector<double> list = drawn(radii, 50000);
  EXPECT_LE(std::abs(mean_of(list) - 1e-3), 5e-6);
  EXPECT_GE(*std::min_element(list.begin(), list.end()), 5e-4);
  EXPECT_LE(*std::max_element(list.begin(), list.end()), 1.5e-3);
}

TEST(Radii, OfARecordingAreItsOwnSmeared) {
  RadiusDistribution radii;
  radii.kind = RadiusDistribution::Kind::kRecorded;
  radii.recorded_m = {1e-3, 2e-3};
  const std::vector<double> list = drawn(radii, 20000);
  const auto small = std::count_if(list.begin(), list.end(), [](double r) { return r < 1.4142e-3; });
  EXPECT_LE(std::abs(static_cast<double>(small) / 2e4 - 0.5), 0.015);
  radii.recorded_m = {1e-1};
  EXPECT_THROW(radii.validate(), InputError);
}

TEST(Seed, SlopeOfAStepIs6aTimes1MinusA) {
  constexpr int kTimes = 4000;
  constexpr double kWindow_s = 0.008, kJump_m = -0.004;
  for (const double a : {0.2, 0.5, 0.7}) {
    std::vector<double> t, phi;
    for (int i = 0; i < kTimes; ++i) {
      t.push_back(kWindow_s * i / (kTimes - 1.0));
      phi.push_back(t.back() > a * kWindow_s ? kJump_m : 0.0);
    }
    EXPECT_LE(std::abs(regression_slope(t, phi) / (6.0 * a * (1.0 - a) * kJump_m / kWindow_s) - 1.0), 2e-3) << a;
  }
}

TEST(Seed, SlopeOfALineIsExactForUnevenTimes) {
  const std::vector<double> t = {0.0, 0.001, 0.0045, 0.005, 0.008};
  std::vector<double> phi;
  for (const double s : t) phi.push_back(0.01 - 1.7 * s);
  EXPECT_LE(std::abs(regression_slope(t, phi) + 1.7), 1e-12);
}

TEST(Seed, StrengthHasMeanOneHalfAndIsSmoothAtTheMiddle) {
  double sum = 0.0;
  for (int i = 0; i < 10000; ++i) sum += seed_strength((i + 0.5) / 10000.0) / 10000.0;
  EXPECT_LE(std::abs(sum - 0.5), 1e-6);
  EXPECT_LE(std::abs(seed_strength(0.5) - 0.5), 1e-15);
  const double d = 1e-6;
  EXPECT_LE(std::abs((seed_strength(0.5) - seed_strength(0.5 - d)) / d + 3.0), 1e-4);
  EXPECT_LE(std::abs((seed_strength(0.5 + d) - seed_strength(0.5)) / d + 3.0), 1e-4);
  EXPECT_EQ(seed_strength(-0.1), 0.0);
  EXPECT_EQ(seed_strength(1.0), 0.0);
}

/// The surface stands; on one half the liquid sinks at a speed (fed along the surface, which no marker shows).
PoolFrames plunging(double cell_m, double step_s, double seconds, double speed_m_s) {
  return {0.15,
          cell_m,
          step_s,
          static_cast<int>(std::lround(seconds / step_s)) + 1,
          [](double) { return 0.5; },
          [=](double, const Vector3d& x) { return Vector3d(0.0, 0.0, x.x() < 0.075 ? -speed_m_s : 0.0); }};
}

std::size_t n_seeds(const PoolFrames& frames, const SeedOptions& options) {
  SeedFinder finder(frames, options, 1);
  std::size_t n = 0;
  for (std::size_t frame = 0; frame + 1 < frames.time_s().size(); ++frame) n += finder.advance(frame).size();
  return n;
}

TEST(Seed, NoneFromRestTranslationOrSloshing) {
  EXPECT_EQ(n_seeds(PoolFrames(
                        0.3, 0.01, 0.004, 26, [](double) { return 0.5; },
                        [](double, const Vector3d&) { return Vector3d(0, 0, 0); }),
                    {}),
            0U);
  const PoolFrames moving(
      0.15, 0.02, 0.004, 26, [](double) { return 0.5; },
      [](double, const Vector3d&) { return Vector3d(3.0, 1.0, 0.0); });
  EXPECT_EQ(n_seeds(moving, {}), 0U);
  const double omega = 9.7;  // the surface and the liquid below it go up and down together
  const PoolFrames sloshing(
      0.15, 0.02, 0.004, 101, [=](double t) { return 0.5 + 0.05 * std::sin(omega * t); },
      [=](double t, const Vector3d&) { return Vector3d(0.0, 0.0, 0.05 * omega * std::cos(omega * t)); });
  EXPECT_EQ(n_seeds(sloshing, {}), 0U);
}

TEST(Marker, OutlivesItsLayer) {
  // At 2 m/s a marker crosses the layer of 2 cm in 10 ms, less than the window of 12 ms: it is a seed all the same.
  SeedOptions options;
  options.window_s = 0.012;
  EXPECT_GE(n_seeds(plunging(0.01, 0.002, 0.05, 2.0), options), 300U);
  EXPECT_EQ(n_seeds(plunging(0.01, 0.002, 0.05, 1.4), options), 0U);  // slower than the threshold
}

TEST(Seed, OfBodiesThatMergeNeedsSpeedOnlyByTheOtherCriterion) {
  // The surface jumps up by 2 cm at 20 ms, the liquid stands still.
  const PoolFrames merging(
      0.15, 0.01, 0.002, 26, [](double t) { return t < 0.021 ? 0.5 : 0.52; },
      [](double, const Vector3d&) { return Vector3d(0.0, 0.0, 0.0); });
  SeedOptions options;
  EXPECT_GE(n_seeds(merging, options), 300U);
  options.criterion = SeedCriterion::kVelocity;
  EXPECT_EQ(n_seeds(merging, options), 0U);
}

EntrainmentOptions without_rejection(double rate) {
  EntrainmentOptions options;
  options.attempts_per_m2_s = rate;
  options.coverage = 0.0;
  return options;
}

TEST(Births, OfAPatchAreRateTimesAreaTimesTimeOverTwoForAnyStepAndCell) {
  EntrainmentOptions options = without_rejection(1e6);
  options.patches = {{{0.05, 0.02, 0.45}, {0.15, 0.12, 0.55}, 0.1, 0.15}};
  const double expected = 1e6 * 0.01 * 0.05 / 2.0;
  for (const double cell : {0.005, 0.02})
    for (const double step : {0.001, 0.004}) {
      const PoolFrames pool(
          0.15, cell, step, static_cast<int>(std::lround(0.2 / step)) + 1, [](double) { return 0.5; },
          [](double, const Vector3d&) { return Vector3d(0, 0, 0); });
      const Births births = find_births(pool, options, 3);
      EXPECT_LE(std::abs(static_cast<double>(births.births.size()) / expected - 1.0), 0.02) << cell << " " << step;
      for (const Birth& b : births.births) {
        EXPECT_GE(b.time_s, 0.1);
        EXPECT_LE(b.time_s, 0.15);
        EXPECT_GE(b.position_m.x(), 0.05);
        EXPECT_LE(b.position_m.y(), 0.12);
        EXPECT_LE(std::abs(b.position_m.z() - 0.5 + cell), cell);
      }
    }
}

TEST(Attempts, MeanDoesNotDependOnStepOrCell) {
  for (const auto& [cell, step] : {std::pair{0.0075, 0.002}, {0.0075, 0.004}, {0.015, 0.002}}) {
    const Births births = find_births(plunging(cell, step, 0.3, 2.5), without_rejection(1e6), 1);
    const double expected = 1e6 * 0.15 * 0.075 * (0.3 - 0.011) / 2.0;  // the first window has no seeds
    EXPECT_LE(std::abs(static_cast<double>(births.births.size()) / expected - 1.0), 0.05) << cell << " " << step;
  }
}

TEST(Births, UniformInTheStep) {
  EntrainmentOptions options = without_rejection(4e5);
  options.patches = {{{0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}, 0.0, 10.0}};
  const PoolFrames pool(
      0.15, 0.02, 0.02, 6, [](double) { return 0.5; }, [](double, const Vector3d&) { return Vector3d(0, 0, 0); });
  std::vector<double> shares;
  for (const Birth& b : find_births(pool, options, 3).births) shares.push_back(std::fmod(b.time_s, 0.02) / 0.02);
  std::sort(shares.begin(), shares.end());
  double distance = 0.0;  // Kolmogorov and Smirnov
  for (std::size_t i = 0; i < shares.size(); ++i)
    distance = std::max(distance, std::abs(shares[i] - (i + 0.5) / static_cast<double>(shares.size())));
  EXPECT_LE(distance, 1.63 / std::sqrt(static_cast<double>(shares.size())));  // 1 % level
}

TEST(Rejection, CoverageIsScaleFree) {
  // A sheet of seeds of strength near 1 fills its disc: radii of any size above the cell pass at 0.6, none at 1.4.
  for (const double radius : {0.02, 0.04}) {
    EntrainmentOptions options = without_rejection(2e4);
    options.seeds.life_s = 1.0;
    options.radii.kind = RadiusDistribution::Kind::kGaussian;
    options.radii.mean_m = options.radii.smallest_m = options.radii.largest_m = radius;
    options.radii.std_m = 0.0;
    options.coverage = 0.3;
    const PoolFrames frames = plunging(0.01, 0.004, 0.06, 2.0);
    const Births loose = find_births(frames, options, 1);
    EXPECT_GE(static_cast<double>(loose.births.size()), 0.4 * static_cast<double>(loose.n_attempts)) << radius;
    options.coverage = 9.0;
    const Births strict = find_births(frames, options, 1);
    EXPECT_LE(static_cast<double>(strict.births.size()), 0.02 * static_cast<double>(strict.n_attempts)) << radius;
  }
}

// Erratum 78: eq. 41 as printed, at a coverage of 3.2 that next to no place has: a bubble's own seed alone passes it below r = 0.079 cells, of any
// liquid; scale-free, it passes none of any size.
TEST(Rejection, AsPrintedItPassesBubblesOfATwentiethOfACellWhateverTheCoverage) {
  EntrainmentOptions options = without_rejection(2e4);
  options.seeds.life_s = 1.0;
  options.radii.kind = RadiusDistribution::Kind::kGaussian;
  options.radii.std_m = 0.0;
  options.coverage = 3.2;
  const PoolFrames frames = plunging(0.01, 0.004, 0.06, 2.0);
  const auto share = [&](double radius_m, EntrainmentForm form) {
    options.form = form;
    options.radii.mean_m = options.radii.smallest_m = options.radii.largest_m = radius_m;
    const Births births = find_births(frames, options, 1);
    return static_cast<double>(births.births.size()) / static_cast<double>(births.n_attempts);
  };
  EXPECT_GE(share(0.0005, EntrainmentForm::kPaper), 0.5);
  EXPECT_LE(share(0.005, EntrainmentForm::kPaper), 0.1);
  EXPECT_LE(share(0.0005, EntrainmentForm::kMended), 0.02);
  EXPECT_LE(share(0.005, EntrainmentForm::kMended), 0.02);
}

TEST(Births, AreThoseOfTheSeedOnAnyNumberOfThreads) {
  EntrainmentOptions options;
  options.attempts_per_m2_s = 1e5;
  options.coverage = 0.2;
  options.consume = true;
  const PoolFrames frames = plunging(0.02, 0.004, 0.2, 2.0);
  set_thread_count(1);
  const auto one = bubbles_csv(bubble_rows(paths_of(frames, find_births(frames, options, 5).births, {}), {}, {}, {}));
  set_thread_count(2);
  const auto two = bubbles_csv(bubble_rows(paths_of(frames, find_births(frames, options, 5).births, {}), {}, {}, {}));
  const auto other = bubbles_csv(bubble_rows(paths_of(frames, find_births(frames, options, 6).births, {}), {}, {}, {}));
  set_thread_count(0);
  EXPECT_EQ(one, two);
  EXPECT_NE(one, other);
}

TEST(BubblesCsv, HasItsColumnsAlsoWithoutBubbles) {
  const std::string head =
      "id,birth_s,end_s,end_kind,radius_m,x_m,y_m,z_m,depth_m,frequency_start_hz,frequency_end_hz\n";
  EXPECT_EQ(bubbles_csv({}), head);
  const PoolFrames pool = PoolFrames::at_rest(0.5);
  const std::vector<BubbleRow> rows =
      bubble_rows(paths_of(pool, {{1e-3, 0.1, {0.5, 0.5, 0.49}, Vector3d::Zero()}}, {}), {}, {}, {});
  EXPECT_EQ(bubbles_csv(rows).substr(0, head.size()), head);
  EXPECT_EQ(rows[0].id, 1);
  EXPECT_LE(std::abs(rows[0].depth_m - 0.01), 1e-12);
  EXPECT_LE(std::abs(rows[0].frequency_start_hz - 3283.0), 5.0);  // Minnaert
  EXPECT_GE(rows[0].frequency_end_hz, 1.2 * rows[0].frequency_start_hz);
  EXPECT_EQ(rows[0].end_kind, EndKind::kSurface);
}

}  // namespace
}  // namespace klang::entrainment
