#include "fit/ringdown/detail/tail_noise.hpp"

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

TailNoise::TailNoise(const RingData& data) {
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
