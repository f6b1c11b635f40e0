// What a search for bubbles and those who read its result share.
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"
#include "core/sound/audio/fft.hpp"
#include "fit/bubble/bubble_search.hpp"

namespace klang::fit::bubble {
namespace {

using klang::bubble::BubbleMedium;
using klang::bubble::BubbleTheory;

constexpr double kDynamicRange = 1e-6;  // least noise density over the loudest band's
constexpr double kRenderedSpan = 7.0;   // decay times until a ring is over (-61 dB)

double damped_hz(const BubbleMedium& medium, BubbleTheory theory, double radius_m) {
  const double omega0 = klang::bubble::undamped_angular_frequency_rad_s(medium, theory, radius_m);
  const double beta = klang::bubble::bubble_damping(medium, theory, radius_m, omega0).decay_per_s;
  return std::sqrt(std::max(omega0 * omega0 - beta * beta, 1.0)) / (2.0 * kPi);
}

}  // namespace

void BubbleSearchOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, above(band.low_hz)));
  throw_violations("bubbles", std::move(violations));
}

const char* words(BubbleVerdict verdict) {
  switch (verdict) {
    case BubbleVerdict::kBubble:
      return "bubble";
    case BubbleVerdict::kDriven:
      return "bubble, amplitude does not fall as it rings free";
    case BubbleVerdict::kRingsTooLong:
      return "no bubble: rings longer than one of this pitch can";
    case BubbleVerdict::kUnclear:
      return "too short or too noisy to tell";
    case BubbleVerdict::kDampedTooStrongly:
      return "no bubble: damped ten times as strongly as one of this pitch";
  }
  return "";
}

NoiseSpectrum noise_spectrum(const Eigen::VectorXd& samples, double sample_rate_hz) {
  const Eigen::Index frame = std::min<Eigen::Index>(1024, samples.size() / 4 * 2), n_bins = frame / 2 + 1;
  Eigen::VectorXd window(frame);
  for (Eigen::Index i = 0; i < frame; ++i)
    window[i] = 0.5 - 0.5 * std::cos(2.0 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(frame));
  std::vector<std::vector<double>> power(static_cast<std::size_t>(n_bins));
  for (Eigen::Index first = 0; first + frame <= samples.size(); first += frame / 2) {
    const Eigen::VectorXcd spectrum = audio::real_spectrum(samples.segment(first, frame).cwiseProduct(window), frame);
    for (Eigen::Index k = 0; k < n_bins; ++k)
      power[static_cast<std::size_t>(k)].push_back(std::norm(spectrum[k]) / window.squaredNorm());
  }
  Eigen::VectorXd quartile(n_bins), mean(n_bins);
  for (Eigen::Index k = 0; k < n_bins; ++k) {
    auto& p = power[static_cast<std::size_t>(k)];
    mean[k] = std::accumulate(p.begin(), p.end(), 0.0) / static_cast<double>(p.size());
    const auto at = p.begin() + static_cast<std::ptrdiff_t>(p.size() / 4);
    std::nth_element(p.begin(), at, p.end());
    quartile[k] = *at / -std::log(0.75);  // of an exponential distribution
  }
  NoiseSpectrum noise;
  noise.step_hz = sample_rate_hz / static_cast<double>(frame);
  noise.variance.resize(n_bins);
  // Coders and filters leave bands that are all but empty: what splashes into them is no ring 80 dB above the noise.
  double loudest = 0.0;
  for (Eigen::Index k = 0; k < n_bins; ++k) loudest = std::max(loudest, mean[k]);
  const double floor = std::max(kDynamicRange * loudest, 1e-20);
  for (Eigen::Index k = 0; k < n_bins; ++k) {
    const Eigen::Index half = std::max<Eigen::Index>(2, static_cast<Eigen::Index>(0.06 * static_cast<double>(k)));
    const Eigen::Index low = std::max<Eigen::Index>(1, k - half), high = std::min(n_bins - 1, k + half);
    noise.variance[k] = std::max(quartile.segment(low, high - low + 1).mean(), floor);
  }
  return noise;
}

double radius_of_frequency_m(double damped_frequency_hz, const BubbleMedium& medium, BubbleTheory theory) {
  // Frequency falls with radius all the way; three quarters of a decade either side of Minnaert's r = 3.26 / f are enough.
  double low = std::log(1.0 / damped_frequency_hz), high = std::log(10.0 / damped_frequency_hz);
  low = std::max(low, std::log(klang::bubble::kSmallestRadiusM));
  high = std::min(high, std::log(klang::bubble::kLargestRadiusM));
  const auto excess = [&](double x) { return std::log(damped_hz(medium, theory, std::exp(x)) / damped_frequency_hz); };
  if (!(low < high && excess(low) > 0.0 && excess(high) < 0.0))
    throw InputError("bubble", "no radius rings at this frequency [Hz]", std::to_string(damped_frequency_hz),
                     "70 to 300000");
  for (int i = 0; i < 60 && high - low > 1e-13; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(middle) > 0.0 ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

Eigen::VectorXd render(const std::vector<FoundBubble>& bubbles, Eigen::Index n_samples, double sample_rate_hz) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n_samples), value(n_samples);
  for (const FoundBubble& bubble : bubbles) {
    const auto first = std::clamp<Eigen::Index>(
        static_cast<Eigen::Index>(std::ceil(bubble.chirp.onset_s * sample_rate_hz)), 0, n_samples);
    const auto n =
        std::min(n_samples - first,
                 static_cast<Eigen::Index>(2.0 * kRenderedSpan / std::exp(bubble.chirp.log_decay) * sample_rate_hz));
    evaluate_chirp(bubble.law, bubble.chirp, static_cast<double>(first) / sample_rate_hz, sample_rate_hz,
                   value.head(n));
    sum.segment(first, n) += value.head(n);
  }
  return sum;
}

}  // namespace klang::fit::bubble
