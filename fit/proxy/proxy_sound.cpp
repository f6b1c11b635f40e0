#include "fit/proxy/proxy_sound.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"

namespace klang::fit {

audio::Signal voice_sound(const Voice& voice, double duration_s, double sample_rate_hz) {
  audio::Signal sound;
  const auto n = static_cast<Eigen::Index>(std::llround(duration_s * sample_rate_hz));
  sound.sample_rate_hz = sample_rate_hz;
  sound.samples = decltype(sound.samples)::Zero(n, 1);
  for (const VoicePartial& p : voice) {
    if (!(p.frequency_hz < 0.45 * sample_rate_hz)) continue;
    const std::complex<double> step = std::exp(std::complex<double>(-p.decay_per_s, 2.0 * kPi * p.frequency_hz) / sample_rate_hz);
    std::complex<double> state = p.amplitude;
    for (Eigen::Index i = 0; i < n; ++i, state *= step) sound.samples(i, 0) += state.imag();
  }
  return sound;
}

ProxyErrors proxy_errors(const Voice& target, const Voice& proxy, int n_partials, double duration_s, double sample_rate_hz) {
  ProxyErrors errors;
  const std::size_t n = std::min({target.size(), proxy.size(), static_cast<std::size_t>(n_partials)});
  for (std::size_t k = 0; k < n; ++k) {
    errors.partial_rms_cents += std::pow(1200.0 * std::log2(proxy[k].frequency_hz / target[k].frequency_hz), 2);
    errors.decay_rms_percent += std::pow(100.0 * (proxy[k].decay_per_s / target[k].decay_per_s - 1.0), 2);
  }
  errors.partial_rms_cents = std::sqrt(errors.partial_rms_cents / static_cast<double>(n));
  errors.decay_rms_percent = std::sqrt(errors.decay_rms_percent / static_cast<double>(n));
  const audio::SpectralDistance distance =
      audio::spectral_distance(voice_sound(target, duration_s, sample_rate_hz), voice_sound(proxy, duration_s, sample_rate_hz));
  errors.log_spectral_distance_db = distance.log_spectral_db;
  errors.mel_distance_db = distance.mel_db;
  errors.third_octave_db = distance.third_octave_db;
  errors.loudness_difference_db = std::abs(distance.loudness_difference_db);
  return errors;
}

bool no_worse(const ProxyErrors& now, const ProxyErrors& before) {
  const auto holds = [](double a, double b) { return a <= b * (1.0 + 1e-9) + 1e-9; };
  return holds(now.partial_rms_cents, before.partial_rms_cents) && holds(now.log_spectral_distance_db, before.log_spectral_distance_db) &&
         holds(now.mel_distance_db, before.mel_distance_db) && holds(now.third_octave_db, before.third_octave_db) &&
         holds(now.loudness_difference_db, before.loudness_difference_db) && holds(now.decay_rms_percent, before.decay_rms_percent);
}

}  // namespace klang::fit
