/// Ringdown identification on what recordings do to partials.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/fit/ringdown_signals.hpp"

using klang::kPi;
using klang::audio::Signal;
using klang::fit::identify_ringdown;
using klang::fit::RingdownStatus;
using klang::tests::nearest;
using klang::tests::ringing;
using klang::tests::TruePartial;

namespace {

const std::vector<TruePartial> kBar{
    {440, 1.5, 0.2, 0.4}, {1213, 4, 0.15, -1.0}, {2377, 9, 0.1, 2.0}, {5120, 25, 0.1, 0.1}};

/// All of kBar found within 0.05 Hz and 5 % of the decay, and nothing else.
void expect_bar(const klang::fit::RingdownResult& result, double frequency_hz = 0.05, double decay = 0.05) {
  ASSERT_EQ(result.status, RingdownStatus::kOk) << result.message;
  EXPECT_EQ(result.partials.partials.size(), kBar.size());
  for (const TruePartial& truth : kBar) {
    const auto* found = nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr);
    EXPECT_NEAR(found->frequency_hz, truth.frequency_hz, frequency_hz);
    EXPECT_NEAR(*found->decay_per_s, truth.decay_per_s, decay * truth.decay_per_s);
  }
}

}  // namespace

TEST(RingdownHard, APairThatBeatsEveryThreeSecondsIsSplit) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto result =
        identify_ringdown(ringing({{800, 0.7, 0.1, 0.2}, {800.3, 0.9, 0.07, 1.4}}, 16000, 6, 1e-3, seed, 0.05));
    ASSERT_EQ(result.partials.partials.size(), 2u) << seed;
    EXPECT_NEAR(result.partials.partials[0].frequency_hz, 800.0, 0.02);
    EXPECT_NEAR(result.partials.partials[1].frequency_hz, 800.3, 0.02);
    EXPECT_NEAR(*result.partials.partials[0].decay_per_s, 0.7, 0.05);
    EXPECT_NEAR(*result.partials.partials[1].decay_per_s, 0.9, 0.05);
  }
}

TEST(RingdownHard, DecaysFromHalfToTwoHundredPerSecondAreFoundTogether) {
  const std::vector<TruePartial> truth{
      {300, 0.5, 0.1, 0}, {1900, 200, 0.3, 1}, {2500, 5, 0.05, 2}, {7000, 100, 0.3, 3}};
  const auto result = identify_ringdown(ringing(truth, 48000, 5, 3e-4, 4, 0.2));
  ASSERT_EQ(result.partials.partials.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_NEAR(*result.partials.partials[i].decay_per_s, truth[i].decay_per_s, 0.05 * truth[i].decay_per_s);
  }
}

TEST(RingdownHard, SeveralStrikesShareFrequenciesAndKeepTheirAmplitudes) {
  const std::vector<double> times{0.3, 1.1, 2.4};
  const std::vector<double> loudness{1.0, 0.5, 0.8};
  Signal signal = ringing({}, 48000, 4, 3e-4, 9);
  for (std::size_t s = 0; s < times.size(); ++s) {
    auto partials = kBar;
    for (auto& p : partials) p.amplitude *= loudness[s];
    signal.samples += ringing(partials, 48000, 4, 0.0, 1, times[s]).samples;
  }
  const auto result = identify_ringdown(signal);
  expect_bar(result);
  ASSERT_EQ(result.strikes_s.size(), 3u);
  ASSERT_EQ(result.strike_amplitudes.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s) {
    EXPECT_NEAR(result.strikes_s[s], times[s], 1e-3);
    // The highest partial dies between strikes: its amplitude is that of each strike alone.
    EXPECT_NEAR(result.strike_amplitudes[s].back() / (0.1 * loudness[s]), 1.0, 0.1);
  }
}

TEST(RingdownHard, AmplitudesAreThoseOfAStrikeThatExcitesThePartial) {
  // The first blow excites one partial, the second all but this, the third two of them a little.
  const std::vector<double> times{0.3, 1.6, 2.9};
  const std::vector<std::vector<double>> loudness{{0, 0.3, 0, 0}, {1, 0, 1, 1}, {0.2, 0.05, 0, 0}};
  Signal signal = ringing({}, 48000, 4.5, 3e-5, 9);
  for (std::size_t s = 0; s < times.size(); ++s) {
    auto partials = kBar;
    for (std::size_t i = 0; i < partials.size(); ++i) partials[i].amplitude *= loudness[s][i % 4];
    signal.samples += ringing(partials, 48000, 4.5, 0.0, 1, times[s]).samples;
  }
  const auto result = identify_ringdown(signal);
  ASSERT_TRUE(result.usable()) << result.message;
  ASSERT_EQ(result.amplitude_strike, 1);
  for (std::size_t i = 0; i < kBar.size(); ++i) {
    const double loudest = std::max({loudness[0][i % 4], loudness[1][i % 4], loudness[2][i % 4]});
    const auto found =
        std::find_if(result.partials.partials.begin(), result.partials.partials.end(),
                     [&](const auto& p) { return std::abs(p.frequency_hz / kBar[i].frequency_hz - 1) < 1e-4; });
    ASSERT_NE(found, result.partials.partials.end()) << kBar[i].frequency_hz;
    EXPECT_NEAR(*found->amplitude / (kBar[i].amplitude * loudest), 1.0, 0.1) << kBar[i].frequency_hz;
  }
  bool said = false;
  for (const auto& warning : result.warnings)
    said = said || warning.find("not struck at strike 2") != std::string::npos;
  EXPECT_TRUE(said);
}

