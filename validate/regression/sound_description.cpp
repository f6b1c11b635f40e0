#include "validate/regression/sound_description.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/audio/strikes.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "validate/regression/detail/band_levels.hpp"

namespace klang::validate {
namespace {

constexpr const char* kPlace = "sound";
constexpr int kLastThird = 12;  // 15.8 kHz
/// @param high_hz  no third octave reaches above
Fingerprint fingerprint(const Eigen::VectorXd& x, const Eigen::VectorXd& rest, double rate, double onset_s,
                        double duration_s, double high_hz) {
  Fingerprint result;
  int last_third = kLastThird;
  while (last_third > result.first_third && audio::ThirdOctave{last_third}.high_hz() > high_hz) --last_third;
  const Eigen::Index n_bands = 4 * (last_third - result.first_third + 1);
  const auto n_frames = std::max<Eigen::Index>(
      1, static_cast<Eigen::Index>(std::floor((duration_s - result.window_s) / result.hop_s)) + 1);
  const detail::BandFrames frames{rate, onset_s, result.window_s, result.hop_s, result.first_third, n_bands, n_frames};
  result.power = detail::band_powers(x, frames);
  const Eigen::MatrixXf left = detail::band_powers(rest, frames);
  // The second half: what the partials leave of the blow itself is over. The median withstands a knock; of the noise in a
  // narrow band (an exponential variable) it is ln 2 of the mean.
  result.noise.resize(n_bands);
  for (Eigen::Index i = 0; i < n_bands; ++i) {
    std::vector<float> values;
    for (Eigen::Index t = n_frames / 2; t < n_frames; ++t) values.push_back(left(i, t));
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    result.noise[i] = *middle / static_cast<float>(std::log(2.0));
  }
  return result;
}

Eigen::VectorXd loudest_channel(const audio::Signal& sound) {
  Eigen::Index loudest = 0;
  for (Eigen::Index c = 1; c < sound.n_channels(); ++c) {
    if (sound.samples.col(c).squaredNorm() > sound.samples.col(loudest).squaredNorm()) loudest = c;
  }
  return sound.samples.col(loudest);
}

}  // namespace

double Fingerprint::centre_hz(Eigen::Index band) const {
  return std::sqrt(detail::band_edge_hz(first_third, band) * detail::band_edge_hz(first_third, band + 1));
}

void DescriptionOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e6)));
  throw_violations(kPlace, std::move(violations));
}

double noise_density(const Fingerprint& fingerprint, double frequency_hz) {
  const double third = 10.0 * std::log10(frequency_hz / 1000.0) - fingerprint.first_third;
  const auto i = std::clamp<Eigen::Index>(std::lround(third), 0, fingerprint.n_thirds() - 1);
  std::vector<double> densities;
  for (Eigen::Index k = 4 * i; k < 4 * i + 4; ++k) {
    const double width_hz =
        detail::band_edge_hz(fingerprint.first_third, k + 1) - detail::band_edge_hz(fingerprint.first_third, k);
    densities.push_back(0.5 * static_cast<double>(fingerprint.noise[k]) / width_hz);
  }
  std::sort(densities.begin(), densities.end());
  return 0.5 * (densities[1] + densities[2]);
}

double SoundDescription::noise_density(double frequency_hz) const {
  return validate::noise_density(fingerprint, frequency_hz);
}

audio::Signal rung(const std::vector<fit::Partial>& partials, double gain, double onset_s, Eigen::Index n_frames,
                   double sample_rate_hz) {
  audio::Signal sound{Eigen::MatrixXd::Zero(n_frames, 1), sample_rate_hz, "partials"};
  for (const fit::Partial& p : partials) {
    if (!(p.frequency_hz <= audio::highest_compared_hz(sample_rate_hz)) || !p.amplitude) continue;
    for (auto i = std::max<Eigen::Index>(0, static_cast<Eigen::Index>(std::ceil(onset_s * sample_rate_hz)));
         i < n_frames; ++i) {
      const double t = static_cast<double>(i) / sample_rate_hz - onset_s;
      sound.samples(i, 0) += gain * *p.amplitude * std::exp(-std::max(0.0, p.decay_per_s.value_or(0.0)) * t) *
                             std::sin(2.0 * kPi * p.frequency_hz * t);
    }
  }
  return sound;
}

double ring_10db_s(const std::vector<fit::Partial>& partials) {
  std::vector<std::pair<double, double>> parts;  // energy, twice the decay
  double total = 0.0, slowest = 1e300;
  for (const fit::Partial& p : partials) {
    if (!p.amplitude || !p.decay_per_s || !(*p.decay_per_s > 0.0)) continue;
    parts.emplace_back(*p.amplitude * *p.amplitude / *p.decay_per_s, 2.0 * *p.decay_per_s);
    total += parts.back().first;
    slowest = std::min(slowest, parts.back().second);
  }
  if (!(total > 0.0)) return 0.0;
  double low = 0.0, high = std::log(10.0) / slowest;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    double left = 0.0;
    for (const auto& [energy, rate] : parts) left += energy * std::exp(-rate * t);
    (left > 0.1 * total ? low : high) = t;
  }
  return 0.5 * (low + high);
}

SoundDescription describe(const audio::Signal& sound, const DescriptionOptions& options, Monitor& monitor) {
  options.validate();
  if (sound.n_frames() == 0 || sound.n_channels() == 0) throw InputError(sound.origin, "has no samples");
  const double rate = sound.sample_rate_hz;
  audio::Signal mono{loudest_channel(sound), rate, sound.origin, sound.coded_frames};

  fit::RingdownOptions ringdown;
  const double limit_hz = std::min(audio::highest_compared_hz(rate), detail::heard_limit_hz(mono.samples.col(0), rate));
  ringdown.band = {options.band.low_hz, std::min(options.band.high_hz, limit_hz)};
  ringdown.min_snr_db = options.min_snr_db;
  const fit::RingdownResult found = fit::at_first_strike(fit::identify_ringdown(mono, ringdown, monitor));
  if (!found.usable()) throw InputError(sound.origin, "has no partial above the noise", found.message);

  SoundDescription result;
  result.origin = sound.origin;
  result.sample_rate_hz = rate;
  result.onset_s = found.strikes_s.empty() ? 0.0 : found.strikes_s.front();
  audio::StrikeOptions strikes;
  strikes.band = ringdown.band;
  for (const audio::Strike& strike : audio::detect_strikes(mono, strikes)) {
    if (std::abs(strike.time_s - result.onset_s) < 1e-3)
      result.contact_s = std::max(0.0, strike.settled_s - strike.time_s);
  }
  const double end_s = found.strikes_s.size() > 1 ? found.strikes_s[1] : sound.duration_s();
  result.duration_s = end_s - result.onset_s;
  result.band = ringdown.band;
  result.partials = found.partials;
  result.warnings = found.warnings;
  if (found.strikes_s.size() > 1) {
    result.warnings.push_back("levels up to the second of " + std::to_string(found.strikes_s.size()) + " strikes");
  }
  const Eigen::VectorXd rest = mono.samples.col(0) - fit::resynthesise(found, mono.n_frames()).samples.col(0);
  result.fingerprint = fingerprint(mono.samples.col(0), rest, rate, result.onset_s,
                                   std::min(result.duration_s, options.max_duration_s), limit_hz);
  result.ring_10db_s = ring_10db_s(result.partials.partials);
  return result;
}

}  // namespace klang::validate
