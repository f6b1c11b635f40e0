#include "fit/ringdown/takes.hpp"

#include <algorithm>
#include <cmath>

#include "core/sound/audio/strikes.hpp"
#include "fit/ringdown/partial_pairs.hpp"

namespace klang::fit {

std::vector<TakeSound> cut_takes(const audio::Signal& recording, double min_gap_s) {
  constexpr double kBeforeS = 0.02, kShortestS = 0.05;
  std::vector<double> strikes_s;
  for (const audio::Strike& strike : audio::detect_strikes(recording)) {
    if (strikes_s.empty() || strike.time_s - strikes_s.back() >= min_gap_s) strikes_s.push_back(strike.time_s);
  }
  std::vector<TakeSound> takes;
  for (std::size_t i = 0; i < strikes_s.size(); ++i) {
    const double begin_s = std::max(0.0, strikes_s[i] - kBeforeS);
    const double next_s = i + 1 < strikes_s.size() ? strikes_s[i + 1] - kBeforeS : recording.duration_s();
    const double end_s = std::min(next_s, begin_s + kLongestTakeS);
    if (end_s - begin_s < kShortestS) continue;
    const auto first = static_cast<Eigen::Index>(std::llround(begin_s * recording.sample_rate_hz));
    const auto end =
        std::min(recording.n_frames(), static_cast<Eigen::Index>(std::llround(end_s * recording.sample_rate_hz)));
    TakeSound& take = takes.emplace_back();
    take.strike_s = strikes_s[i];
    take.sound.sample_rate_hz = recording.sample_rate_hz;
    take.sound.coded_frames = recording.coded_frames;
    take.sound.samples = recording.samples.middleRows(first, end - first);
  }
  return takes;
}

std::optional<Take> analysed_take(const TakeSound& sound, double a4_hz, Monitor& monitor) {
  RingdownOptions options;
  options.band = {20.0, 0.48 * sound.sound.sample_rate_hz};
  if (!(sound.sound.samples.cwiseAbs().maxCoeff() > 0.0)) return std::nullopt;
  const RingdownResult rings = identify_ringdown(sound.sound, options, monitor);
  if (!rings.usable() || rings.partials.partials.empty()) return std::nullopt;
  Take take;
  take.strike_s = sound.strike_s;
  take.partials = rings.partials.partials;
  name_notes(take.partials, a4_hz);
  name_pairs(take.partials);
  const auto strongest = std::max_element(
      take.partials.begin(), take.partials.end(),
      [](const Partial& a, const Partial& b) { return a.amplitude.value_or(0.0) < b.amplitude.value_or(0.0); });
  take.note = strongest->note;
  take.cents = strongest->cents;
  return take;
}

}  // namespace klang::fit
