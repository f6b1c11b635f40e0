#include "fit/ringdown/detail/tail_noise.hpp"

#include <algorithm>
#include <complex>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::fit::detail {

Eigen::VectorXd blackman_harris(Eigen::Index n) {
  Eigen::VectorXd w(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = 2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(n);
    w[i] = 0.35875 - 0.48829 * std::cos(x) + 0.14128 * std::cos(2 * x) - 0.01168 * std::cos(3 * x);
  }
  return w / w.norm();
}

Eigen::VectorXd noise_floor(const Eigen::VectorXd& power, Eigen::Index n_averaged) {
  constexpr double kQuantile = 0.35;
  // Wilson-Hilferty: quantile over mean of a gamma variable with shape n; z(0.35) = -0.3853.
  const double n = static_cast<double>(n_averaged);
  const double to_mean =
      n_averaged == 1 ? -std::log(1 - kQuantile) : std::pow(1 - 1 / (9 * n) - 0.3853 / (3 * std::sqrt(n)), 3);
  const Eigen::Index size = power.size();
  std::vector<double> centres, levels, scratch;
  const Eigen::Index narrowest = std::clamp<Eigen::Index>(size / 8, 4, 64);
  for (Eigen::Index k = 1; k < size;) {
    const Eigen::Index half = std::max(narrowest, k / 12);
    const Eigen::Index from = std::max<Eigen::Index>(1, k - half), to = std::min(size, k + half + 1);
    scratch.assign(power.data() + from, power.data() + to);
    const auto at = scratch.begin() + static_cast<std::ptrdiff_t>(kQuantile * static_cast<double>(scratch.size()));
    std::nth_element(scratch.begin(), at, scratch.end());
    centres.push_back(static_cast<double>(k));
    levels.push_back(*at / to_mean);
    k += std::max<Eigen::Index>(1, half / 2);
  }
  Eigen::VectorXd floor(size);
  std::size_t i = 0;
  for (Eigen::Index k = 0; k < size; ++k) {
    const auto x = static_cast<double>(k);
    while (i + 2 < centres.size() && centres[i + 1] < x) ++i;
    if (centres.size() < 2) {
      floor[k] = levels.empty() ? 0.0 : levels.front();
      continue;
    }
    const double t = std::clamp((x - centres[i]) / (centres[i + 1] - centres[i]), 0.0, 1.0);
    floor[k] = (1 - t) * levels[i] + t * levels[i + 1];
  }
  return floor;
}

namespace {

/// Largest magnitude of the phase correlation of two spectra over all shifts: 1 for copies of any loudness and delay, about
/// sqrt(ln n / n) for what shares nothing. Every bin weighs the same, so that a few lines of the same body say little.
double likeness(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b, Eigen::Index n) {
  Eigen::VectorXcd phase(a.size());
  for (Eigen::Index k = 0; k < a.size(); ++k) {
    const std::complex<double> both = a[k] * std::conj(b[k]);
    phase[k] = both / (std::abs(both) + 1e-300);
  }
  return audio::real_from_spectrum(phase, n).cwiseAbs().maxCoeff();
}

/// TailNoise::repeats, by the likeness of each segment's late part to the first one's and to the one's before it.
double repeats_of(const RingData& data) {
  constexpr double kAlike = 0.5;
  const auto& segments = data.segments();
  if (segments.size() < 2) return 1;
  Eigen::Index shortest = segments.front().end - segments.front().begin;
  for (const Segment& segment : segments) shortest = std::min(shortest, segment.end - segment.begin);
  const Eigen::Index n = audio::good_fft_size_below(
      std::clamp<Eigen::Index>(shortest / 2, 8, static_cast<Eigen::Index>(data.sample_rate_hz())));
  const Eigen::VectorXd window = blackman_harris(n);
  std::vector<Eigen::VectorXcd> spectra;
  for (const Segment& segment : segments) {
    const Eigen::Index begin = segment.begin + std::max<Eigen::Index>(0, shortest - n);
    spectra.push_back(audio::real_spectrum(data.channels().front().segment(begin, n).cwiseProduct(window), n));
  }
  double sum = 0, pairs = 0;
  for (std::size_t s = 1; s < spectra.size(); ++s) {
    for (const std::size_t other : {std::size_t{0}, s - 1}) {
      if (other == 0 && s == 1 && pairs > 0) continue;
      const double alike = likeness(spectra[s], spectra[other], n);
      sum += alike >= kAlike ? alike * alike : 0.0;
      ++pairs;
    }
  }
  return 1 + (static_cast<double>(segments.size()) - 1) * sum / pairs;
}

}  // namespace

TailNoise::TailNoise(const RingData& data) : repeats_(repeats_of(data)) {
  const Segment& segment = data.segments()[static_cast<std::size_t>(data.longest_segment())];
  const Eigen::Index length = segment.end - segment.begin;
  const Eigen::Index n = audio::good_fft_size_below(
      std::max<Eigen::Index>(8, std::min(length / 2, static_cast<Eigen::Index>(2 * data.sample_rate_hz()))));
  per_bin_hz_ = data.sample_rate_hz() / static_cast<double>(n);
  const Eigen::VectorXd window = blackman_harris(n);
  floor_ = Eigen::VectorXd::Zero(n / 2 + 1);
  for (const Eigen::VectorXd& x : data.channels()) {
    const Eigen::VectorXd tail = x.segment(segment.end - n, n).cwiseProduct(window);
    floor_ += noise_floor(audio::real_spectrum(tail, n).cwiseAbs2(), 1) / static_cast<double>(data.channels().size());
  }
}

}  // namespace klang::fit::detail
