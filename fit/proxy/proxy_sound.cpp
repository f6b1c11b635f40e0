#include "fit/proxy/proxy_sound.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/audio/sound_level.hpp"

namespace klang::fit {
namespace {

/// All measures in one order, the partials' last.
std::array<double, 6> measures(const ProxyErrors& e) {
  return {e.log_spectral_distance_db, e.mel_distance_db,   e.third_octave_db,
          e.loudness_difference_db,   e.decay_rms_percent, e.partial_rms_cents};
}

/// A-weighted energy of partials that do not overlap, lasting for ever; nothing outside the band.
double rough_a_weighted(const Voice& voice, const Band& band) {
  double sum = 0.0;
  for (const VoicePartial& p : voice)
    if (p.frequency_hz > band.low_hz && p.frequency_hz < band.high_hz && p.decay_per_s > 0.0)
      sum += p.amplitude * p.amplitude / p.decay_per_s * std::pow(10.0, audio::a_weighting_db(p.frequency_hz) / 10.0);
  return sum;
}

bool holds(double now, double before) { return now <= before * (1.0 + 1e-9) + 1e-9; }

}  // namespace

Voice with_gain(Voice voice, double gain) {
  for (VoicePartial& p : voice) p.amplitude *= gain;
  return voice;
}

audio::Signal voice_sound(const Voice& voice, double duration_s, double sample_rate_hz) {
  stage::PartialsVoice partials(voice);
  stage::Voice* const voices[] = {&partials};
  return stage::render({}, voices, stage::Listener::without_place(), {sample_rate_hz, duration_s});
}

bool no_worse(const ProxyErrors& now, const ProxyErrors& before) {
  const auto a = measures(now), b = measures(before);
  return std::equal(a.begin(), a.end(), b.begin(), holds);
}

std::array<bool, 5> worse_measures(const ProxyErrors& now, const ProxyErrors& before) {
  const auto a = measures(now), b = measures(before);
  std::array<bool, 5> worse{};
  for (std::size_t i = 0; i < worse.size(); ++i) worse[i] = !holds(a[i], b[i]);
  return worse;
}

double excess(const ProxyErrors& now, const ProxyErrors& before) {
  constexpr double kSmall = 1e-3;  // dB or %: a start that is exact in one measure must not blow up the logarithm
  const auto a = measures(now), b = measures(before);
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < a.size(); ++i)
    if (!holds(a[i], b[i])) sum += std::log((a[i] + kSmall) / (b[i] + kSmall));
  return sum;
}

TargetSound::TargetSound(Voice target, int n_partials, double duration_s, double sample_rate_hz)
    : target_(std::move(target)),
      n_partials_(static_cast<std::size_t>(n_partials)),
      duration_s_(duration_s),
      sample_rate_hz_(sample_rate_hz) {
  options_.band.high_hz = std::min(options_.band.high_hz, audio::highest_compared_hz(sample_rate_hz));
  const audio::Signal sound = voice_sound(target_, duration_s_, sample_rate_hz_);
  frames_ = audio::frame_powers(sound, options_.band, options_);
  energies_ = audio::band_energies(sound, options_.band);
  rough_energy_ = rough_a_weighted(target_, options_.band);
  if (!(energies_.in_band > 0.0)) throw InputError("target", "silent in the band that is compared");
}

ProxyErrors TargetSound::partial_errors(const Voice& proxy) const {
  ProxyErrors errors;
  const std::size_t n = std::min({target_.size(), proxy.size(), n_partials_});
  for (std::size_t k = 0; k < n; ++k) {
    errors.partial_rms_cents += std::pow(1200.0 * std::log2(proxy[k].frequency_hz / target_[k].frequency_hz), 2);
    errors.decay_rms_percent += std::pow(100.0 * (proxy[k].decay_per_s / target_[k].decay_per_s - 1.0), 2);
  }
  errors.partial_rms_cents = std::sqrt(errors.partial_rms_cents / static_cast<double>(n));
  errors.decay_rms_percent = std::sqrt(errors.decay_rms_percent / static_cast<double>(n));
  return errors;
}

