#include "core/sound/audio/stft.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/audio/fft.hpp"
#include "core/sound/audio/resample.hpp"

using klang::kPi;
using klang::audio::Signal;

namespace {

Signal sine(double frequency_hz, double amplitude, double rate, Eigen::Index n_frames) {
  Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples.resize(n_frames, 1);
  for (Eigen::Index i = 0; i < n_frames; ++i) {
    signal.samples(i, 0) = amplitude * std::cos(2 * kPi * frequency_hz * static_cast<double>(i) / rate + 0.4);
  }
  return signal;
}

}  // namespace

TEST(Fft, SpectrumMatchesTheDefinitionForAnyLength) {
  for (const Eigen::Index n : {1, 2, 7, 30, 97}) {
    Eigen::VectorXd x(n);
    klang::RandomStream random(3, static_cast<std::uint64_t>(n));
    for (double& v : x) v = random.normal();
    const Eigen::VectorXcd spectrum = klang::audio::real_spectrum(x, n);
    for (Eigen::Index k = 0; k <= n / 2; ++k) {
      std::complex<double> sum = 0;
      for (Eigen::Index m = 0; m < n; ++m) {
        sum += x[m] * std::polar(1.0, -2 * kPi * static_cast<double>(k * m) / static_cast<double>(n));
      }
      EXPECT_LE(std::abs(spectrum[k] - sum), 1e-12 * static_cast<double>(n)) << n << " " << k;
    }
    EXPECT_LE((klang::audio::real_from_spectrum(spectrum, n) - x).norm(), 1e-13 * static_cast<double>(n));
  }
}

TEST(Fft, GoodSizesHaveOnlySmallPrimes) {
  EXPECT_EQ(klang::audio::good_fft_size(97), 100);
  EXPECT_EQ(klang::audio::good_fft_size_below(97), 96);
  EXPECT_EQ(klang::audio::good_fft_size(1), 1);
}

TEST(Stft, ASineOfAmplitudeOneIsAtZeroDecibels) {
  klang::audio::StftOptions options;
  options.window_s = 0.02;
  const auto picture = klang::audio::spectrogram(sine(1000, 1.0, 48000, 48000), options);
  const Eigen::Index middle = picture.level_db.cols() / 2;
  Eigen::Index peak = 0;
  EXPECT_NEAR(picture.level_db.col(middle).maxCoeff(&peak), 0.0, 0.01);
  EXPECT_DOUBLE_EQ(picture.frequencies_hz[static_cast<std::size_t>(peak)], 1000.0);
  EXPECT_EQ(picture.level_db.cols(), static_cast<Eigen::Index>(picture.times_s.size()));
  EXPECT_EQ(picture.level_db.rows(), static_cast<Eigen::Index>(picture.frequencies_hz.size()));
}

TEST(Stft, TimeOfAClickIsKeptToHalfAHop) {
  Signal click = sine(0, 0, 8000, 8000);
  click.samples(5600, 0) = 1;
  klang::audio::StftOptions options;
  options.window_s = 0.01;
  options.hop_s = 0.002;
  const auto result = klang::audio::stft(click, options);
  Eigen::Index best = 0;
  result.power.colwise().sum().maxCoeff(&best);
  EXPECT_NEAR(result.times_s[static_cast<std::size_t>(best)], 0.7, 0.00101);
}

TEST(Stft, SeveralResolutionsComeShortestFirstAndSplitAPairOnlyWhenLong) {
  Signal pair = sine(1000, 1, 16000, 16000);
  pair.samples += sine(1020, 1, 16000, 16000).samples;
  const auto all = klang::audio::multi_resolution_stft(pair, {0.4, 0.02});
  ASSERT_EQ(all.size(), 2u);
  EXPECT_NEAR(all[0].frequencies_hz[1], 50.0, 1e-9);
  EXPECT_NEAR(all[1].frequencies_hz[1], 2.5, 1e-9);
  const auto& fine = all[1];
  const Eigen::Index t = fine.power.cols() / 2;
  EXPECT_LE(fine.power(404, t), 0.05 * fine.power(400, t));  // 1010 Hz against 1000 Hz
}

TEST(Stft, LongSignalsGetALongerHopInsteadOfMoreFrames) {
  klang::audio::StftOptions options;
  options.max_frames = 100;
  EXPECT_LE(klang::audio::stft(sine(100, 1, 8000, 80000), options).power.cols(), 100);
}

TEST(Stft, ShortSignalsAndBadOptionsAreHandled) {
  EXPECT_EQ(klang::audio::stft(sine(100, 1, 8000, 1)).power.cols(), 1);
  klang::audio::StftOptions options;
  options.window_s = std::nan("");
  EXPECT_THROW(klang::audio::stft(sine(100, 1, 8000, 100), options), klang::InputError);
  Signal none;
  none.sample_rate_hz = 8000;
  EXPECT_THROW(klang::audio::stft(none), klang::InputError);
}

TEST(Resample, ASineKeepsItsFrequencyAmplitudeAndTime) {
  const Signal resampled = klang::audio::resample(sine(1000, 0.5, 96000, 96000), 44100);
  const Signal expected = sine(1000, 0.5, 44100, 44100);
  ASSERT_EQ(resampled.n_frames(), 44100);
  const Eigen::VectorXd error = resampled.samples.col(0) - expected.samples.col(0);
  EXPECT_LE(error.segment(2000, 40000).cwiseAbs().maxCoeff(), 5e-5);  // 80 dB below the sine
}

TEST(Resample, WhatLiesAboveHalfTheNewRateIsGone) {
  const Signal resampled = klang::audio::resample(sine(30000, 1, 96000, 96000), 44100);
  EXPECT_LE(resampled.samples.middleRows(2000, 40000).cwiseAbs().maxCoeff(), 1e-4);
}