TEST(RingdownHard, ABodyThatBouncesIsSaidToHaveBlowsThatWereNotFound) {
  // Two blows 18 ms after one another count as one strike, as does what taps on softly.
  Signal signal = ringing({}, 48000, 3, 3e-5, 9);
  const std::vector<std::pair<double, double>> blows{{0.3, 1.0}, {0.45, 0.04}, {0.56, 0.045}, {0.65, 0.04}};
  for (const auto& [time_s, loudness] : blows) {
    auto partials = kBar;
    for (auto& p : partials) p.amplitude *= loudness * (p.frequency_hz > 2000 ? 1.0 : 0.1);
    signal.samples += ringing(partials, 48000, 3, 0.0, 1, time_s).samples;
  }
  const auto missed = [](const klang::fit::RingdownResult& result) {
    return std::any_of(result.warnings.begin(), result.warnings.end(),
                       [](const std::string& warning) { return warning.find("begins anew") != std::string::npos; });
  };
  EXPECT_TRUE(missed(identify_ringdown(signal)));
  EXPECT_FALSE(missed(identify_ringdown(ringing(kBar, 48000, 3, 3e-5, 9, 0.3))));
}

TEST(RingdownHard, RumbleHumAndOffsetDoNotBecomePartials) {
  Signal signal = ringing(kBar, 48000, 4, 1e-3, 12, 0.5);
  klang::RandomStream random(3, 3);
  double rumble = 0;
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / 48000;
    rumble += 0.002 * (random.normal() * 0.5 - rumble);  // low-passed at about 15 Hz
    signal.samples(i, 0) +=
        0.1 + 3 * rumble + 0.05 * std::sin(2 * kPi * 50 * t) + 0.01 * std::sin(2 * kPi * 150 * t + 1);
  }
  const auto result = identify_ringdown(signal);
  expect_bar(result);
  bool hum = false;
  for (const auto& warning : result.warnings) hum = hum || warning.find("mains hum at 50 Hz") != std::string::npos;
  EXPECT_TRUE(hum);
}

TEST(RingdownHard, ClippedSamplesAreLeftOut) {
  Signal signal = ringing(kBar, 48000, 3, 3e-4, 5, 0.2);
  signal.samples = signal.samples.cwiseMin(0.4).cwiseMax(-0.4);
  const auto result = identify_ringdown(signal);
  expect_bar(result);
  bool told = false;
  for (const auto& warning : result.warnings) told = told || warning.find("clipped") != std::string::npos;
  EXPECT_TRUE(told);
}

TEST(RingdownHard, ARoomTailOfDecayingNoiseDoesNotInventPartials) {
  Signal signal = ringing(kBar, 48000, 3, 2e-4, 6, 0.2);
  klang::RandomStream random(8, 1);
  for (Eigen::Index i = 9600; i < signal.n_frames(); ++i) {
    signal.samples(i, 0) += 0.01 * std::exp(-9 * (static_cast<double>(i) / 48000 - 0.2)) * random.normal();
  }
  expect_bar(identify_ringdown(signal), 0.1, 0.05);
}

TEST(RingdownHard, ThreeMinutesCostMemoryAndTimeOfTheRingingOnly) {
  const auto result = identify_ringdown(ringing(kBar, 16000, 180, 1e-3, 6, 2.0));
  expect_bar(result);
  ASSERT_EQ(result.strikes_s.size(), 1u);
  EXPECT_NEAR(result.strikes_s[0], 2.0, 1e-3);
}

TEST(RingdownHard, HandlingNoiseBeforeTheStrikeIsNotAStrike) {
  Signal signal = ringing(kBar, 48000, 3, 3e-4, 7, 1.0);
  klang::RandomStream random(4, 4);
  for (Eigen::Index i = 14400; i < 16800; ++i) {  // 50 ms of scraping, 25 dB below the strike
    signal.samples(i, 0) += 0.01 * std::sin(kPi * static_cast<double>(i - 14400) / 2400) * random.normal();
  }
  const auto result = identify_ringdown(signal);
  expect_bar(result);
  ASSERT_EQ(result.strikes_s.size(), 1u);
  EXPECT_NEAR(result.strikes_s[0], 1.0, 1e-3);
}

TEST(RingdownHard, AMalletThatBouncesDoesNotMultiplyThePartials) {
  Signal signal = ringing(kBar, 48000, 2, 3e-4, 8, 0.2);
  for (const double bounce : {0.211, 0.217}) {
    auto partials = kBar;
    for (auto& p : partials) p.amplitude *= 0.4;
    signal.samples += ringing(partials, 48000, 2, 0.0, 1, bounce).samples;
  }
  expect_bar(identify_ringdown(signal));
}

