#include "core/sound/audio/spectral_distance.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"

using klang::kPi;
using klang::audio::Signal;
using klang::audio::SpectralDistance;
using klang::audio::SpectralDistanceOptions;

namespace {

Signal noise(double rate, double duration_s, std::uint64_t stream) {
  Signal signal{Eigen::MatrixXd::Zero(std::llround(rate * duration_s), 1), rate, "noise"};
  klang::RandomStream random(11, stream);
  for (double& x : signal.samples.reshaped()) x = 0.1 * random.normal();
  return signal;
}

/// Two decaying partials.
Signal ring(double rate, double duration_s, double second_amplitude) {
  Signal signal{Eigen::MatrixXd::Zero(std::llround(rate * duration_s), 1), rate, "ring"};
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / rate;
    signal.samples(i, 0) = 0.3 * std::exp(-4 * t) * std::sin(2 * kPi * 800 * t) +
                           second_amplitude * std::exp(-4 * t) * std::sin(2 * kPi * 3100 * t);
  }
  return signal;
}

}  // namespace

TEST(SpectralDistance, EqualSoundsAreAtZero) {
  const Signal sound = ring(44100.0, 0.6, 0.1);
  const SpectralDistance d = klang::audio::spectral_distance(sound, sound);
  EXPECT_EQ(d.log_spectral_db, 0.0);
  EXPECT_EQ(d.mel_db, 0.0);
  EXPECT_EQ(d.third_octave_db, 0.0);
  EXPECT_EQ(d.loudness_difference_db, 0.0);
  EXPECT_GT(d.n_frames, 30);
}

TEST(SpectralDistance, AGainIsItsDecibelsInEveryMeasureWhileAllIsAboveTheFloor) {
  const Signal reference = noise(32000.0, 1.0, 0);
  for (const double gain_db : {-6.0, 3.0}) {
    Signal sound = reference;
    sound.samples *= std::pow(10.0, gain_db / 20);
    SpectralDistanceOptions options;
    options.floor_db = -120.0;
    SpectralDistance d = klang::audio::spectral_distance(reference, sound, options);
    EXPECT_LE(std::abs(d.log_spectral_db - std::abs(gain_db)), 1e-3);
    EXPECT_LE(std::abs(d.mel_db - std::abs(gain_db)), 1e-3);
    EXPECT_LE(std::abs(d.third_octave_db - std::abs(gain_db)), 1e-6);
    EXPECT_LE(std::abs(d.loudness_difference_db - gain_db), 1e-9);
    options.align_level = true;
    d = klang::audio::spectral_distance(reference, sound, options);
    EXPECT_LE(d.log_spectral_db, 1e-3);
    EXPECT_LE(std::abs(d.loudness_difference_db), 1e-9);
    EXPECT_LE(std::abs(d.level_difference_db - gain_db), 1e-9);
  }
}

// The second partial is 6 dB lower: only its band, and of the whole energy exactly what a closed form says.
TEST(SpectralDistance, OneOfTwoTonesLowerShowsInItsBandAlone) {
  const SpectralDistance d = klang::audio::spectral_distance(ring(48000.0, 1.0, 0.2), ring(48000.0, 1.0, 0.1));
  for (const auto& band : d.third_octaves) {
    if (!band.difference_db) continue;
    if (band.band.index == 5) {
      EXPECT_LE(std::abs(*band.difference_db + 20 * std::log10(2.0)), 0.01);
    } else if (band.band.index == -1) {
      EXPECT_LE(std::abs(*band.difference_db), 0.01);
    }
  }
  EXPECT_LE(std::abs(d.level_difference_db - 10 * std::log10((0.09 + 0.01) / (0.09 + 0.04))), 0.01);
}

// Levels of independent white noise are 10 log10 of exponential variables; the difference of two has the standard deviation
// (10 / ln 10) sqrt(2 pi^2 / 6) = 7.88 dB (with a floor far below).
TEST(SpectralDistance, IndependentWhiteNoisesLieSevenPointNineDecibelsApart) {
  SpectralDistanceOptions options;
  options.floor_db = -120.0;
  const SpectralDistance d = klang::audio::spectral_distance(noise(32000.0, 4.0, 1), noise(32000.0, 4.0, 2), options);
  const double expected = 10 / std::log(10.0) * kPi / std::sqrt(3.0);
  EXPECT_LE(std::abs(d.log_spectral_db - expected), 0.1);
  EXPECT_LT(d.mel_db, 0.7 * expected);  // bands of many bins scatter less
  EXPECT_LE(d.third_octave_db, 0.8);
}

TEST(SpectralDistance, AnotherSampleRateOrTrailingSilenceChangesLittle) {
  const Signal reference = ring(44100.0, 1.2, 0.1);
  EXPECT_LE(klang::audio::spectral_distance(reference, ring(96000.0, 1.2, 0.1)).log_spectral_db, 0.1);
  Signal longer = reference;
  longer.samples.conservativeResize(3 * reference.n_frames(), 1);
  longer.samples.bottomRows(2 * reference.n_frames()).setZero();
  const SpectralDistance d = klang::audio::spectral_distance(reference, longer);
  EXPECT_EQ(d.log_spectral_db, 0.0);
  EXPECT_LE(std::abs(d.loudness_difference_db), 1e-4);
}

TEST(SpectralDistance, WhatLiesUnderTheFloorIsNotTold) {
  const Signal reference = ring(44100.0, 0.5, 0.1);
  Signal sound = reference;
  sound.samples += 1e-6 * noise(44100.0, 0.5, 4).samples;
  EXPECT_LE(klang::audio::spectral_distance(reference, sound).log_spectral_db, 0.01);
}

TEST(SpectralDistance, SilenceAndBadOptionsAreRefused) {
  const Signal sound = ring(44100.0, 0.3, 0.1);
  Signal silence = sound;
  silence.samples.setZero();
  EXPECT_THROW(klang::audio::spectral_distance(silence, sound), klang::InputError);
  EXPECT_THROW(klang::audio::spectral_distance(sound, silence), klang::InputError);
  SpectralDistanceOptions options;
  options.band = {19900.0, 20000.0};
  EXPECT_THROW(klang::audio::spectral_distance(sound, sound, options), klang::InputError);  // above 0.45 of 44100
  options = {};
  options.floor_db = 0.0;
  EXPECT_THROW(klang::audio::spectral_distance(sound, sound, options), klang::InputError);
}
