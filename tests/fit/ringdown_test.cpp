#include "fit/ringdown/ringdown.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "tests/fit/ringdown_signals.hpp"

using klang::kPi;
using klang::audio::Signal;
using klang::fit::identify_ringdown;
using klang::fit::RingdownResult;
using klang::fit::RingdownStatus;
using klang::tests::nearest;
using klang::tests::ringing;
using klang::tests::TruePartial;

namespace {

std::vector<TruePartial> twelve() {
  return {{312, 1.2, 0.1, 0.3},  {587, 1.5, 0.1, 1.1},   {830, 2.0, 0.1, -2.0},  {1100, 2.2, 0.1, 2.5},
          {1490, 3.0, 0.1, 0.0}, {1492, 3.3, 0.1, -1.2}, {2210, 4.0, 0.1, 0.7},  {2950, 5.0, 0.1, -0.4},
          {3700, 7.0, 0.1, 1.9}, {4800, 9.0, 0.1, -2.9}, {6100, 12.0, 0.1, 3.0}, {9000, 20.0, 0.1, -1.7}};
}

/// Smallest standard deviations of (f, decay) that any unbiased estimator can reach (Cramer-Rao), all samples
/// used.
Eigen::Vector2d cramer_rao_std(const TruePartial& p, double rate, double duration_s, double noise_rms) {
  const auto n = static_cast<Eigen::Index>(duration_s * rate + 0.5);
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / rate;
    const double e = std::exp(-p.decay_per_s * t), angle = 2 * kPi * p.frequency_hz * t + p.phase_rad;
    const Eigen::Vector4d slope(-p.amplitude * e * 2 * kPi * t * std::sin(angle),
                                -p.amplitude * e * t * std::cos(angle), e * std::cos(angle),
                                -p.amplitude * e * std::sin(angle));
    information += slope * slope.transpose();
  }
  const Eigen::Matrix4d covariance = information.inverse() * noise_rms * noise_rms;
  return {std::sqrt(covariance(0, 0)), std::sqrt(covariance(1, 1))};
}

}  // namespace

TEST(Ringdown, TwelvePartialsWithAPairTwoHertzApartAreAllFoundAndNoneInvented) {
  const auto truth = twelve();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto result = identify_ringdown(ringing(truth, 48000, 3, 1e-3, seed, 0.1));
    ASSERT_EQ(result.status, RingdownStatus::kOk) << result.message;
    ASSERT_EQ(result.partials.partials.size(), truth.size());
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const auto& found = result.partials.partials[i];
      EXPECT_NEAR(found.frequency_hz, truth[i].frequency_hz, 0.05);
      EXPECT_NEAR(*found.decay_per_s, truth[i].decay_per_s, 0.05 * truth[i].decay_per_s);
      EXPECT_NEAR(*found.amplitude, truth[i].amplitude, 0.05 * truth[i].amplitude);
    }
    ASSERT_EQ(result.strikes_s.size(), 1u);
    EXPECT_NEAR(result.strikes_s[0], 0.1, 5e-4);
    EXPECT_GE(result.explained_energy.value(), 0.99);
  }
}

TEST(Ringdown, WhiteNoiseAndHumGiveNoPartialsAndSilenceIsBadInput) {
  const auto noise = identify_ringdown(ringing({}, 48000, 2, 0.1, 5));
  EXPECT_EQ(noise.status, RingdownStatus::kNothingFound);
  EXPECT_FALSE(noise.message.empty());
  EXPECT_THROW(identify_ringdown(ringing({}, 48000, 1, 0.0, 5)), klang::InputError);
  const auto hum = identify_ringdown(ringing({{50, 0, 0.1, 0}, {150, 0, 0.03, 1}}, 48000, 3, 1e-3, 6));
  EXPECT_EQ(hum.status, RingdownStatus::kNothingFound);
  EXPECT_EQ(hum.steady_tones.size(), 2u);
}

