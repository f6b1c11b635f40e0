#include <algorithm>
#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "fit/ringdown/ringdown.hpp"

namespace klang::fit {
namespace {

using Complex = std::complex<double>;

}  // namespace

RingdownResult at_first_strike(RingdownResult result) {
  if (result.strike_amplitudes.empty()) return result;
  for (std::size_t i = 0; i < result.partials.partials.size(); ++i) {
    Partial& partial = result.partials.partials[i];
    partial.amplitude = result.strike_amplitudes.front()[i];  // the deviation is the noise's, at any strike
    partial.phase_rad = result.strike_phases_rad.front()[i];
  }
  result.amplitude_strike = 0;
  return result;
}

audio::Signal resynthesise(const RingdownResult& ringdown, Eigen::Index n_frames) {
  audio::Signal signal;
  signal.sample_rate_hz = ringdown.sample_rate_hz;
  signal.origin = "resynthesis of " + ringdown.partials.origin;
  signal.samples = Eigen::MatrixXd::Zero(n_frames, 1);
  if (!ringdown.usable()) return signal;
  const double rate = ringdown.sample_rate_hz;
  for (std::size_t s = 0; s < ringdown.strikes_s.size(); ++s) {
    const double strike_s = ringdown.strikes_s[s];
    const auto begin = static_cast<Eigen::Index>(std::ceil(strike_s * rate - 1e-9));
    const Eigen::Index end =
        s + 1 < ringdown.strikes_s.size()
            ? std::min(n_frames, static_cast<Eigen::Index>(std::ceil(ringdown.strikes_s[s + 1] * rate - 1e-9)))
            : n_frames;
    for (std::size_t i = 0; i < ringdown.partials.partials.size(); ++i) {
      const Partial& partial = ringdown.partials.partials[i];
      const double amplitude =
          ringdown.strike_amplitudes.empty() ? partial.amplitude.value_or(0) : ringdown.strike_amplitudes[s][i];
      const double phase =
          ringdown.strike_phases_rad.empty() ? partial.phase_rad.value_or(0) : ringdown.strike_phases_rad[s][i];
      const Complex sigma(-partial.decay_per_s.value_or(0), 2.0 * kPi * partial.frequency_hz);
      const Complex step = std::exp(sigma / rate);
      constexpr Eigen::Index kBlock = 512;
      for (Eigen::Index block = begin; block < end; block += kBlock) {
        Complex z = amplitude * std::exp(Complex(0, phase) + sigma * (static_cast<double>(block) / rate - strike_s));
        for (Eigen::Index k = block; k < std::min(block + kBlock, end); ++k) {
          signal.samples(k, 0) += z.real();
          z *= step;
        }
      }
    }
  }
  return signal;
}

}  // namespace klang::fit
