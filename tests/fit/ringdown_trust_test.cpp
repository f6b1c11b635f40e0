/// What is a partial, what is a tone, and when a recording is refused.
#include <gtest/gtest.h>

#include <cmath>

#include "fit/ringdown/partial_pairs.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/fit/ringdown_signals.hpp"

using klang::kPi;
using klang::audio::Signal;
using klang::fit::identify_ringdown;
using klang::fit::PartialKind;
using klang::fit::RingdownOptions;
using klang::fit::RingdownStatus;
using klang::tests::nearest;
using klang::tests::ringing;
using klang::tests::TruePartial;

namespace {

const std::vector<TruePartial> kBell{{634, 3, 0.2, 0.4}, {1720, 7, 0.15, -1.0}, {3300, 15, 0.1, 2.0}};

/// Half a second of white noise, over and over.
Signal looped_noise() {
  Signal signal = ringing({}, 44100, 3, 0.0, 1);
  const Signal piece = ringing({}, 44100, 0.5, 0.1, 5);
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) signal.samples(i, 0) = piece.samples(i % piece.n_frames(), 0);
  return signal;
}

/// Every partial of kBell that is left after gone_s is there, its frequency within half its line's width.
void expect_bell(const Signal& signal, double gone_s, const char* what, RingdownOptions options = {}) {
  const auto result = identify_ringdown(signal, options);
  ASSERT_EQ(result.status, RingdownStatus::kOk) << what << ": " << result.message;
  for (const TruePartial& truth : kBell) {
    const double left = truth.amplitude * std::exp(-truth.decay_per_s * gone_s);
    if (left < 0.003 || truth.frequency_hz > options.band.high_hz) continue;  // 30 dB over the noise, over its life
    const auto* found = nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr) << what;
    EXPECT_NEAR(found->frequency_hz, truth.frequency_hz, truth.decay_per_s / (4 * kPi)) << what;
    ASSERT_TRUE(found->decay_per_s.has_value()) << what;
    EXPECT_NEAR(*found->decay_per_s, truth.decay_per_s, 0.05 * truth.decay_per_s) << what;
  }
}

}  // namespace

TEST(RingdownTrust, CutsPaddingAndOtherBandsLoseNoPartial) {
  const Signal whole = ringing(kBell, 44100, 1.5, 1e-4, 3, 0.1);
  for (const double gone_s : {0.0, 0.02, 0.1, 0.3}) {
    Signal cut = whole;
    cut.samples = whole.samples.bottomRows(whole.n_frames() - static_cast<Eigen::Index>((0.1 + gone_s) * 44100)).eval();
    expect_bell(cut, gone_s, "cut");
  }
  Signal padded = whole;
  padded.samples = Eigen::MatrixXd::Zero(whole.n_frames() + 44100, 1);
  padded.samples.middleRows(8820, whole.n_frames()) = whole.samples;
  expect_bell(padded, 0, "padded with digital silence");
  RingdownOptions narrow;
  narrow.band = {100, 2500};
  expect_bell(whole, 0, "narrow band", narrow);
}

TEST(RingdownTrust, DigitalSilenceAtTheEndsChangesNoDigit) {
  Signal begun = ringing(kBell, 44100, 1.2, 1e-4, 3);
  begun.samples = begun.samples.bottomRows(begun.n_frames() - 2205).eval();  // rings from its first frame
  const auto expected = identify_ringdown(begun, {});
  ASSERT_EQ(expected.status, RingdownStatus::kOk);
  Signal padded = begun;
  padded.samples = Eigen::MatrixXd::Zero(begun.n_frames() + 9876, 1);
  padded.samples.middleRows(4411, begun.n_frames()) = begun.samples;  // no whole number of the 2.5 ms frames
  const auto found = identify_ringdown(padded, {});
  ASSERT_EQ(found.partials.partials.size(), expected.partials.partials.size());
  for (std::size_t i = 0; i < found.partials.partials.size(); ++i) {
    EXPECT_EQ(found.partials.partials[i].frequency_hz, expected.partials.partials[i].frequency_hz);
    EXPECT_EQ(found.partials.partials[i].decay_per_s, expected.partials.partials[i].decay_per_s);
    EXPECT_EQ(found.partials.partials[i].amplitude, expected.partials.partials[i].amplitude);
  }
  EXPECT_EQ(found.explained_energy, expected.explained_energy);
  ASSERT_EQ(found.strikes_s.size(), 1u);
  EXPECT_NEAR(found.strikes_s[0], expected.strikes_s[0] + 4411 / 44100.0, 1e-12);
}

