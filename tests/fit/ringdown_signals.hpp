#pragma once
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/audio/signal.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::tests {

struct TruePartial {
  double frequency_hz, decay_per_s, amplitude, phase_rad;
};

/// Partials struck at strike_s (silence before) plus white noise of noise_rms; one channel.
inline audio::Signal ringing(const std::vector<TruePartial>& partials, double rate, double duration_s, double noise_rms,
                             std::uint64_t seed, double strike_s = 0.0) {
  audio::Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples.resize(static_cast<Eigen::Index>(duration_s * rate + 0.5), 1);
  RandomStream random(seed, 1);
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) {
    const double t = static_cast<double>(i) / rate - strike_s;
    double x = noise_rms * random.normal();
    for (const TruePartial& p : partials) {
      if (t >= 0)
        x += p.amplitude * std::exp(-p.decay_per_s * t) * std::cos(2 * kPi * p.frequency_hz * t + p.phase_rad);
    }
    signal.samples(i, 0) = x;
  }
  return signal;
}

/// The found partial nearest to a frequency; null when there is none.
inline const fit::Partial* nearest(const std::vector<fit::Partial>& found, double frequency_hz) {
  const auto at = std::min_element(found.begin(), found.end(), [&](const fit::Partial& a, const fit::Partial& b) {
    return std::abs(a.frequency_hz - frequency_hz) < std::abs(b.frequency_hz - frequency_hz);
  });
  return at == found.end() ? nullptr : &*at;
}

}  // namespace klang::tests
