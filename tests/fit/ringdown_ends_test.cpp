// Rings that do not end by themselves, and takes that are copies of one another.
#include <gtest/gtest.h>

#include <string>
#include <utility>

#include "core/sound/audio/sudden_end.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/fit/ringdown_signals.hpp"

namespace klang::fit {
namespace {

const std::vector<tests::TruePartial> kBar{{590.2, 1.4, 0.2, 0.3}, {1581.4, 5.7, 0.1, 1.0}, {2981.4, 18.0, 0.05, 2.0}};

/// n taps of the bar, 1.2 s each, multiplied by fade(seconds since the tap), then noise of its own for each.
template <typename Fade>
audio::Signal taps(int n, double noise_rms, Fade fade) {
  constexpr double kRate = 44100, kEach = 1.2, kStrike = 0.1;
  audio::Signal all;
  all.sample_rate_hz = kRate;
  const auto frames = static_cast<Eigen::Index>(kEach * kRate);
  all.samples.resize(n * frames, 1);
  for (int k = 0; k < n; ++k) {
    std::vector<tests::TruePartial> struck = kBar;
    for (tests::TruePartial& p : struck) p.amplitude *= 1 - 0.1 * k;
    audio::Signal one = tests::ringing(struck, kRate, kEach, 0, 1, kStrike);
    RandomStream random(static_cast<std::uint64_t>(k) + 7, 1);
    for (Eigen::Index i = 0; i < frames; ++i) {
      const double t = static_cast<double>(i) / kRate - kStrike;
      one.samples(i, 0) = one.samples(i, 0) * fade(t) + noise_rms * random.normal();
    }
    all.samples.middleRows(k * frames, frames) = one.samples;
  }
  return all;
}

double linear_fade(double t, double begin_s, double length_s) {
  return std::clamp(1 - (t - begin_s) / length_s, 0.0, 1.0);
}

bool says(const RingdownResult& result, const std::string& what) {
  return std::any_of(result.warnings.begin(), result.warnings.end(),
                     [&](const std::string& warning) { return warning.find(what) != std::string::npos; });
}

void expect_bar(const RingdownResult& result, double deviations) {
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_EQ(result.partials.partials.size(), kBar.size());
  for (const tests::TruePartial& truth : kBar) {
    const Partial* found = tests::nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr);
    ASSERT_TRUE(found->decay_per_s && found->decay_std_per_s && found->frequency_std_hz);
    EXPECT_LE(std::abs(found->frequency_hz - truth.frequency_hz), deviations * *found->frequency_std_hz);
    EXPECT_LE(std::abs(*found->decay_per_s - truth.decay_per_s), deviations * *found->decay_std_per_s);
  }
}

TEST(RingdownEnds, AFadeAGateAndAHandAtTheEndDoNotBiasTheDecays) {
  const auto fade = taps(4, 1e-4, [](double t) { return linear_fade(t, 0.9, 0.01); });
  const auto hand = taps(4, 1e-4, [](double t) { return t < 0.8 ? 1.0 : std::exp(-60 * (t - 0.8)); });
  const auto gate = taps(4, 1e-4, [](double t) { return t < 0.85 ? 1.0 : std::exp(-400 * (t - 0.85)); });
  for (const auto& [recording, how] : {std::pair(&fade, "fade"), std::pair(&hand, "hand"), std::pair(&gate, "gate")}) {
    SCOPED_TRACE(how);
    const RingdownResult result = identify_ringdown(*recording, {});
    expect_bar(result, 4);
    EXPECT_EQ(result.strikes_s.size(), 4U);
    EXPECT_TRUE(says(result, "4 of 4 rings end suddenly"));
  }
}

TEST(RingdownEnds, AFadeUpToTheLastSampleIsSeen) {
  audio::Signal recording = taps(1, 1e-5, [](double t) { return linear_fade(t, 1.09, 0.01); });
  const RingdownResult result = identify_ringdown(recording, {});
  expect_bar(result, 4);
  EXPECT_TRUE(says(result, "the ring ends suddenly"));
}

TEST(RingdownEnds, RingsThatDieBeatOrEndWithTheFileAreLeftWhole) {
  const auto whole = [](const std::vector<tests::TruePartial>& partials, double duration_s, double noise_rms) {
    const audio::Signal x = tests::ringing(partials, 48000, duration_s, noise_rms, 3);
    return !audio::sudden_end(x.samples, 48000).has_value();
  };
  EXPECT_TRUE(whole(kBar, 1.0, 1e-4));
  EXPECT_TRUE(whole(kBar, 8.0, 1e-3));                                       // dies in noise
  EXPECT_TRUE(whole({{400, 1, 0.1, 0}, {404, 1, 0.1, 0}}, 0.9, 1e-5));       // beats, the last one is not over
  EXPECT_TRUE(whole({{400, 1, 0.1, 0}, {400.5, 1, 0.1, 0}}, 1.0, 1e-5));     // ends in a slow beat's null
  EXPECT_TRUE(whole({{25, 2, 0.3, 0}}, 1.0, 1e-5));                          // a period is 40 ms
  EXPECT_TRUE(whole({{60, 3, 0.3, 0}, {2000, 400, 0.5, 1}}, 1.0, 1e-5));     // a short loud part, then the low one
  EXPECT_TRUE(whole({{3000, 600, 0.9, 1}, {900, 2, 0.001, 0}}, 1.0, 1e-6));  // a weak ring under a loud short one
  EXPECT_TRUE(whole({{700, 3, 0.1, 0}}, 1.0, 0.0));
}

TEST(RingdownEnds, WhatTheSecondStrikeAloneExcitesIsNotWeak) {
  audio::Signal recording = tests::ringing({{600, 3, 0.3, 0}}, 44100, 1.6, 1e-5, 5, 0.0);
  const audio::Signal second = tests::ringing({{600, 3, 1.0, 0}, {1500, 5, 0.6, 1}}, 44100, 1.6, 0, 6, 0.6);
  recording.samples = 0.5 * (recording.samples + second.samples);
  const RingdownResult result = identify_ringdown(recording, {});
  const Partial* found = tests::nearest(result.partials.partials, 1500);
  ASSERT_NE(found, nullptr);
  EXPECT_NEAR(found->frequency_hz, 1500, 0.1);
  EXPECT_EQ(found->kind, PartialKind::kDecaying);
}

TEST(RingdownEnds, ATakePastedAgainIsNoSurerThanOne) {
  const audio::Signal one = taps(1, 1e-3, [](double) { return 1.0; });
  audio::Signal pasted = one;
  pasted.samples.resize(8 * one.n_frames(), 1);
  for (Eigen::Index k = 0; k < 8; ++k)
    pasted.samples.middleRows(k * one.n_frames(), one.n_frames()) = (1 - 0.05 * static_cast<double>(k)) * one.samples;
  const RingdownResult single = identify_ringdown(one, {}), many = identify_ringdown(pasted, {});
  expect_bar(many, 4);
  EXPECT_TRUE(says(many, "one take pasted again"));
  for (const tests::TruePartial& truth : kBar) {
    const Partial* a = tests::nearest(single.partials.partials, truth.frequency_hz);
    const Partial* b = tests::nearest(many.partials.partials, truth.frequency_hz);
    // The copies' noise is as loud as they are, and their mean weighs them all alike: not to the digit.
    EXPECT_LE(std::abs(*b->frequency_std_hz / *a->frequency_std_hz - 1), 0.3);
    EXPECT_LE(std::abs(*b->decay_std_per_s / *a->decay_std_per_s - 1), 0.3);
  }
  const audio::Signal fresh = taps(8, 1e-3, [](double) { return 1.0; });
  EXPECT_FALSE(says(identify_ringdown(fresh, {}), "pasted"));
}

}  // namespace
}  // namespace klang::fit
