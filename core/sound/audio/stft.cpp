#include "core/sound/audio/stft.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::audio {

void StftOptions::validate() const { validate_fields("stft", *this); }

Stft stft(const Signal& signal, const StftOptions& options) {
  options.validate();
  checked_open("stft", "sample_rate_hz", signal.sample_rate_hz, 0, 1e9);
  const Eigen::Index n = signal.n_frames();
  if (n == 0 || signal.n_channels() == 0) throw InputError("stft", "the signal has no samples");
  const double rate = signal.sample_rate_hz;
  const Eigen::Index window_n =
      std::clamp<Eigen::Index>(std::llround(std::min(options.window_s * rate, 1e9)), 4, std::max<Eigen::Index>(n, 4));
  Eigen::Index hop = std::max<Eigen::Index>(1, std::llround(std::min(options.hop_s * rate, 1e9)));
  const Eigen::Index span = std::max<Eigen::Index>(n - window_n, 0);
  hop = std::max(hop, (span + options.max_frames - 1) / options.max_frames);
  const Eigen::Index n_times = std::min<Eigen::Index>(span / hop + (span % hop != 0 ? 2 : 1), options.max_frames);
  const Eigen::Index n_fft = good_fft_size(window_n * options.padding);

  Eigen::VectorXd window(window_n);
  for (Eigen::Index i = 0; i < window_n; ++i) {
    window[i] = 0.5 - 0.5 * std::cos(2 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(window_n));
  }
  const double scale = 4.0 / (window.sum() * window.sum());

  Stft result;
  result.power.resize(n_fft / 2 + 1, n_times);
  for (Eigen::Index t = 0; t < n_times; ++t) {
    result.times_s.push_back((static_cast<double>(t * hop) + 0.5 * static_cast<double>(window_n)) / rate);
  }
  for (Eigen::Index k = 0; k <= n_fft / 2; ++k) {
    result.frequencies_hz.push_back(static_cast<double>(k) * rate / static_cast<double>(n_fft));
  }
  parallel_for(static_cast<std::size_t>(n_times), 16, [&](std::size_t begin, std::size_t end) {
    Eigen::VectorXd block(n_fft);
    Eigen::VectorXd power(n_fft / 2 + 1);
    for (auto t = static_cast<Eigen::Index>(begin); t < static_cast<Eigen::Index>(end); ++t) {
      const Eigen::Index first = t * hop;
      const Eigen::Index count = std::clamp<Eigen::Index>(n - first, 0, window_n);
      power.setZero();
      for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
        block.setZero();
        block.head(count) =
            signal.samples.col(channel).segment(std::min(first, n), count).cwiseProduct(window.head(count));
        power += real_spectrum(block, n_fft).cwiseAbs2();
      }
      result.power.col(t) = (power * (scale / static_cast<double>(signal.n_channels()))).cast<float>();
    }
  });
  return result;
}

std::vector<Stft> multi_resolution_stft(const Signal& signal, const std::vector<double>& windows_s) {
  std::vector<double> sorted = windows_s;
  std::sort(sorted.begin(), sorted.end());
  std::vector<Stft> result;
  for (const double window_s : sorted) {
    StftOptions options;
    options.window_s = window_s;
    options.hop_s = window_s / 4;
    result.push_back(stft(signal, options));
  }
  return result;
}

Spectrogram spectrogram(const Signal& signal, const StftOptions& options, double floor_db) {
  Stft power = stft(signal, options);
  const auto floor = static_cast<float>(std::pow(10.0, floor_db / 10));
  Spectrogram result;
  result.times_s = std::move(power.times_s);
  result.frequencies_hz = std::move(power.frequencies_hz);
  result.level_db = 10.0f * power.power.array().max(floor).log10().matrix();
  return result;
}

}  // namespace klang::audio