TEST(RingdownHard, PinkNoiseGivesNothingForTwentySeeds) {
  klang::for_each_job(20, [&](std::size_t seed) {
    Signal signal = ringing({}, 24000, 2, 0.0, 1);
    klang::RandomStream random(seed, 2);
    // Voss's sum of octave-spaced low-passed noises.
    std::array<double, 12> state{};
    for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
      double x = 0;
      for (std::size_t k = 0; k < state.size(); ++k) {
        const double rate = std::exp2(-static_cast<double>(k));
        state[k] += rate * (random.normal() / std::sqrt(rate) - state[k]);
        x += state[k];
      }
      signal.samples(i, 0) = 0.02 * x;
    }
    const auto result = identify_ringdown(signal);
    EXPECT_EQ(result.status, RingdownStatus::kNothingFound) << "seed " << seed;
    EXPECT_FALSE(result.message.empty());
  });
}

TEST(RingdownHard, TwoMicrophonesAreSurerThanOneAndACopyIsNot) {
  const Signal one = ringing(kBar, 24000, 1.5, 3e-3, 20, 0.1);
  Signal copy = one, two = one;
  copy.samples.conservativeResize(Eigen::NoChange, 2);
  copy.samples.col(1) = 0.5 * one.samples.col(0);
  two.samples.conservativeResize(Eigen::NoChange, 2);
  two.samples.col(1) = ringing(kBar, 24000, 1.5, 3e-3, 21, 0.1).samples;
  const auto a = identify_ringdown(one), b = identify_ringdown(copy), c = identify_ringdown(two);
  expect_bar(a, 0.2, 0.1);
  expect_bar(b, 0.2, 0.1);
  expect_bar(c, 0.2, 0.1);
  for (std::size_t i = 0; i < kBar.size(); ++i) {
    const double alone = *a.partials.partials[i].frequency_std_hz;
    EXPECT_NEAR(*b.partials.partials[i].frequency_std_hz / alone, 1.0, 0.01);
    EXPECT_NEAR(*c.partials.partials[i].frequency_std_hz / alone, std::sqrt(0.5), 0.2);
  }
}

TEST(RingdownHard, RatesFrom8To768KilohertzAnd32ChannelsWork) {
  for (const double rate : {8000.0, 22050.0, 192000.0, 768000.0}) {
    std::vector<TruePartial> partials{{440, 3, 0.2, 0.4}, {1213, 8, 0.15, -1.0}, {2377, 20, 0.1, 2.0}};
    const auto result = identify_ringdown(ringing(partials, rate, 1.0, 1e-3, 2, 0.1));
    ASSERT_EQ(result.partials.partials.size(), 3u) << rate;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(result.partials.partials[i].frequency_hz, partials[i].frequency_hz, 0.05) << rate;
    }
  }
  const Signal one = ringing(kBar, 16000, 1, 1e-3, 3, 0.1);
  Signal many = one;
  many.samples = one.samples.replicate(1, 32) + 1e-3 * Eigen::MatrixXd::Random(one.n_frames(), 32);
  EXPECT_EQ(identify_ringdown(many).partials.partials.size(), kBar.size());
  many.samples = one.samples.replicate(1, 33);
  EXPECT_THROW(identify_ringdown(many), klang::InputError);
}

TEST(RingdownHard, ShortSignalsNeverCrash) {
  for (const double frames : {16.0, 17.0, 40.0, 100.0, 333.0, 1000.0, 3000.0}) {
    const auto result = identify_ringdown(ringing(kBar, 48000, frames / 48000, 1e-4, 3));
    EXPECT_NE(result.status, RingdownStatus::kNotRun) << frames;
  }
}

TEST(RingdownHard, TheResultDoesNotDependOnTheNumberOfThreads) {
  const Signal signal = ringing(kBar, 24000, 1, 1e-3, 30, 0.1);
  klang::set_thread_count(1);
  const auto one = identify_ringdown(signal);
  klang::set_thread_count(0);
  const auto all = identify_ringdown(signal);
  ASSERT_EQ(one.partials.partials.size(), all.partials.partials.size());
  for (std::size_t i = 0; i < one.partials.partials.size(); ++i) {
    EXPECT_EQ(one.partials.partials[i].frequency_hz, all.partials.partials[i].frequency_hz);
    EXPECT_EQ(one.partials.partials[i].decay_std_per_s, all.partials.partials[i].decay_std_per_s);
  }
}

TEST(RingdownHard, TheResynthesisIsTheRecordingWithoutItsNoise) {
  const Signal signal = ringing(kBar, 48000, 2, 1e-3, 31, 0.25);
  const auto result = identify_ringdown(signal);
  const Signal again = klang::fit::resynthesise(result, signal.n_frames());
  const Signal clean = ringing(kBar, 48000, 2, 0.0, 31, 0.25);
  const Eigen::Index from = 12000 + 480;
  const double error = (again.samples - clean.samples).bottomRows(signal.n_frames() - from).squaredNorm();
  EXPECT_LE(error, 1e-4 * clean.samples.squaredNorm());
  EXPECT_EQ(again.samples.topRows(11000).cwiseAbs().maxCoeff(), 0.0);
}
