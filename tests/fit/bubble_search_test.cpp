// Drops of known radius, rise and pitch constants, integrated by Runge and Kutta's rule: found, measured, none invented.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "core/foundation/base/errors.hpp"
#include "fit/bubble/bubble_search.hpp"
#include "fit/bubble/recording_verdict.hpp"
#include "tests/fit/drop_signals.hpp"
#include "tests/fit/gradient_checker.hpp"

namespace klang::fit::bubble {
namespace {

using tests::Drop;

const FoundBubble* nearest(const BubbleSearchResult& result, const Drop& drop) {
  const FoundBubble* best = nullptr;
  const auto distance = [&](const FoundBubble& b) {
    return std::abs(b.chirp.onset_s - drop.onset_s) / 0.002 +
           std::abs(b.chirp.log_frequency - std::log(drop.frequency_hz(0.0))) / 0.05;
  };
  for (const FoundBubble& bubble : result.found)
    if (!best || distance(bubble) < distance(*best)) best = &bubble;
  return best;
}

void expect_found(const BubbleSearchResult& result, const std::vector<Drop>& drops) {
  ASSERT_EQ(result.found.size(), drops.size());
  for (const Drop& drop : drops) {
    const FoundBubble& bubble = *nearest(result, drop);
    const double beta = drop.decay_per_s(0.0);
    EXPECT_LE(std::abs(bubble.chirp.onset_s - drop.onset_s), 0.002) << drop.radius_m;
    EXPECT_LE(std::abs(bubble.radius_m / drop.radius_m - 1.0), 0.01) << drop.radius_m;
    EXPECT_LE(std::abs(std::exp(bubble.chirp.log_decay) / beta - 1.0), 0.10) << drop.radius_m;
    EXPECT_EQ(bubble.verdict, BubbleVerdict::kBubble) << drop.radius_m;
    EXPECT_LE(std::abs(bubble.radius_m - drop.radius_m), 4.0 * bubble.radius_std_m.value_or(0.0) + 1e-4 * drop.radius_m)
        << drop.radius_m;
    for (double since = 0.0; since < std::min(2.0 / beta, bubble.end_s - bubble.chirp.onset_s); since += 0.1 / beta) {
      const double at = since + drop.onset_s - bubble.chirp.onset_s;
      if (at < 0.0) continue;
      const double hz = std::exp(bubble.chirp.log_frequency + bubble.law.pitch_at(at, bubble.chirp.pitch).log_ratio);
      EXPECT_LE(std::abs(hz / drop.frequency_hz(since) - 1.0), 0.005) << drop.radius_m << " m at " << since << " s";
    }
  }
}

TEST(BubbleSearch, OneRisingDropAt30DbIsMeasured) {
  const Drop drop;
  expect_found(find_bubbles(tests::drop_sound({drop}, 0.3, 44100.0, 30.0, 1)), {drop});
}

TEST(BubbleSearch, DropsOfEverySizeAreFoundAt30DbAndNoneIsInvented) {
  std::vector<Drop> drops;
  double onset = 0.05;
  for (const double radius : {0.0003, 0.0005, 0.0008, 0.0012, 0.002, 0.003, 0.005}) {
    Drop drop;
    drop.radius_m = radius;
    drop.onset_s = onset;
    drop.depth_m = 0.015;
    drops.push_back(drop);
    onset += 0.12;
  }
  expect_found(find_bubbles(tests::drop_sound(drops, 1.0, 44100.0, 30.0, 2)), drops);
}

TEST(BubbleSearch, DropsThatOverlapInTimeAndPitchAreToldApart) {
  std::vector<Drop> drops(4);
  drops[1].onset_s = 0.056;
  drops[1].radius_m = 0.0015;
  drops[2].onset_s = 0.062;
  drops[2].radius_m = 0.0026;
  drops[2].speed_m_s = 0.1;
  drops[3].onset_s = 0.058;
  drops[3].radius_m = 0.0008;
  expect_found(find_bubbles(tests::drop_sound(drops, 0.3, 44100.0, 30.0, 3)), drops);
}

TEST(BubbleSearch, NoiseAloneHasNoBubbles) {
  for (unsigned seed = 0; seed < 4; ++seed) {
    audio::Signal noise;
    noise.sample_rate_hz = 44100.0;
    noise.samples.resize(44100, 1);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 0.1);
    for (double& x : noise.samples.reshaped()) x = normal(random);
    const auto result = find_bubbles(noise);
    EXPECT_EQ(result.status, BubbleSearchStatus::kNothingFound) << seed;
    EXPECT_EQ(result.found.size(), 0u) << seed;
  }
}

TEST(BubbleSearch, ATilesPartialIsCalledNoBubble) {
  audio::Signal tile;
  tile.sample_rate_hz = 44100.0;
  tile.samples.resize(44100, 1);
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0.0, 0.003);
  for (Eigen::Index i = 0; i < tile.samples.rows(); ++i) {
    const double t = static_cast<double>(i) / 44100.0 - 0.1;
    tile.samples(i, 0) = normal(random) + (t > 0.0 ? std::exp(-25.0 * t) * std::sin(2.0 * kPi * 1500.0 * t) : 0.0);
  }
  const auto result = find_bubbles(tile);
  ASSERT_GE(result.found.size(), 1u);
  for (const FoundBubble& bubble : result.found)
    EXPECT_FALSE(bubble.is_bubble()) << std::exp(bubble.chirp.log_frequency);
}