void TargetSound::add_frames(const audio::FramePowers& sound, double gain, ProxyErrors& errors) const {
  audio::SpectralDistance distance;
  audio::compare_frames(frames_, sound, gain, options_, distance);
  errors.log_spectral_distance_db = distance.log_spectral_db;
  errors.mel_distance_db = distance.mel_db;
}

void TargetSound::add_energies(const audio::BandEnergies& sound, double gain, ProxyErrors& errors) const {
  audio::SpectralDistance distance;
  audio::compare_energies(energies_, sound, gain, options_, distance);
  errors.third_octave_db = distance.third_octave_db;
  errors.loudness_difference_db = std::abs(distance.loudness_difference_db);
}

ProxyErrors TargetSound::errors(const Voice& proxy) const {
  const audio::Signal sound = voice_sound(proxy, duration_s_, sample_rate_hz_);
  const audio::BandEnergies energies = audio::band_energies(sound, options_.band);
  if (!(energies.in_band > 0.0)) throw InputError("proxy", "silent in the band that is compared");
  ProxyErrors errors = partial_errors(proxy);
  add_frames(audio::frame_powers(sound, options_.band, options_), 1.0, errors);
  add_energies(energies, 1.0, errors);
  return errors;
}

double TargetSound::equal_loudness_gain(const Voice& proxy) const {
  const audio::BandEnergies energies =
      audio::band_energies(voice_sound(proxy, duration_s_, sample_rate_hz_), options_.band);
  if (!(energies.a_weighted > 0.0)) throw InputError("proxy", "silent in the band that is compared");
  return std::sqrt(energies_.a_weighted / energies.a_weighted);
}

TargetSound::Level TargetSound::at_level(const Voice& proxy, const ProxyErrors& before, std::optional<double> level,
                                         double start_gain) const {
  constexpr double kHopeless = 0.2;  // ln: the frames alone are a fifth worse
  Level result;
  result.excess = HUGE_VAL;
  const double unit_db = 0.999 * before.loudness_difference_db;
  const auto set_gain = [&](double equal, double at) {
    result.level = std::clamp(at, -1.0, 1.0);
    result.gain = equal * std::pow(10.0, result.level * unit_db / 20.0);
  };
  const double rough = rough_a_weighted(proxy, options_.band);
  if (!(rough > 0.0)) return result;
  const audio::Signal sound = voice_sound(proxy, duration_s_, sample_rate_hz_);
  const audio::FramePowers frames = audio::frame_powers(sound, options_.band, options_);
  const ProxyErrors partials = partial_errors(proxy);
  const double rough_equal = std::sqrt(rough_energy_ / rough);
  const double own = unit_db > 0.0 ? 20.0 * std::log10(start_gain / rough_equal) / unit_db : 0.0;
  const std::vector<double> levels = level ? std::vector<double>{*level} : std::vector<double>{0.0, own, -0.5, 0.5};
  for (const double at : levels) {
    ProxyErrors errors = partials;
    set_gain(rough_equal, at);
    add_frames(frames, result.gain, errors);
    const double worse = excess(errors, before);
    if (!(worse < result.excess)) continue;
    result.excess = worse;
    result.errors = errors;
  }
  result.rough = result.excess > kHopeless;
  if (result.rough) return result;
  const audio::BandEnergies energies = audio::band_energies(sound, options_.band);
  const double equal = std::sqrt(energies_.a_weighted / energies.a_weighted);
  Level best;
  best.excess = HUGE_VAL;
  for (const double at : levels) {
    result.errors = partials;
    set_gain(equal, at);
    add_frames(frames, result.gain, result.errors);
    add_energies(energies, result.gain, result.errors);
    result.excess = excess(result.errors, before);
    if (result.excess < best.excess) best = result;
    if (best.excess == 0.0) break;
  }
  return best;
}

}  // namespace klang::fit
