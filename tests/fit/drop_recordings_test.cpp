// Seeded recordings of drops whose physics datasets-synthetic integrates by another method: every bubble found, none invented.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "datasets-synthetic/drops.hpp"
#include "fit/bubble/pitch_fit.hpp"

namespace klang::fit::bubble {
namespace {

using nlohmann::json;

struct Worst {
  double onset_s = 0.0, radius = 0.0, decay = 0.0, track = 0.0;
  int n = 0, n_covered = 0;
};

double along(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto i = std::clamp<std::size_t>(static_cast<std::size_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin()),
                                         1, x.size() - 1);
  const double t = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] + t * (y[i] - y[i - 1]);
}

/// Matches found with true bubbles and takes down the largest errors; counts must agree.
void compare(const BubbleSearchResult& result, const json& truth, Worst& worst) {
  std::vector<const FoundBubble*> bubbles;
  for (const FoundBubble& b : result.found)
    if (b.is_bubble()) bubbles.push_back(&b);
  ASSERT_EQ(bubbles.size(), truth["bubbles"].size()) << truth["name"];
  for (const json& drop : truth["bubbles"]) {
    const double onset = drop["onset_s"], radius = drop["radius_m"];
    const auto distance = [&](const FoundBubble* b) {
      return std::abs(b->chirp.onset_s - onset) + 0.01 * std::abs(b->radius_m / radius - 1.0);
    };
    const FoundBubble& b =
        **std::min_element(bubbles.begin(), bubbles.end(), [&](auto* p, auto* q) { return distance(p) < distance(q); });
    worst.onset_s = std::max(worst.onset_s, std::abs(b.chirp.onset_s - onset));
    worst.radius = std::max(worst.radius, std::abs(b.radius_m / radius - 1.0));
    worst.decay =
        std::max(worst.decay, std::abs(std::exp(b.chirp.log_decay) / drop["decay_per_s"].get<double>() - 1.0));
    ++worst.n;
    worst.n_covered += std::abs(b.radius_m - radius) <= 1.96 * b.radius_std_m.value();
    const std::vector<double> times = drop["track"]["time_s"], hz = drop["track"]["frequency_hz"];
    const double heard_s = std::min({b.end_s - b.chirp.onset_s, 2.5 / drop["decay_per_s"].get<double>(), times.back()});
    for (double since = 0.0; since <= heard_s && times.size() > 1; since += 0.02 * heard_s) {
      const double at = std::max(0.0, since + onset - b.chirp.onset_s);
      const double found = std::exp(b.chirp.log_frequency + b.law.pitch_at(at, b.chirp.pitch).log_ratio);
      worst.track = std::max(worst.track, std::abs(found / along(times, hz, since) - 1.0));
    }
  }
}

Worst worst_of(const std::string& recipe, unsigned seed, double& seconds) {
  const datasets::Dataset made = datasets::make_drops(recipe, "test", seed);
  const json truth = json::parse(made.truth_json);
  Worst worst;
  for (std::size_t i = 0; i < made.recordings.size(); ++i) {
    compare(find_bubbles(made.recordings[i].signal), truth["recordings"][i], worst);
    seconds += made.recordings[i].signal.duration_s();
  }
  return worst;
}

std::string recipe(int recordings, int drops, double gap_s, double duration_s) {
  return "kind = \"drops\"\nname = \"test\"\n[sound]\nsample_rate_hz = 44100\nduration_s = " +
         std::to_string(duration_s) +
         "\n[pitch]\nmodel = \"harmonic_fluids\"\nphi0_m = -0.01\n"
         "[noise]\nsnr_db = 30\n[[random]]\nname = \"drip\"\nrecordings = " +
         std::to_string(recordings) + "\ndrops = " + std::to_string(drops) +
         "\nshortest_gap_s = " + std::to_string(gap_s) + "\n";
}

void expect_within_the_bars(const Worst& worst) {
  EXPECT_LE(worst.onset_s, 0.002);
  EXPECT_LE(worst.radius, 0.01);
  EXPECT_LE(worst.decay, 0.10);
  EXPECT_LE(worst.track, 0.005);
}

TEST(DropRecordings, EveryBubbleIsMeasuredWithinTheBarsAt30Db) {
  double seconds = 0.0;
  const Worst worst = worst_of(recipe(6, 5, 0.08, 1.2), 11, seconds);
  ASSERT_EQ(worst.n, 30);
  expect_within_the_bars(worst);
  // Of thirty 95 % intervals five or more miss with probability 0.02.
  EXPECT_GE(worst.n_covered, 26);
}

TEST(DropRecordings, OverlappingDropsAreMeasuredWithinTheBars) {
  double seconds = 0.0;
  const Worst worst = worst_of(recipe(3, 4, 0.005, 0.35), 2, seconds);
  ASSERT_EQ(worst.n, 12);
  expect_within_the_bars(worst);
}

}  // namespace
}  // namespace klang::fit::bubble
