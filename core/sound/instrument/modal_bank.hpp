#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/physics/events/impulse.hpp"
#include "core/physics/modal/modal_model.hpp"

namespace klang::instrument {

/// amplitude exp(-decay_per_s t) cos(2 pi frequency_hz t + phase_rad) from t = 0 on.
struct BankPartial {
  double frequency_hz = 0.0, decay_per_s = 0.0, amplitude = 0.0, phase_rad = 0.0;
  bool is_weak =
      false;  ///< sounds, but names no pitch: 60 dB or more below the loudest, or so called by who measured it

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "that is heard", inside(0.0, 1e9)}, self.frequency_hz);
    visit({"decay_per_s", "of the amplitude: exp(-decay t)", at_least(0.0)}, self.decay_per_s);
    visit({"amplitude", "at time 0, full scale = 1"}, self.amplitude);
    visit({"phase_rad", "at time 0: cos(2 pi f t + phase)"}, self.phase_rad);
  }
};

/// What one thing sounds like after one strike, as a sum of partials.
struct ModalBank {
  std::string name;
  std::vector<BankPartial> partials;  ///< ascending in frequency
};

/// The bank as sound: samples at t = i / sample_rate_hz. Partials at or above audio::highest_rendered_hz are left out.
Eigen::VectorXd bank_sound(const ModalBank& bank, double sample_rate_hz, Eigen::Index n_frames);

/// The lowest partial that is not weak; of a bank that has weak ones only, the lowest.
double pitch_hz(const ModalBank& bank);

/// Where the sum of the envelopes of the partials that are rendered at that rate has fallen to an amplitude [s]; infinite where it never does.
double time_to_amplitude_s(const ModalBank& bank, double amplitude, double sample_rate_hz);

inline constexpr double kSilent = 1e-9, kWeak = 1e-3;

/// The bank of a model after a Gaussian strike, what stage::synthesise() sounds like once the pulse is over:
///   gain_i / w_i Im(exp(p_i (t - centre)) exp(p_i^2 s^2 / 2)) u_i . J,  p = -decay + i w (damped w), s the pulse's standard deviation.
/// Over-damped modes do not ring, and those below kSilent of the loudest are not heard: they are left out; those below kWeak of it are weak.
ModalBank struck_bank(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s, const events::Strike& strike);

inline constexpr double kPeak = 0.7079457843841379, kPeakWithinS = 3.0;  ///< -3 dB re full scale

/// Amplitudes times one factor so that the sound's peak within duration_s is peak (full scale = 1).
void normalise(ModalBank& bank, double peak, double sample_rate_hz, double duration_s);

}  // namespace klang::instrument
