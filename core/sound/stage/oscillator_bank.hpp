#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/modal/modal_model.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::modal {

/// One strike of a body: a Gaussian force pulse of unit area times the impulse (a Dirac pulse when duration is 0), at a
/// time that need not fall on a sample.
struct Strike {
  double time_s = 0.0;
  int node = 0;
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();
  double contact_duration_s = 0.0;  ///< standard deviation of the Gaussian pulse, >= 0
};

/// One damped oscillator: z'' + 2 decay z' + omega^2 z = g(t).
struct Oscillator {
  double angular_frequency_rad_s = 0.0;  ///< undamped, >= 0
  double decay_per_s = 0.0;              ///< >= 0; over-damped when above angular_frequency_rad_s
  double output_gain = 1.0;              ///< weight of z in the mix
};

/// A modal impulse into each oscillator at one time (z' jumps by impulse[i]).
struct ModalImpulse {
  double time_s = 0.0;
  Eigen::VectorXd impulse;  ///< n_oscillators
  double contact_duration_s = 0.0;
};

/// sum_i output_gain_i z_i at n_frames samples of sample_rate_hz, by the exact one-step recurrence (under-, critically
/// and over-damped, and rigid), to round-off of the closed form. Vectorised and parallel over modes; deterministic.
/// Modes at or above half the sample rate must have been dropped by the caller.
Eigen::VectorXd render(const std::vector<Oscillator>& oscillators, const std::vector<ModalImpulse>& impulses,
                       double sample_rate_hz, Eigen::Index n_frames);

/// S02 section 3.4: sum over the surface of |normal displacement| times area, times the frequency in Hz; n_modes.
Eigen::VectorXd surface_coupling(const ModalModel& model);

struct SynthesisOptions {
  double sample_rate_hz = 48000.0;  ///< 1000 to 768000
  double duration_s = 3.0;
  bool couple_to_air = true;  ///< weight by surface_coupling; otherwise by displacement at pickup_node
  int pickup_node = -1;       ///< used when couple_to_air is false
  Eigen::Vector3d pickup_direction = Eigen::Vector3d::UnitZ();
};

/// Sound of strikes on a modal body with the given decay of each mode (S02 eq. 18 with factor 1: errata 2).
audio::Signal synthesise(const ModalModel& model, const Eigen::VectorXd& decay_per_s,
                         const std::vector<Strike>& strikes, const SynthesisOptions& options);

}  // namespace klang::modal