TEST(RingdownTrust, NoiseThatFollowsTheSignalAsACodecsDoesHidesNoPartial) {
  // Noise 40 dB under the ring's own level, changing with it, and digital silence at the end.
  Signal signal = ringing(kBell, 44100, 1.5, 0.0, 3, 0.1);
  const Signal noise = ringing({}, 44100, 1.5, 1.0, 9);
  double level = 0;
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    level = std::max(0.999 * level, std::abs(signal.samples(i, 0)));
    if (level > 1e-4) signal.samples(i, 0) += 0.01 * level * noise.samples(i, 0);
  }
  expect_bell(signal, 0, "noise that follows");
}

TEST(RingdownTrust, WhatRangBeforeTheBlowAndFallsAfterItIsAPartial) {
  Signal signal = ringing({{1017.8, 0.9, 0.1, 0}, {1023.06, 1.2, 0.1, 1}}, 44100, 6, 1e-5, 2, 0.0);
  signal.samples +=
      ringing({{1017.8, 0.9, 0.2, 2}, {1023.06, 1.2, 0.2, 0}, {2592.6, 6, 0.1, 1}}, 44100, 6, 0, 1, 1.0).samples;
  const auto result = identify_ringdown(signal);
  ASSERT_EQ(result.status, RingdownStatus::kOk) << result.message;
  for (const TruePartial& truth : {TruePartial{1017.8, 0.9, 0, 0}, {1023.06, 1.2, 0, 0}, {2592.6, 6, 0, 0}}) {
    const auto* found = nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr);
    EXPECT_NEAR(found->frequency_hz, truth.frequency_hz, 0.01);
    ASSERT_TRUE(found->decay_per_s.has_value());
    EXPECT_NEAR(*found->decay_per_s, truth.decay_per_s, 0.01 * truth.decay_per_s);
  }
}

TEST(RingdownTrust, SteadyTonesHaveNoDecay) {
  std::vector<TruePartial> tones;
  for (int k = 0; k < 20; ++k) tones.push_back({311.7 + 157.3 * k, 0.0, 2e-4, 0.7 * k});  // 10 to 20 dB over the noise
  Signal signal = ringing(kBell, 44100, 3, 1e-3, 4);
  signal.samples += ringing(tones, 44100, 3, 0.0, 1).samples;
  const auto result = identify_ringdown(signal);
  ASSERT_EQ(result.status, RingdownStatus::kOk) << result.message;
  std::size_t n_rings = 0;
  for (const auto& partial : result.partials.partials) {
    n_rings += partial.is_ring() ? 1 : 0;
    EXPECT_EQ(partial.is_ring(), partial.decay_per_s.has_value()) << partial.frequency_hz;
  }
  EXPECT_EQ(n_rings, kBell.size());
  EXPECT_GE(result.steady_tones.size(), 10u);
}

TEST(RingdownTrust, ADecayThatTheRecordingCannotShowIsNotInvented) {
  const auto result = identify_ringdown(ringing({{440, 0.001, 0.01, 0.3}}, 16000, 0.5, 1e-4, 8, 0.1));
  ASSERT_EQ(result.partials.partials.size(), 1u) << result.message;
  EXPECT_EQ(result.partials.partials[0].kind, PartialKind::kTooShort);
  EXPECT_FALSE(result.partials.partials[0].decay_per_s.has_value());
}

TEST(RingdownTrust, LoopedNoiseIsRefusedUnlessAsked) {
  const Signal signal = looped_noise();
  const auto refused = identify_ringdown(signal);
  EXPECT_EQ(refused.status, RingdownStatus::kUnexplained);
  EXPECT_NE(refused.message.find("explain"), std::string::npos) << refused.message;
  RingdownOptions options;
  options.accept_unexplained = true;
  const auto accepted = identify_ringdown(signal, options);
  ASSERT_EQ(accepted.status, RingdownStatus::kOk);
  ASSERT_FALSE(accepted.warnings.empty());
  EXPECT_NE(accepted.warnings.front().find("explain"), std::string::npos) << accepted.warnings.front();
}

TEST(RingdownTrust, WhatLiesSixtyDecibelsBelowTheLoudestIsMarkedWeak) {
  auto partials = kBell;
  partials.push_back({5100, 10, 1e-4, 0});
  const auto result = identify_ringdown(ringing(partials, 44100, 2, 1e-6, 3, 0.1));
  const auto* weak = nearest(result.partials.partials, 5100);
  ASSERT_NE(weak, nullptr);
  EXPECT_NEAR(weak->frequency_hz, 5100, 0.1);
  EXPECT_EQ(weak->kind, PartialKind::kWeak);
}

