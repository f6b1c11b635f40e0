#include "fit/ringdown/partial_pairs.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit {
namespace {

constexpr double kFastestBeatHz = 20.0;  ///< above it a pair is rough, not beating
constexpr double kWidestPair = 0.02;     ///< of the frequency
constexpr double kQuietestInBeat = 0.1;  ///< of the louder's amplitude
constexpr double kSlowerStage = 0.5;     ///< of the faster decay, at most
constexpr double kOneLine = 0.5;         ///< of the faster decay / 2 pi: closer lines turn by less than half a radian

bool known(const Partial& partial) {
  return partial.is_ring() && partial.decay_per_s && partial.amplitude && *partial.amplitude > 0.0;
}

double apart_hz(const Partial& a, const Partial& b) { return std::abs(a.frequency_hz - b.frequency_hz); }

double faster_width_hz(const Partial& a, const Partial& b) {
  return std::max(*a.decay_per_s, *b.decay_per_s) / (2.0 * kPi);
}

bool are_stages(const Partial& a, const Partial& b) {
  const double std_hz = std::hypot(a.frequency_std_hz.value_or(0.0), b.frequency_std_hz.value_or(0.0));
  const double slower = std::min(*a.decay_per_s, *b.decay_per_s), faster = std::max(*a.decay_per_s, *b.decay_per_s);
  return slower <= kSlowerStage * faster && apart_hz(a, b) <= std::max(kOneLine * faster_width_hz(a, b), 3.0 * std_hz);
}

bool beat(const Partial& a, const Partial& b) {
  const auto [quieter, louder] = std::minmax(*a.amplitude, *b.amplitude);
  return quieter >= kQuietestInBeat * louder && apart_hz(a, b) >= faster_width_hz(a, b);
}

}  // namespace

void name_pairs(std::vector<Partial>& partials) {
  for (Partial& partial : partials) {
    partial.beat_hz.reset();
    partial.stage.clear();
    if (!known(partial)) continue;
    const Partial* beats_with = nullptr;
    for (const Partial& other : partials) {
      const double reach = std::min(kFastestBeatHz, kWidestPair * partial.frequency_hz);
      if (&other == &partial || !known(other) || apart_hz(partial, other) > reach) continue;
      if (are_stages(partial, other)) {
        partial.stage = *partial.decay_per_s > *other.decay_per_s ? "early" : "late";
      } else if (beat(partial, other) && (beats_with == nullptr || *other.amplitude > *beats_with->amplitude)) {
        beats_with = &other;
      }
    }
    if (beats_with != nullptr) partial.beat_hz = apart_hz(partial, *beats_with);
  }
}

}  // namespace klang::fit
