#pragma once
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/ringdown/detail/partial_search.hpp"

namespace klang::fit::detail {

/// What a fitted exponential is.
enum class Verdict {
  kDecaying,  ///< a partial of a struck body, its decay at least kSureDecay deviations above zero
  kTooShort,  ///< stands above the noise, but the recording is too short to tell whether it decays
  kSteady,    ///< does not decay: hum, a tone of the room or of the recorder
  kNoise,     ///< no line, or none whose frequency and amplitude are known
};

/// A decay this many of its deviations above zero is one.
inline constexpr double kSureDecay = 3.0;
/// Below this ratio (in dB) of amplitude to its deviation noise alone makes partials.
inline constexpr double kSureSnrDb = 14.0;

struct JudgedPartials {
  std::vector<FittedPartial> partials;   ///< decaying
  std::vector<FittedPartial> too_short;  ///< Verdict::kTooShort
  std::vector<FittedPartial> steady;
  int n_images = 0;      ///< of a coder, left out
  double repeats = 1.0;  ///< TailNoise::repeats
  bool empty() const { return partials.empty() && too_short.empty(); }
};

/// All partials of the data: search, joint fits, and pruning one of several that speak against each other at a time; then
/// again from what stands in the residual's spectrum, until nothing new survives (three times at most).
JudgedPartials find_partials(const RingData& data, const SearchOptions& options, Monitor& monitor);

/// Amplitude and phase at the strike, and their deviations.
struct StruckAmplitude {
  double amplitude = 0.0, amplitude_std = 0.0, phase_rad = 0.0, phase_std_rad = 0.0;
};
/// From where the segment begins back to its strike (the segment's delay), for the channel's amplitude there.
StruckAmplitude at_strike(const RingData& data, const FittedPartial& partial, Eigen::Index segment,
                          Eigen::Index channel);

}  // namespace klang::fit::detail