TEST(RingdownTrust, TwoStagesOfADecayAreToldApart) {
  const auto result = identify_ringdown(ringing({{1000, 12, 0.2, 0.3}, {1000, 3, 0.1, 0.8}}, 44100, 2, 1e-5, 5, 0.1));
  ASSERT_EQ(result.partials.partials.size(), 2u) << result.message;
  std::vector<double> decays;
  for (const auto& partial : result.partials.partials) {
    EXPECT_NEAR(partial.frequency_hz, 1000, 0.05);
    ASSERT_TRUE(partial.decay_per_s.has_value());
    decays.push_back(*partial.decay_per_s);
  }
  std::sort(decays.begin(), decays.end());
  EXPECT_NEAR(decays[0], 3, 0.03);
  EXPECT_NEAR(decays[1], 12, 0.12);
}

TEST(RingdownTrust, LinesBesideOneThatWaversStay) {
  // A loud line of 1 kHz, whose pitch sinks by 1.5 Hz and whose level wavers, is the misfit; five clean lines stand 8 to 17 Hz beside it.
  const std::vector<TruePartial> clean{{986, 2.6, 0.003, 1.0},
                                       {991.2, 1.5, 0.004, 2.0},
                                       {1008.6, 1.9, 0.007, 0.4},
                                       {1013, 2.3, 0.006, -1.0},
                                       {1016.5, 1.3, 0.0055, 2.5}};
  Signal signal = ringing(clean, 16000, 1.9, 1e-6, 3, 0.1);
  for (Eigen::Index i = 1600; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / 16000 - 0.1;
    const double level = 0.2 * std::exp(-6 * t) * (1 + 0.3 * std::sin(2 * kPi * 2.3 * t));
    signal.samples(i, 0) += level * std::cos(2 * kPi * (1000 * t + 0.5 * (1 - std::exp(-3 * t))));
  }
  const auto result = identify_ringdown(signal);
  for (const TruePartial& truth : clean) {
    const auto* found = nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr) << result.message;
    EXPECT_NEAR(found->frequency_hz, truth.frequency_hz, 0.1);
    EXPECT_TRUE(found->is_ring());
  }
}

TEST(RingdownTrust, StagesAndBeatsAreNamed) {
  const auto ring = [](double hz, double decay, double amplitude) {
    klang::fit::Partial partial;
    partial.frequency_hz = hz;
    partial.frequency_std_hz = 0.01;
    partial.decay_per_s = decay;
    partial.amplitude = amplitude;
    return partial;
  };
  // Two stages of one line; a doublet; the same doublet, one of it 30 dB down; the same, gone before half a beat; a lone line.
  std::vector<klang::fit::Partial> partials{ring(500, 12, 0.2),   ring(500.02, 3, 0.1),  ring(800, 2, 0.1),
                                            ring(801.5, 3, 0.05), ring(1200, 2, 0.1),    ring(1201.5, 3, 0.003),
                                            ring(1600, 2, 0.1),   ring(1601.5, 15, 0.1), ring(3000, 4, 0.1)};
  klang::fit::name_pairs(partials);
  const std::vector<std::string> stages{"early", "late", "", "", "", "", "", "", ""};
  for (std::size_t i = 0; i < partials.size(); ++i) {
    EXPECT_EQ(partials[i].stage, stages[i]) << i;
    EXPECT_EQ(partials[i].beat_hz.has_value(), i == 2 || i == 3) << i;
  }
  EXPECT_NEAR(partials[2].beat_hz.value(), 1.5, 1e-9);
  EXPECT_NEAR(partials[3].beat_hz.value(), 1.5, 1e-9);
}

TEST(RingdownTrust, ALineBeyondTheBandsEdgeIsNoRestWithinIt) {
  const Signal signal = ringing({{600, 4, 0.01, 0.3}, {1003, 5, 0.2, 0.8}}, 44100, 2, 1e-6, 5, 0.1);
  RingdownOptions options;
  options.band = {100, 1000};
  const auto result = identify_ringdown(signal, options);
  ASSERT_EQ(result.status, RingdownStatus::kOk) << result.message;
  ASSERT_EQ(result.partials.partials.size(), 1u);
  EXPECT_NEAR(result.partials.partials[0].frequency_hz, 600, 0.01);
  EXPECT_GE(result.explained_energy.value(), 0.99);
}

TEST(RingdownTrust, StrikesOfSeveralBodiesAreWarnedOf) {
  const auto strikes = [](double second_hz) {
    Signal sound = ringing({{500, 30, 0.2, 0}}, 16000, 2, 1e-5, 7, 0.1);
    for (const auto& [hz, at_s] : {std::pair{second_hz, 0.7}, {500.0, 1.3}})
      sound.samples += ringing({{hz, 30, 0.2, 0}}, 16000, 2, 0, 7, at_s).samples;
    const auto result = identify_ringdown(sound);
    return !result.warnings.empty() && result.warnings.front().find("unlike") != std::string::npos;
  };
  EXPECT_FALSE(strikes(500));
  EXPECT_TRUE(strikes(1300));
}
