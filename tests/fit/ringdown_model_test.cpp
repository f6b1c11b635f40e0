/// The parts of ringdown identification against their definitions.
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/sound/audio/fft.hpp"
#include "fit/ringdown/detail/esprit.hpp"
#include "fit/ringdown/detail/partial_search.hpp"
#include "fit/ringdown/detail/sub_band_fit.hpp"
#include "tests/fit/gradient_checker.hpp"
#include "tests/fit/ringdown_signals.hpp"

using klang::kPi;
using klang::fit::detail::BinBlock;
using klang::fit::detail::Pole;
using klang::fit::detail::SubBand;
using Complex = std::complex<double>;

namespace {

BinBlock block_of(const klang::audio::Signal& signal, Eigen::Index first, Eigen::Index count) {
  BinBlock block;
  block.n = signal.n_frames();
  block.first_bin = first;
  block.sample_rate_hz = signal.sample_rate_hz;
  block.y = klang::audio::real_spectrum(signal.samples.col(0), block.n).segment(first, count) /
            std::sqrt(static_cast<double>(block.n));
  return block;
}

}  // namespace

TEST(ExponentialBins, MatchTheTransformOfTheSamplesAtEveryBin) {
  for (const double decay : {0.0, 0.5, 40.0, 3000.0}) {
    const auto signal = klang::tests::ringing({{1003.0, decay, 0.7, 0.6}}, 8000, 0.25, 0.0, 1);
    const BinBlock block = block_of(signal, 1, 998);
    const auto bins = klang::fit::detail::exponential_bins(block, 1003.0, decay, std::polar(0.7, 0.6));
    EXPECT_LE((bins - block.y).cwiseAbs().maxCoeff(), 1e-10 * block.y.cwiseAbs().maxCoeff()) << decay;
  }
}

TEST(ExponentialBins, AnUndampedOneOnABinIsHandled) {
  const auto signal = klang::tests::ringing({{1000.0, 0.0, 1.0, 0.0}}, 8000, 0.25, 0.0, 1);
  const BinBlock block = block_of(signal, 240, 21);
  const auto bins = klang::fit::detail::exponential_bins(block, 1000.0, 0.0, 1.0);
  EXPECT_LE((bins - block.y).cwiseAbs().maxCoeff(), 1e-10 * block.y.cwiseAbs().maxCoeff());
}

TEST(ProjectedCost, JacobianIsExact) {
  const auto signal = klang::tests::ringing({{1003, 8, 0.1, 0.6}, {1010, 12, 0.06, 2}}, 8000, 0.5, 0.01, 3);
  const BinBlock block = block_of(signal, 470, 65);
  const std::vector<Pole> start{{1002.5, 7}, {1010.5, 14}};
  const auto cost = klang::fit::detail::make_projected_cost(block, start, 0.5, 0.01);
  klang::tests::expect_gradient(*cost, {{0.3, 3.9, -0.4, 6.6}});
}

TEST(Refine, ReachesTheTruthWithoutNoise) {
  const auto signal = klang::tests::ringing({{1003, 8, 0.1, 0.6}, {1006, 12, 0.06, 2}}, 8000, 0.5, 0.0, 3);
  SubBand band;
  band.blocks.push_back(block_of(signal, 470, 65));
  band.time_scale_s = 0.5;
  const auto fit = klang::fit::detail::refine(band, {{1002.5, 6}, {1006.8, 15}});
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.poles[0].frequency_hz, 1003, 1e-4);
  EXPECT_NEAR(fit.poles[1].frequency_hz, 1006, 1e-4);
  EXPECT_NEAR(fit.poles[0].decay_per_s, 8, 1e-3);
  EXPECT_NEAR(fit.poles[1].decay_per_s, 12, 1e-3);
}

TEST(Esprit, ReadsThreePolesOfOneBand) {
  const std::vector<klang::tests::TruePartial> truth{{1003, 8, 0.1, 0.6}, {1009, 12, 0.06, 2}, {1030, 5, 0.1, -1}};
  const auto signal = klang::tests::ringing(truth, 8000, 0.5, 1e-4, 3);
  SubBand band;
  band.blocks.push_back(block_of(signal, 470, 80));
  band.time_scale_s = 0.5;
  auto poles = klang::fit::detail::EspritSubspace(band).poles(3);
  ASSERT_EQ(poles.size(), 3u);
  std::sort(poles.begin(), poles.end(), [](const Pole& a, const Pole& b) { return a.frequency_hz < b.frequency_hz; });
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(poles[i].frequency_hz, truth[i].frequency_hz, 0.5);
    EXPECT_NEAR(poles[i].decay_per_s, truth[i].decay_per_s, 3);
  }
}

TEST(NoiseFloor, IsTheMeanOfNoisePowersAndIgnoresPeaks) {
  klang::RandomStream random(5, 0);
  Eigen::VectorXd power(5000);
  for (double& p : power) p = -2.5 * std::log(1 - random.uniform());
  for (Eigen::Index k = 100; k < 5000; k += 40) power.segment(k, 4).setConstant(1e6);
  const Eigen::VectorXd floor = klang::fit::detail::noise_floor(power, 1);
  EXPECT_NEAR(floor.segment(500, 4000).mean(), 2.5, 0.6);
}
