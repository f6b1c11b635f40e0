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

/// What of an oscillator's motion counts.
enum class Heard {
  kMotion,  ///< z
  /// z without the bending under forces that are slow against its period: z - s (f * g) / omega^2, f the force of a pulse, g a
  /// normal density of standard deviation 1 / omega, s = 1 - |F(omega)|^2 / F(0)^2. What a mode radiates goes with its
  /// acceleration; as z itself a contact longer than the period would be a thump many times louder than the ring. A pulse
  /// that is short against the period is heard as it moves the mode, and what rings afterwards is z.
  kRinging,
};

/// sum_i output_gain_i z_i at n_frames samples of sample_rate_hz, by the exact one-step recurrence (under-, critically
/// and over-damped, and rigid), to round-off of the closed form. Vectorised and parallel over modes; deterministic.
/// Modes at or above audio::highest_rendered_hz must have been dropped by the caller.
Eigen::VectorXd oscillation(const std::vector<Oscillator>& oscillators, const std::vector<ModalImpulse>& impulses,
                            double sample_rate_hz, Eigen::Index n_frames, Heard heard = Heard::kMotion);

}  // namespace klang::stage
