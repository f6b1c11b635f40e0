/// Recordings on which partials were once lost or invented (tests/data/sound).
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/sound/audio/sound_file.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "tests/fit/ringdown_signals.hpp"
#include "tests/places.hpp"

using klang::kPi;
using klang::audio::Signal;
using klang::fit::identify_ringdown;
using klang::fit::RingdownResult;
using klang::fit::RingdownStatus;
using klang::tests::nearest;
using klang::tests::ringing;
using klang::tests::TruePartial;

namespace {

RingdownResult analysed(const std::string& name) {
  return identify_ringdown(klang::audio::read_sound(klang::test::test_data() + "/sound/" + name));
}

bool warns_of_the_unexplained(const RingdownResult& result) {
  return !result.warnings.empty() && result.warnings.front().find("explain") != std::string::npos;
}

/// All of them within 0.05 % of frequency and 5 % of decay.
void expect_partials(const std::string& name, const std::vector<TruePartial>& truths) {
  const RingdownResult result = analysed(name);
  ASSERT_EQ(result.status, RingdownStatus::kOk) << name << ": " << result.message;
  for (const TruePartial& truth : truths) {
    const auto* found = nearest(result.partials.partials, truth.frequency_hz);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_NEAR(found->frequency_hz, truth.frequency_hz, 5e-4 * truth.frequency_hz) << name;
    ASSERT_TRUE(found->decay_per_s.has_value()) << name << " " << truth.frequency_hz;
    EXPECT_NEAR(*found->decay_per_s, truth.decay_per_s, 0.05 * truth.decay_per_s) << name << " " << truth.frequency_hz;
  }
}

}  // namespace

// loudest_partial_lost_glass
TEST(RingdownFiles, GlassesOfWaterKeepTheirLoudestRing) {
  for (const auto& [name, loudest_hz] : {std::pair{"glass-B4_04.flac", 493.4},
                                         {"glass-D5_01.flac", 587.5},
                                         {"glass-E6_01.flac", 1319.1},
                                         {"glass-F6_01.flac", 1397.8}}) {
    const RingdownResult result = analysed(name);
    ASSERT_EQ(result.status, RingdownStatus::kOk) << name << ": " << result.message;
    const auto* found = nearest(result.partials.partials, loudest_hz);
    ASSERT_NE(found, nullptr) << name;
    EXPECT_NEAR(found->frequency_hz, loudest_hz, 0.006 * loudest_hz) << name;
    EXPECT_TRUE(result.explained_energy.value() >= 0.9 || warns_of_the_unexplained(result)) << name;
  }
}

// loudest_partial_lost_lossy
TEST(RingdownFiles, LossyFilesKeepTheirPartials) {
  const std::vector<TruePartial> three{{1000, 5, 0, 0}, {2730, 9, 0, 0}, {5300, 20, 0, 0}};
  expect_partials("ring.ogg", three);
  expect_partials("ring.mp3", three);
  expect_partials("five-a.ogg", {{1507.5044, 6.8476, 0, 0},
                                 {3156.2531, 19.8881, 0, 0},
                                 {5707.9393, 7.6578, 0, 0},
                                 {6781.6484, 28.1805, 0, 0},
                                 {8233.8029, 20.7882, 0, 0}});
  expect_partials("five-b.ogg", {{1107.2465, 4.0596, 0, 0},
                                 {4865.4526, 28.9270, 0, 0},
                                 {4909.3389, 29.1172, 0, 0},
                                 {6996.8245, 7.7588, 0, 0},
                                 {9863.7379, 6.3025, 0, 0}});
}

TEST(RingdownFiles, ACodersImagesOfALineAreNoPartials) {
  const RingdownResult result = analysed("ring.ogg");
  for (const auto& partial : result.partials.partials) {
    // +-1000 Hz + k 48 kHz / 1024
    const double image = std::abs(std::remainder(partial.frequency_hz + 1000, 46.875));
    EXPECT_TRUE(image > 0.01 || partial.kind == klang::fit::PartialKind::kWeak) << partial.frequency_hz;
  }
  EXPECT_LE(result.partials.partials.size(), 6u);
}

TEST(RingdownFiles, HumHasNoDecay) {
  expect_partials("hum.flac", {{433, 27, 0, 0}, {909, 17, 0, 0}, {2262, 22, 0, 0}, {4688.7, 27, 0, 0}});
  const RingdownResult result = analysed("hum.flac");
  for (const auto& partial : result.partials.partials)
    EXPECT_TRUE(partial.frequency_hz > 200 || !partial.decay_per_s) << partial.frequency_hz;
}

TEST(RingdownFiles, ALineThatWaversIsNotLost) {
  // Water sloshes in a glass: pitch and level of its line waver 5.6 times a second. No exponential fits it well.
  for (const double depth : {0.2, 0.5, 0.9}) {
    Signal signal = ringing({{2390, 9, 0.05, 1}, {4490, 25, 0.05, 2}}, 44100, 0.99, 1e-4, 3, 0.15);
    for (Eigen::Index i = 6615; i < signal.n_frames(); ++i) {
      const double t = static_cast<double>(i) / 44100 - 0.15, slosh = 2 * kPi * 5.6 * t;
      signal.samples(i, 0) += 0.05 * std::exp(-2.3 * t) * (1 + 0.5 * depth * std::cos(slosh + 1)) *
                              std::cos(2 * kPi * 1049 * t + depth * std::sin(slosh));
    }
    const RingdownResult result = identify_ringdown(signal);
    const auto* found = nearest(result.partials.partials, 1049);
    ASSERT_NE(found, nullptr) << depth << ": " << result.message;
    EXPECT_NEAR(found->frequency_hz, 1049, 6) << depth;
  }
}
