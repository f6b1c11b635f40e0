#include "core/sound/audio/strikes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"

using klang::kPi;
using klang::audio::detect_strikes;
using klang::audio::Signal;

namespace {

/// Three partials struck at the given times (amplitude 0.2 each) in white noise.
Signal struck(const std::vector<double>& times_s, double noise_rms, double rate, double duration_s) {
  Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples.resize(static_cast<Eigen::Index>(duration_s * rate), 1);
  klang::RandomStream random(11, 0);
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / rate;
    double x = noise_rms * random.normal();
    for (const double strike : times_s) {
      if (t < strike) continue;
      for (const double f : {620.0, 1730.0, 3350.0}) {
        x += 0.2 * std::exp(-f / 400 * (t - strike)) * std::sin(2 * kPi * f * (t - strike));
      }
    }
    signal.samples(i, 0) = x;
  }
  return signal;
}

}  // namespace

TEST(Strikes, TimesAreFoundToHalfAMillisecondFrom8To192Kilohertz) {
  const std::vector<double> truth{0.2134, 0.8712, 1.6};
  for (const double rate : {8000.0, 48000.0, 192000.0}) {
    const auto strikes = detect_strikes(struck(truth, 1e-3, rate, 2.2));
    ASSERT_EQ(strikes.size(), 3u) << rate;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(strikes[i].time_s, truth[i], 5e-4) << rate;
      EXPECT_GE(strikes[i].settled_s, strikes[i].time_s);
      EXPECT_LE(strikes[i].settled_s, strikes[i].time_s + 0.012);
    }
  }
}

TEST(Strikes, ABeatingPairIsOneStrike) {
  Signal signal = struck({0.1}, 1e-3, 16000, 3);
  for (Eigen::Index i = 1600; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i - 1600) / 16000;
    signal.samples(i, 0) += 0.3 * std::exp(-t) * (std::sin(2 * kPi * 900 * t) + std::sin(2 * kPi * 904 * t));
  }
  EXPECT_EQ(detect_strikes(signal).size(), 1u);
}

TEST(Strikes, ASoundThatRingsFromTheFirstFrameIsStruckAtZero) {
  const auto strikes = detect_strikes(struck({0.0}, 1e-3, 48000, 1));
  ASSERT_EQ(strikes.size(), 1u);
  EXPECT_EQ(strikes[0].time_s, 0.0);
}

TEST(Strikes, WhiteNoiseHasNoneAfterItsBeginning) {
  for (const auto& strike : detect_strikes(struck({}, 0.1, 48000, 5))) EXPECT_EQ(strike.time_s, 0.0);
}

TEST(Strikes, SilenceShortSignalsAndBadOptions) {
  EXPECT_TRUE(detect_strikes(struck({}, 0.0, 48000, 1)).empty());
  Signal one = struck({}, 0.1, 48000, 1);
  one.samples.conservativeResize(1, 1);
  EXPECT_LE(detect_strikes(one).size(), 1u);
  klang::audio::StrikeOptions options;
  options.min_rise_db = std::nan("");
  EXPECT_THROW(detect_strikes(one, options), klang::InputError);
}