audio::Signal signal_of(const Eigen::VectorXd& samples) { return {samples, 44100.0, "synthetic"}; }

/// Why a sound is refused; empty where it is taken for bubbles.
std::string refused(const audio::Signal& sound) {
  const BubbleSearchResult found = find_bubbles(sound);
  return refusal_of(found, evidence_of(found));
}

// Two of three such noises never ended: a decay of next to nothing, and a step of a quarter cycle through its life.
TEST(BubbleSearch, SeventeenMillisecondsOfBrownNoiseEndAndAreRefused) {
  for (unsigned seed = 0; seed < 3; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 0.01);
    Eigen::VectorXd x(741);
    double sum = 0.0;
    for (double& value : x) value = sum += normal(random);
    EXPECT_NE(refused(signal_of(x)), "") << seed;
  }
}

/// A ring as the search leaves it: at one pitch, or gliding at a rate.
FoundBubble ring(double onset_s, double frequency_hz, double rate_per_s, double life_s) {
  FoundBubble bubble;
  bubble.law.pitch = std::make_shared<const ExponentialPitch>();
  bubble.chirp.onset_s = onset_s;
  bubble.chirp.log_frequency = std::log(frequency_hz);
  bubble.chirp.pitch = {rate_per_s, 0.0};
  bubble.end_s = onset_s + life_s;
  bubble.snr_db = 40.0;
  return bubble;
}

std::string refused(const std::vector<FoundBubble>& rings, double explained = 0.9) {
  BubbleSearchResult found;
  found.found = rings;
  found.explained_above_noise = explained;
  return refusal_of(found, evidence_of(found));
}

TEST(RecordingVerdict, RingsThatGoOnWhereAnotherEndsAreAGlidingTone) {
  // A sweep as the search cuts it: each piece begins at the pitch of the one before.
  const auto piece = [](int i) { return ring(0.05 + 0.02 * i, 500.0 * std::exp(0.4 * i), 20.0, 0.02); };
  EXPECT_NE(refused({piece(0), piece(1), piece(2), piece(3)}).find("gliding"), std::string::npos);
}

// Each partial of wood alone decays as a bubble of its pitch might.
TEST(RecordingVerdict, SteadyRingsThatBeginTogetherAreAStruckBody) {
  EXPECT_NE(
      refused({ring(0.05, 1100, 0, 0.02), ring(0.0505, 1750, 0, 0.02), ring(0.051, 2900, 0, 0.01)}).find("struck body"),
      std::string::npos);
  EXPECT_EQ(refused({ring(0.05, 1100, 0, 0.02), ring(0.0505, 1750, 0, 0.02)}), "");
}

TEST(RecordingVerdict, FallingDrivenAndUnexplainedSoundsAreRefused) {
  EXPECT_NE(refused({ring(0.05, 2000, -20, 0.02)}).find("falls"), std::string::npos);
  FoundBubble driven = ring(0.05, 800, 10, 0.05);
  driven.verdict = BubbleVerdict::kDriven;
  EXPECT_NE(refused({driven}).find("amplitude"), std::string::npos);
  EXPECT_NE(refused({ring(0.05, 1000, 5, 0.02)}, 0.05).find("explain"), std::string::npos);
  EXPECT_NE(refused(std::vector<FoundBubble>{}), "");
  EXPECT_EQ(refused({ring(0.05, 1000, 5, 0.02), ring(0.2, 1500, 0, 0.02)}), "");
}

TEST(RecordingVerdict, DropsAreTakenAtThirtyAndAtTenDb) {
  std::vector<Drop> drops(2);
  drops[1].onset_s = 0.2;
  drops[1].radius_m = 0.0014;
  for (const double snr_db : {30.0, 10.0})
    EXPECT_EQ(refused(tests::drop_sound(drops, 0.4, 44100.0, snr_db, 1)), "") << snr_db;
}

