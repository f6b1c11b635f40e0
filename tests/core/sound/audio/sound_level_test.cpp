#include "core/sound/audio/sound_level.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"

using klang::kPi;
using klang::audio::Signal;

namespace {

Signal tone(double frequency_hz, double amplitude, double rate, double duration_s) {
  Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples.resize(std::llround(rate * duration_s), 1);
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    signal.samples(i, 0) = amplitude * std::sin(2 * kPi * frequency_hz * static_cast<double>(i) / rate);
  }
  return signal;
}

}  // namespace

// IEC 61672-1:2013, table 3, given to 0.1 dB at the exact base-10 frequencies.
TEST(AWeighting, FollowsTheTableOfTheStandard) {
  const std::array<double, 34> table = {-70.4, -63.4, -56.7, -50.5, -44.7, -39.4, -34.6, -30.2, -26.2,
                                        -22.5, -19.1, -16.1, -13.4, -10.9, -8.6,  -6.6,  -4.8,  -3.2,
                                        -1.9,  -0.8,  0.0,   0.6,   1.0,   1.2,   1.3,   1.2,   1.0,
                                        0.5,   -0.1,  -1.1,  -2.5,  -4.3,  -6.6,  -9.3};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double frequency_hz = std::pow(10.0, 1.0 + 0.1 * static_cast<double>(i));
    EXPECT_LE(std::abs(klang::audio::a_weighting_db(frequency_hz) - table[i]), 0.0501 + 1e-9) << frequency_hz;
  }
  EXPECT_EQ(klang::audio::a_weighting_db(1000.0), 0.0);
}

TEST(ThirdOctaves, AudibleBandHoldsTwentyNineBandsThatTouch) {
  const auto bands = klang::audio::third_octaves({20.0, 20000.0});
  ASSERT_EQ(bands.size(), 29u);  // 25 Hz to 16 kHz: the bands of 20 Hz and 20 kHz reach beyond
  EXPECT_EQ(bands.front().index, -16);
  EXPECT_LE(std::abs(bands.front().centre_hz() - 25.1188643150958), 1e-10);
  EXPECT_LE(std::abs(bands.back().centre_hz() - 15848.9319246111), 1e-8);
  for (std::size_t i = 1; i < bands.size(); ++i) EXPECT_EQ(bands[i].low_hz(), bands[i - 1].high_hz());
  EXPECT_EQ(klang::audio::third_octaves({bands[3].low_hz(), bands[7].high_hz()}).size(), 5u);
  EXPECT_TRUE(klang::audio::third_octaves({900.0, 1000.0}).empty());
}

TEST(ThirdOctaves, BandsAreRefusedOutOfOrder) {
  EXPECT_THROW(klang::audio::third_octaves({0.0, 100.0}), klang::InputError);
  EXPECT_THROW(klang::audio::third_octaves({200.0, 100.0}), klang::InputError);
}

TEST(SoundLevel, TwoTonesHaveTheirLevelsInTheirBandsAndNothingElsewhere) {
  Signal signal = tone(1000.0, 0.5, 48000.0, 1.0);
  signal.samples += tone(4000.0, 0.05, 48000.0, 1.0).samples;
  const auto bands = klang::audio::third_octaves({100.0, 12000.0});
  const auto levels = klang::audio::third_octave_levels_db(signal, bands);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    if (bands[i].index == 0) {
      EXPECT_LE(std::abs(levels[i] - 20 * std::log10(0.5)), 0.01);
    } else if (bands[i].index == 6) {
      EXPECT_LE(std::abs(levels[i] - 20 * std::log10(0.05)), 0.01);
    } else {
      EXPECT_LE(levels[i], -40.0) << bands[i].index;
    }
  }
}

TEST(SoundLevel, EnergyOfAllBinsIsTheEnergyOfTheSamples) {
  for (const Eigen::Index n : {5, 1000, 48001}) {
    Signal signal{Eigen::MatrixXd::Zero(n, 2), 8000.0, "noise"};
    klang::RandomStream random(3, static_cast<std::uint64_t>(n));
    for (double& x : signal.samples.reshaped()) x = random.normal();
    const double expected = signal.samples.squaredNorm() / (2 * 8000.0);
    EXPECT_LE(std::abs(klang::audio::EnergySpectrum(signal).total() - expected), 1e-12 * expected);
  }
}

// The A weights of two tones add as energies; 100 Hz is 19.145 dB down.
TEST(SoundLevel, AWeightedLevelOfTwoTonesIsTheWeightedSum) {
  Signal signal = tone(1000.0, 0.1, 44100.0, 2.0);
  EXPECT_LE(std::abs(klang::audio::a_weighted_level_db(signal) + 20.0), 0.002);
  signal.samples += tone(100.0, 1.0, 44100.0, 2.0).samples;
  const double expected = 10 * std::log10(0.01 + std::pow(10.0, 0.1 * klang::audio::a_weighting_db(100.0)));
  EXPECT_LE(std::abs(klang::audio::a_weighted_level_db(signal) - expected), 0.01);
}

// White noise of variance s^2 has the energy density 2 s^2 / rate: third octaves rise by 1 dB a band.
TEST(SoundLevel, WhiteNoiseRisesByOneDecibelAThirdOctave) {
  Signal signal{Eigen::MatrixXd::Zero(48000 * 20, 1), 48000.0, "noise"};
  klang::RandomStream random(7, 0);
  for (double& x : signal.samples.reshaped()) x = 0.1 * random.normal();
  const auto bands = klang::audio::third_octaves({500.0, 20000.0});
  const auto levels = klang::audio::third_octave_levels_db(signal, bands);
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double width_hz = bands[i].high_hz() - bands[i].low_hz();
    const double expected = 10 * std::log10(2 * 0.01 * width_hz / 24000.0);
    const double std_db = 10 / std::log(10.0) / std::sqrt(width_hz * 20.0);
    EXPECT_LE(std::abs(levels[i] - expected), 5 * std_db) << bands[i].centre_hz();
  }
}

TEST(SoundLevel, SilenceIsMinusInfinityAndNoSamplesAreRefused) {
  EXPECT_EQ(klang::audio::a_weighted_level_db(tone(100.0, 0.0, 8000.0, 0.1)), -std::numeric_limits<double>::infinity());
  EXPECT_THROW(klang::audio::a_weighted_level_db(tone(100.0, 1.0, 8000.0, 0.0)), klang::InputError);
  EXPECT_THROW(klang::audio::a_weighted_level_db(tone(100.0, NAN, 8000.0, 0.1)), klang::InputError);
}

TEST(SoundLevel, GainBringsThePeakToItsLevelAndLeavesWhatNobodyHears) {
  EXPECT_NEAR(klang::audio::file_gain(0.5, -6.0) * 0.5, std::pow(10.0, -0.3), 1e-15);
  const double quietest = 20e-6 * std::sqrt(2.0);
  EXPECT_NEAR(klang::audio::file_gain(1e-13, 0.0) * quietest, 1.0, 1e-12);
  EXPECT_NEAR(klang::audio::file_gain(0.0, 0.0) * quietest, 1.0, 1e-12);
  EXPECT_TRUE(klang::audio::is_inaudible(1e-13));
  EXPECT_FALSE(klang::audio::is_inaudible(0.0)) << "silence is not quiet by error";
  EXPECT_FALSE(klang::audio::is_inaudible(3e-5));
}
