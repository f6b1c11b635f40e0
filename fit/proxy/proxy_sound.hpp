#pragma once
#include <vector>

#include "core/audio/signal.hpp"
#include "core/audio/spectral_distance.hpp"

namespace klang::fit {

/// Decaying partials: amplitude exp(-decay t) sin(2 pi frequency t).
struct VoicePartial {
  double frequency_hz = 0.0, decay_per_s = 0.0, amplitude = 0.0;
};
using Voice = std::vector<VoicePartial>;

/// Partials above 0.45 of the rate are left out.
audio::Signal voice_sound(const Voice& voice, double duration_s, double sample_rate_hz);

/// How far a proxy lies from its target; every measure is 0 for the same sound.
struct ProxyErrors {
  double partial_rms_cents = 0.0;        ///< of the first partials, rank by rank
  double log_spectral_distance_db = 0.0;  ///< audio::spectral_distance of the two sounds
  double mel_distance_db = 0.0;
  double third_octave_db = 0.0;
  double loudness_difference_db = 0.0;   ///< A-weighted energy, absolute; no loudness in sones
  double decay_rms_percent = 0.0;        ///< of the first partials' decays
};

/// @param n_partials  compared rank by rank, at most as many as both have
/// @throws InputError where nothing sounds in the band
ProxyErrors proxy_errors(const Voice& target, const Voice& proxy, int n_partials, double duration_s, double sample_rate_hz);

/// No measure of `now` is larger than that of `before` (to 1e-9 relative and absolute).
bool no_worse(const ProxyErrors& now, const ProxyErrors& before);

}  // namespace klang::fit