class StopsAfter final : public Monitor {
 public:
  explicit StopsAfter(int calls) : left_(calls) {}
  bool stop_requested() const override { return left_-- <= 0; }

 private:
  mutable std::atomic<int> left_;
};

TEST(BubbleSearch, StopsInEachStageWhenAsked) {
  const audio::Signal sound = tests::drop_sound({Drop()}, 0.3, 44100.0, 30.0, 1);
  for (const int calls : {0, 10, 50}) {
    StopsAfter monitor(calls);
    EXPECT_THROW(find_bubbles(sound, {}, monitor), Interrupted) << calls;
  }
}

TEST(BubbleSearch, TheLimitOfWorkEndsItAndIsSaid) {
  std::vector<Drop> drops(4);
  for (std::size_t i = 0; i < 4; ++i)
    drops[i].onset_s = 0.02 + 0.004 * static_cast<double>(i), drops[i].radius_m += 4e-4 * static_cast<double>(i);
  BubbleSearchOptions options;
  options.max_work = 0.01;
  options.min_snr_db = 10.0;
  EXPECT_TRUE(find_bubbles(tests::drop_sound(drops, 0.1, 44100.0, 90.0, 1), options).stopped_early);
  EXPECT_FALSE(find_bubbles(tests::drop_sound({Drop()}, 0.3, 44100.0, 30.0, 1)).stopped_early);
}

TEST(BubbleSearch, RadiusOfAFrequencyInvertsTheOscillator) {
  for (const double radius : {3e-5, 3e-4, 1e-3, 5e-3, 2e-2}) {
    Drop drop;
    drop.radius_m = radius;
    const double hz = drop.frequency_hz(0.0);
    EXPECT_LE(std::abs(radius_of_frequency_m(hz, {}, klang::bubble::BubbleTheory::kLeighton) / radius - 1.0), 1e-9)
        << radius;
  }
}

TEST(BubbleSearch, SilenceAndNanAreRefused) {
  audio::Signal signal;
  signal.sample_rate_hz = 44100.0;
  signal.samples = Eigen::MatrixXd::Zero(1000, 1);
  EXPECT_THROW(find_bubbles(signal), InputError);
  signal.samples(3, 0) = std::nan("");
  EXPECT_THROW(find_bubbles(signal), InputError);
  signal.samples = Eigen::MatrixXd::Ones(100, 1);
  EXPECT_THROW(find_bubbles(signal), InputError);
}

TEST(ChirpCost, GradientMatchesDifferences) {
  const Drop drop;
  const audio::Signal sound = tests::drop_sound({drop}, 0.15, 44100.0, 30.0, 1);
  const Eigen::VectorXd samples = sound.samples.col(0);
  const auto window = std::make_shared<const ChirpWindow>(samples.segment(1000, 4000).eval(), 44100.0,
                                                          ChirpWindow::Place{1000, samples.size(), 500.0, 5000.0},
                                                          noise_spectrum(samples, 44100.0));
  const auto exponential = std::make_shared<const ExponentialPitch>();
  const auto depth =
      std::make_shared<const DepthPitch>([](double t) { return 0.012 - 0.2 * t; }, [](double) { return 0.2; });
  const std::vector<double> own1 = {50.0123, 7.4, 4.8, 0.5, 0.3}, own2 = {55.3071, 7.6, 5.0, -0.2, 0.4};
  // Two bubbles, each of its own pitch; two that share it; along a depth.
  tests::expect_gradient(
      *make_chirp_cost(window, {ChirpLaw{exponential, 1.5, 1.5, 0.0, 0.004}, ChirpLaw{exponential, 1.5, 1.5, 0.0, {}}},
                       {0, 1}),
      {{1.2, 2.0}, {0.7, 1e-7}, own1, own2}, 1e-5, 1e-5);
  tests::expect_gradient(
      *make_chirp_cost(window, {ChirpLaw{exponential, 1.5, 1.5, 0.0, {}}, {exponential, -0.5, 2.0, 800.0, {}}}, {0, 0}),
      {{1.2, -2.0}, own1, own2}, 1e-5, 1e-5);
  tests::expect_gradient(*make_chirp_cost(window, {ChirpLaw{depth, 1.5, 1.5, 0.0, {}}}, {0}), {{0.7, 4.8}, own1}, 1e-5,
                         1e-5);
}

}  // namespace
}  // namespace klang::fit::bubble
