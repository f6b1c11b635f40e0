// Pitch constants of HF eq. (6) shared by several drops: recovered where a known rise makes them identifiable, and said to be
// entangled where none is given.
#include <gtest/gtest.h>

#include <fstream>

#include "core/foundation/base/errors.hpp"
#include "fit/bubble/pitch_fit.hpp"
#include "tests/fit/drop_signals.hpp"

namespace klang::fit::bubble {
namespace {

using tests::Drop;

std::vector<Drop> three_drops() {
  std::vector<Drop> drops(3);
  for (std::size_t i = 0; i < 3; ++i) {
    drops[i].radius_m = 0.0015 + 0.0007 * static_cast<double>(i);
    drops[i].onset_s = 0.05 + 0.2 * static_cast<double>(i);
    drops[i].depth_m = 0.007 + 0.002 * static_cast<double>(i);
    drops[i].speed_m_s = 0.2 + 0.05 * static_cast<double>(i);
  }
  return drops;
}

std::vector<BubbleRise> rises_of(const std::vector<Drop>& drops) {
  std::vector<BubbleRise> rises;
  for (const Drop& drop : drops) rises.push_back({drop.onset_s, {0.0}, {-drop.depth_m}, drop.speed_m_s});
  return rises;
}

const PitchNumber& named(const std::vector<PitchNumber>& numbers, const std::string& name) {
  for (const PitchNumber& number : numbers)
    if (number.name == name) return number;
  throw InputError("test", "no number of this name", name);
}

TEST(BubblePitch, ConstantsComeOutWithinTenPercentAndTheirIntervalsCover) {
  const auto drops = three_drops();
  const BubbleSearchOptions search;
  PitchFitOptions options;
  options.phi0_m = -drops[0].phi0_m;
  int n_covered = 0;
  constexpr unsigned kSeeds = 6;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const auto found = find_bubbles(tests::drop_sound(drops, 0.65, 44100.0, 30.0, seed), search);
    const auto fit = fit_pitch(found, rises_of(drops), search, options);
    ASSERT_EQ(fit.status, PitchStatus::kFitted) << fit.message;
    EXPECT_EQ(fit.n_bubbles, 3u);
    const PitchNumber &k = named(fit.parameters, "k_delta_per_m"), &eta = named(fit.parameters, "eta");
    ASSERT_TRUE(k.determined && eta.determined);
    EXPECT_LE(std::abs(*k.value / drops[0].k_per_m - 1.0), 0.1) << seed;
    EXPECT_LE(std::abs(*eta.value / drops[0].eta - 1.0), 0.1) << seed;
    n_covered += (*k.low95 <= drops[0].k_per_m && drops[0].k_per_m <= *k.high95) +
                 (*eta.low95 <= drops[0].eta && drops[0].eta <= *eta.high95);
    for (const double ratio : fit.chi_square_per_datum) EXPECT_LE(ratio, 1.5) << seed;
  }
  // Of twelve 95 % intervals three or more miss with probability 0.02.
  EXPECT_GE(n_covered, 10);
}

TEST(BubblePitch, WithoutPhi0OnlyTheTwoCombinationsAreGiven) {
  const auto drops = three_drops();
  const BubbleSearchOptions search;
  const auto fit =
      fit_pitch(find_bubbles(tests::drop_sound(drops, 0.65, 44100.0, 30.0, 1), search), rises_of(drops), search);
  ASSERT_EQ(fit.status, PitchStatus::kFitted);
  for (const PitchNumber& number : fit.parameters)
    EXPECT_FALSE(number.determined || number.value.has_value()) << number.name;
  EXPECT_LE(std::abs(*named(fit.identifiable, "eta / |phi0| [1/m]").value / 124.0 - 1.0), 0.1);
  EXPECT_LE(std::abs(*named(fit.identifiable, "k_delta * exp(eta) [1/m]").value / (72.95 * std::exp(1.24)) - 1.0), 0.1);
}

TEST(BubblePitch, SoundAloneGivesEachBubblesRateAndNoConstants) {
  const auto drops = three_drops();
  const BubbleSearchOptions search;
  const auto fit = fit_pitch(find_bubbles(tests::drop_sound(drops, 0.65, 44100.0, 30.0, 1), search), {}, search);
  EXPECT_EQ(fit.status, PitchStatus::kSoundOnly);
  for (const PitchNumber& number : fit.parameters)
    EXPECT_FALSE(number.determined || number.value.has_value()) << number.name;
  ASSERT_GE(fit.identifiable.size(), 3u);
  const Drop& last = drops.back();
  const double q = last.eta / last.phi0_m, rate = last.k_per_m * last.speed_m_s * std::exp(last.eta - q * last.depth_m);
  bool seen = false;
  for (const PitchNumber& number : fit.identifiable) seen |= std::abs(*number.value / rate - 1.0) <= 0.02;
  EXPECT_TRUE(seen) << rate;
}

TEST(BubblePitch, AFilmedRiseDoesAsWellAsAnEvenOne) {
  const auto drops = three_drops();
  std::vector<BubbleRise> filmed;
  for (const Drop& drop : drops) {
    filmed.push_back({drop.onset_s, {}, {}, 0.0});
    for (int i = 0; i <= 10; ++i) {
      filmed.back().times_s.push_back(0.003 * i);
      filmed.back().phi_m.push_back(-drop.depth(0.003 * i));
    }
  }
  const BubbleSearchOptions search;
  PitchFitOptions options;
  options.phi0_m = -0.01;
  const auto found = find_bubbles(tests::drop_sound(drops, 0.65, 44100.0, 30.0, 2), search);
  const auto a = fit_pitch(found, filmed, search, options), b = fit_pitch(found, rises_of(drops), search, options);
  ASSERT_EQ(a.status, PitchStatus::kFitted);
  EXPECT_LE(std::abs(*a.parameters[0].value / *b.parameters[0].value - 1.0), 0.01);
}

TEST(BubblePitch, RiseFilesAreReadAndBadOnesNamed) {
  const auto path = std::filesystem::path(testing::TempDir()) / "klang-rise.csv";
  std::ofstream(path) << "onset_s,phi_m,speed_m_s\n0.1,-0.01,0.2\n# a comment\n0.5,-0.012,0.25\n";
  EXPECT_EQ(read_rises(path).size(), 2u);
  std::ofstream(path) << "onset_s,time_s,phi_m\n0.1,0,-0.01\n0.1,0.01,-0.008\n0.5,0,-0.012\n0.5,0.01,-0.01\n";
  EXPECT_EQ(read_rises(path)[1].phi_m[1], -0.01);
  for (const char* bad :
       {"", "onset,phi\n", "onset_s,phi_m,speed_m_s\n0.1,0.01,0.2\n", "onset_s,phi_m,speed_m_s\n0.1,nan,0.2\n",
        "onset_s,time_s,phi_m\n0.1,0,-0.01\n", "onset_s,time_s,phi_m\n0.1,0,-0.01\n0.1,0,-0.01\n"}) {
    std::ofstream(path) << bad;
    EXPECT_THROW(read_rises(path), InputError) << bad;
  }
}

}  // namespace
}  // namespace klang::fit::bubble