TEST(Ringdown, TooFewSamplesNotANumberAndBadOptionsAreBadInput) {
  EXPECT_THROW(identify_ringdown(ringing({}, 48000, 15.0 / 48000, 0.1, 1)), klang::InputError);
  EXPECT_THROW(identify_ringdown(Signal{}), klang::InputError);
  Signal bad = ringing({}, 8000, 0.1, 0.1, 1);
  bad.samples(10, 0) = std::nan("");
  EXPECT_THROW(identify_ringdown(bad), klang::InputError);
  klang::fit::RingdownOptions options;
  options.min_snr_db = std::nan("");
  EXPECT_THROW(identify_ringdown(ringing({}, 8000, 0.1, 0.1, 1), options), klang::InputError);
}

TEST(Ringdown, SamplesWhoseSquaresAreNoNumbersAreBadInput) {
  Signal signal = klang::tests::ringing({{1000, 5, 0.1, 0}}, 44100, 0.5, 1e-3, 3);
  signal.samples(3000, 0) = 1e200;  // its energy overflows: no channel can be chosen
  EXPECT_THROW(identify_ringdown(signal), klang::InputError);
  signal.samples = 1e-200 * klang::tests::ringing({{1000, 5, 0.1, 0}}, 44100, 0.5, 1e-3, 3).samples;  // underflows
  EXPECT_THROW(identify_ringdown(signal), klang::InputError);
}

TEST(Ringdown, OnePartialInNoiseReachesTheCramerRaoBoundAndKnowsItsScatter) {
  const TruePartial truth{1000.3, 8, 0.1, 0.7};
  constexpr double kRate = 16000, kDuration = 0.5;
  for (const double snr_db : {20.0, 40.0, 60.0}) {
    const double noise_rms = truth.amplitude / std::sqrt(2.0) * std::pow(10, -snr_db / 20);
    constexpr std::size_t kSeeds = 200;
    std::vector<klang::fit::Partial> found(kSeeds);
    klang::for_each_job(kSeeds, [&](std::size_t seed) {
      const auto result = identify_ringdown(ringing({truth}, kRate, kDuration, noise_rms, 100 + seed));
      if (result.partials.partials.size() == 1) found[seed] = result.partials.partials[0];
    });
    double f = 0, d = 0, f_std = 0, d_std = 0, f_bias = 0;
    for (const auto& partial : found) {
      ASSERT_NEAR(partial.frequency_hz, truth.frequency_hz, 1.0) << snr_db << " dB: missed or not alone";
      f += std::pow(partial.frequency_hz - truth.frequency_hz, 2) / kSeeds;
      d += std::pow(*partial.decay_per_s - truth.decay_per_s, 2) / kSeeds;
      f_std += std::pow(*partial.frequency_std_hz, 2) / kSeeds;
      d_std += std::pow(*partial.decay_std_per_s, 2) / kSeeds;
      f_bias += (partial.frequency_hz - truth.frequency_hz) / kSeeds;
    }
    const Eigen::Vector2d bound = cramer_rao_std(truth, kRate, kDuration, noise_rms);
    EXPECT_LE(std::sqrt(f), 1.5 * bound[0]) << snr_db;
    EXPECT_LE(std::sqrt(d), 1.5 * bound[1]) << snr_db;
    EXPECT_LE(std::abs(std::sqrt(f_std / f) - 1), 0.25) << snr_db;
    EXPECT_LE(std::abs(std::sqrt(d_std / d) - 1), 0.25) << snr_db;
    EXPECT_LE(std::abs(f_bias), 4 * bound[0] / std::sqrt(200.0)) << snr_db;
    RecordProperty("frequency_over_bound_" + std::to_string(static_cast<int>(snr_db)),
                   std::to_string(std::sqrt(f) / bound[0]));
    RecordProperty("decay_over_bound_" + std::to_string(static_cast<int>(snr_db)),
                   std::to_string(std::sqrt(d) / bound[1]));
    RecordProperty("reported_over_scatter_" + std::to_string(static_cast<int>(snr_db)),
                   std::to_string(std::sqrt(f_std / f)) + " " + std::to_string(std::sqrt(d_std / d)));
  }
}
