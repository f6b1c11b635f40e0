#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/sound/stage/impact_pulses.hpp"

namespace klang::stage {

/// One damped oscillator: z'' + 2 decay z' + omega^2 z = g(t).
struct Oscillator {
  double angular_frequency_rad_s = 0.0;  ///< undamped, >= 0
  double decay_per_s = 0.0;              ///< >= 0; over-damped when above angular_frequency_rad_s
  double output_gain = 1.0;              ///< weight of z in the mix
};

/// A modal impulse into each oscillator at one time (z' jumps by impulse[i]).
struct ModalImpulse {
  double time_s = 0.0;
  Eigen::VectorXd impulse;          ///< n_oscillators
  double contact_duration_s = 0.0;  ///< standard deviation of the Gaussian pulse, 0 to 0.1; 0: a Dirac pulse
  std::shared_ptr<const detail::ContactPulse> pulse =
      {};  ///< of the oscillators' sample rate, instead of time and duration
};

/// sum_i output_gain_i z_i at n_frames samples of sample_rate_hz, by the exact one-step recurrence (under-, critically
/// and over-damped, and rigid), to round-off of the closed form. Vectorised and parallel over modes; deterministic.
/// Modes at or above audio::highest_rendered_hz must have been dropped by the caller.
Eigen::VectorXd oscillation(const std::vector<Oscillator>& oscillators, const std::vector<ModalImpulse>& impulses,
                            double sample_rate_hz, Eigen::Index n_frames);

}  // namespace klang::stage
