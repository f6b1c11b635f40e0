#include "validate/regression/detail/band_levels.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::validate::detail {
namespace {

constexpr double kHannBandwidth = 1.5;    // equivalent noise bandwidth in bins
constexpr Eigen::Index kAtOnce = 64;      // frames
constexpr double kFrameS = 0.05;          // of heard_limit_hz
constexpr double kLeastLimitHz = 2000.0;  // no coder cuts below
constexpr double kLimitFall = 0.1;        // of power, 10 dB
constexpr double kBelowLimit = 0.97;      // of the edge found: filters are not vertical

/// Windowed samples' autocorrelation at lags 0 to n - 1.
Eigen::VectorXd autocorrelation(const Eigen::VectorXd& block, Eigen::Index n_fft) {
  Eigen::VectorXcd spectrum = audio::real_spectrum(block, n_fft);
  spectrum = spectrum.cwiseAbs2().cast<std::complex<double>>();
  return audio::real_from_spectrum(spectrum, n_fft).head(block.size());
}

}  // namespace

double band_edge_hz(int first_third, Eigen::Index i) {
  return 1000.0 * std::pow(10.0, 0.1 * (first_third - 0.5 + 0.25 * static_cast<double>(i)));
}

Eigen::MatrixXf band_powers(const Eigen::VectorXd& x, const BandFrames& frames) {
  const double rate = frames.rate_hz, length = frames.window_s * rate;
  const auto n = static_cast<Eigen::Index>(std::ceil(length)) + 1;
  Eigen::Index n_fft = audio::good_fft_size(2 * n);
  while (n_fft % 2) n_fft = audio::good_fft_size(n_fft + 1);
  // Row i: the integral's weights of each lag.
  Eigen::MatrixXd weight(frames.n_bands, n);
  const double scale = 4.0 * length / (kHannBandwidth * 0.25 * length * length * rate);
  for (Eigen::Index i = 0; i < frames.n_bands; ++i) {
    const double low = band_edge_hz(frames.first_third, i), high = band_edge_hz(frames.first_third, i + 1);
    weight(i, 0) = scale * (high - low);
    for (Eigen::Index l = 1; l < n; ++l) {
      const double turn = 2.0 * kPi * static_cast<double>(l) / rate;
      weight(i, l) = scale * 2.0 * (std::sin(turn * high) - std::sin(turn * low)) / turn;
    }
  }
  Eigen::MatrixXf power(frames.n_bands, frames.n_frames);
  for (Eigen::Index first = 0; first < frames.n_frames; first += kAtOnce) {
    const Eigen::Index count = std::min(kAtOnce, frames.n_frames - first);
    Eigen::MatrixXd lags(n, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const double start = (frames.start_s + static_cast<double>(first + k) * frames.hop_s) * rate;
      const auto begin = static_cast<Eigen::Index>(std::ceil(start));
      Eigen::VectorXd block = Eigen::VectorXd::Zero(n);
      for (Eigen::Index i = 0; i < n && begin + i < x.size(); ++i) {
        const double at = (static_cast<double>(begin + i) - start) / length;
        if (at < 1.0 && begin + i >= 0) block[i] = (0.5 - 0.5 * std::cos(2.0 * kPi * at)) * x[begin + i];
      }
      lags.col(k) = autocorrelation(block, n_fft);
    }
    power.middleCols(first, count) = (weight * lags).cwiseMax(0.0).cast<float>();
  }
  return power;
}

double heard_limit_hz(const Eigen::VectorXd& x, double rate) {
  const Eigen::Index n = audio::good_fft_size(static_cast<Eigen::Index>(kFrameS * rate));
  if (x.size() < n) return 0.5 * rate;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n / 2 + 1);
  for (Eigen::Index first = 0; first + n <= x.size(); first += n / 2) {
    Eigen::VectorXd block = x.segment(first, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      // Blackman's and Harris's window of four terms: 92 dB down, so that no line covers the floor.
      const double turn = 2.0 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
      block[i] *= 0.35875 - 0.48829 * std::cos(turn) + 0.14128 * std::cos(2 * turn) - 0.01168 * std::cos(3 * turn);
    }
    mean += audio::real_spectrum(block, n).cwiseAbs2();
  }
  // The floor of each twelfth of an octave, from half the sample rate downwards.
  const double bin_hz = rate / static_cast<double>(n), ratio = std::pow(2.0, 1.0 / 12.0);
  std::vector<double> edge, floor;
  for (double high = 0.5 * rate; high / ratio > kLeastLimitHz; high /= ratio) {
    const auto first = static_cast<Eigen::Index>(std::ceil(high / ratio / bin_hz));
    const auto last = std::min(mean.size(), static_cast<Eigen::Index>(std::ceil(high / bin_hz)));
    std::vector<double> bins(mean.data() + first, mean.data() + last);
    if (bins.size() < 4) break;
    const auto low = bins.begin() + static_cast<std::ptrdiff_t>(bins.size() / 5);
    std::nth_element(bins.begin(), low, bins.end());
    edge.push_back(high);
    floor.push_back(*low);
  }
  double limit = 0.5 * rate, above = 0.0;  // above: the highest floor of all bands above
  for (std::size_t i = 0; i + 2 < floor.size(); ++i) {
    above = std::max(above, floor[i]);
    // The step lies in the band between, and what is below it is a floor, too, not one band's.
    if (above < kLimitFall * std::min(floor[i + 2], i + 3 < floor.size() ? floor[i + 3] : floor[i + 2]))
      limit = kBelowLimit * edge[i + 2];
  }
  return limit;
}

}  // namespace klang::validate::detail
