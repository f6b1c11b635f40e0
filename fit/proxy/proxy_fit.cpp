#include "fit/proxy/proxy_fit.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "fit/proxy/proxy_cost.hpp"

namespace klang::fit {
namespace {

/// Of a recording: the sample whose frequencies, best scaled, lie nearest; then at the lowest partial.
ProxyPoint nearest_sample(const soundbank::Soundbank& bank, const ProxyModel& model) {
  ProxyPoint best;
  double least = HUGE_VAL;
  std::vector<double> ratios;
  for (const soundbank::ShapePoint& node : bank.nodes) {
    const ProxyPoint at = model.at_axes(soundbank::unit_axes(node));
    ProxyPoint scaled = at;
    model.log_ratios(at.s, at.t, ratios);
    if (ratios.empty()) continue;
    scaled.ln_scale = 0.0;
    for (const double ratio : ratios) scaled.ln_scale += ratio / static_cast<double>(ratios.size());
    const double cents = model.rms_cents(scaled);
    if (!(cents < least)) continue;
    least = cents;
    best = at;
  }
  return best;
}

ProxyParameters parameters(const soundbank::Soundbank& bank, const ProxyPoint& p, const RayleighDamping& damping,
                           double gain) {
  return {soundbank::unit_axes(shape_of_square(bank, p.s, p.t)), std::exp(p.ln_scale), damping, gain};
}

/// Of the first partials those that can be heard, but three: two shape numbers and a scale want as many.
int audible_partials(const Voice& voice, const ProxyFitOptions& options) {
  const auto n = std::count_if(voice.begin(), voice.end(),
                               [&](const VoicePartial& p) { return p.frequency_hz <= options.highest_hz; });
  return std::clamp(static_cast<int>(n), 3, options.n_partials);
}

}  // namespace

void ProxyFitOptions::validate() const {
  validate_fields("proxy fit", *this);
  search.validate();
}

ProxyFitResult fit_proxy(const soundbank::Soundbank& bank, const ProxyTarget& target, const ProxyFitOptions& options,
                         Monitor& monitor) {
  options.validate();
  if (target.voice.size() < 3)
    throw InputError("target", "a proxy needs at least 3 partials", std::to_string(target.voice.size()));
  if (!(target.voice[0].frequency_hz < 0.4 * options.sample_rate_hz))
    throw InputError("target", "its lowest partial cannot be heard at this sample rate",
                     klang::to_text(target.voice[0].frequency_hz) + " Hz",
                     "below " + klang::to_text(0.4 * options.sample_rate_hz) + " Hz");
  ProxyFitResult result;
  result.n_partials = audible_partials(target.voice, options);
  const ProxyModel model(bank, target, result.n_partials);
  const TargetSound sound(target.voice, result.n_partials, options.duration_s, options.sample_rate_hz);
  result.target = target.voice;

  ProxyPoint start;
  if (target.moments) {
    const Eigen::Vector3d axes = soundbank::axes_of_moments(*target.moments);
    start = model.at_axes(axes);
    result.start_clamped = !(axes.minCoeff() >= bank.thinnest * axes.maxCoeff());
  } else {
    start = nearest_sample(bank, model);
  }
  if (!std::isfinite(model.rms_cents(start)))
    throw InputError("target", "has more partials than the bank's shapes", std::to_string(model.n_partials()),
                     "fewer partials");
  RayleighDamping damping = target.damping;
  if (!(damping.mass_per_s + damping.stiffness_s > 0.0)) damping = model.measured_damping(start);
  // A model's own amplitudes hold for the proxy of its own mass; a recording's level is arbitrary, so both are equally loud.
  const Voice unit = model.voice(start, damping);
  const double gain = target.radiation ? 1.0
                      : target.moments ? target.voice[0].amplitude / unit[0].amplitude
                                       : sound.equal_loudness_gain(unit);
  result.start = parameters(bank, start, damping, gain);
  result.start_voice = with_gain(unit, gain);
  result.before = sound.errors(result.start_voice);

  const ProxySearchResult found = search_proxy(model, sound, {damping, gain, result.before}, options.search, monitor);
  result.n_candidates = found.n_heard;
  result.n_refused = found.n_heard - found.n_admissible;
  result.n_worse = found.n_worse;
  result.least_cents = found.least_cents;
  result.status = ProxyFitStatus::kKept;
  result.fitted = result.start;
  result.fitted_voice = result.start_voice;
  result.after = result.before;
  if (found.best) {
    const ProxyCandidate& best = *found.best;
    const Voice voice = with_gain(model.voice(best.point, best.damping), best.level.gain);
    const ProxyErrors after = sound.errors(voice);  // once more, of the sound that is written
    if (no_worse(after, result.before)) {
      result.status = ProxyFitStatus::kImproved;
      result.after = after;
      result.fitted = parameters(bank, best.point, best.damping, best.level.gain);
      result.fitted_voice = voice;
    }
  }
  if (result.status == ProxyFitStatus::kKept)
    result.message = "no fit is better in one measure and no worse in all: the start is kept";
  return result;
}

}  // namespace klang::fit
