#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <vector>

namespace klang::stage {

namespace detail {
class ContactPulse;
}

/// A force over time per unit of an impulse, straight between its steps.
struct ForceHistory {
  double begin_s = 0.0, step_s = 0.0;
  std::vector<double> force_per_s;  ///< 0 at either end, of area 1
};

/// Hertz' own force of an impulse between rigid bodies that touch from begin_s on for duration_s, of area 1.
ForceHistory hertz_history(double begin_s, double duration_s);

/// The history as oscillators at a sample rate take it.
std::shared_ptr<const detail::ContactPulse> sampled(const ForceHistory& history, double sample_rate_hz);

/// The force of an impulse of a log over time where it differs from what its row says.
struct ImpactPulse {
  std::shared_ptr<const detail::ContactPulse> force;  ///< of area 1
  double share = 1.0;  ///< of the impulse that the bodies' modes feel; a floor feels it all
};

/// By the rows. All at one sample rate, which must be that of the rendering.
using ImpactPulses = std::map<std::size_t, ImpactPulse>;

}  // namespace klang::stage
