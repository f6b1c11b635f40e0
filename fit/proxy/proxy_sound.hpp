#pragma once
#include <array>
#include <optional>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/audio/spectral_distance.hpp"
#include "core/sound/stage/partials_voice.hpp"

namespace klang::fit {

/// What a body sounds of.
using VoicePartial = stage::Partial;
using Voice = std::vector<VoicePartial>;

/// The same partials, all amplitudes times gain.
Voice with_gain(Voice voice, double gain);

/// render() with a stage::PartialsVoice.
audio::Signal voice_sound(const Voice& voice, double duration_s, double sample_rate_hz);

/// How far a proxy lies from its target; every measure is 0 for the same sound.
struct ProxyErrors {
  double partial_rms_cents = 0.0;         ///< of the first partials, rank by rank
  double log_spectral_distance_db = 0.0;  ///< audio::spectral_distance of the two sounds
  double mel_distance_db = 0.0;
  double third_octave_db = 0.0;
  double loudness_difference_db = 0.0;  ///< A-weighted energy, absolute; no loudness in sones
  double decay_rms_percent = 0.0;       ///< of the first partials' decays

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"partial_rms_cents", "of the first partials, rank by rank"}), self.partial_rms_cents);
    visit(needed({"log_spectral_distance_db", "of the two sounds"}), self.log_spectral_distance_db);
    visit(needed({"mel_distance_db", "in mel bands"}), self.mel_distance_db);
    visit(needed({"third_octave_db", "levels, rms"}), self.third_octave_db);
    visit(needed({"loudness_difference_db", "A-weighted energy, absolute"}), self.loudness_difference_db);
    visit(needed({"decay_rms_percent", "of the first partials' decays"}), self.decay_rms_percent);
  }
};

/// No measure of `now` is larger than that of `before` (to 1e-9 relative and absolute).
bool no_worse(const ProxyErrors& now, const ProxyErrors& before);
/// Which are worse, in order: log-spectral, mel, third octaves, loudness, decays.
std::array<bool, 5> worse_measures(const ProxyErrors& now, const ProxyErrors& before);
/// By how much measures other than the partials' are worse: sum of ln(now / before) over those that are; 0: none.
double excess(const ProxyErrors& now, const ProxyErrors& before);

/// A target, its transforms taken once. Constant after construction, so one object serves all threads.
class TargetSound {
 public:
  /// @param n_partials  compared rank by rank, at most as many as both have
  /// @throws InputError where nothing sounds in the band
  TargetSound(Voice target, int n_partials, double duration_s, double sample_rate_hz);

  ProxyErrors errors(const Voice& proxy) const;
  /// That makes the A-weighted energies equal. @throws InputError where the proxy is silent in the band
  double equal_loudness_gain(const Voice& proxy) const;
  /// A proxy at a level beside `before`, whose difference of loudness is the unit of the level: never outside -1 to 1 of them.
  /// @param level  empty: the best of equal loudness, the start's gain and half a unit to either side
  struct Level {
    double gain = 1.0;
    double level = 0.0;
    ProxyErrors errors;  ///< where excess is rough: without the whole sound's energies
    double excess = 0.0;
    bool rough = false;  ///< the frames alone were so much worse that the rest was not computed
  };
  Level at_level(const Voice& proxy, const ProxyErrors& before, std::optional<double> level, double start_gain) const;

 private:
  ProxyErrors partial_errors(const Voice& proxy) const;
  void add_frames(const audio::FramePowers& sound, double gain, ProxyErrors& errors) const;
  void add_energies(const audio::BandEnergies& sound, double gain, ProxyErrors& errors) const;

  Voice target_;
  std::size_t n_partials_;
  double duration_s_, sample_rate_hz_;
  audio::SpectralDistanceOptions options_;
  audio::FramePowers frames_;
  audio::BandEnergies energies_;
  double rough_energy_ = 0.0;
};

}  // namespace klang::fit
