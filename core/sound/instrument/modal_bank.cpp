#include "core/sound/instrument/modal_bank.hpp"

#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/surface_coupling.hpp"

namespace klang::instrument {

Eigen::VectorXd bank_sound(const ModalBank& bank, double sample_rate_hz, Eigen::Index n_frames) {
  using Complex = std::complex<double>;
  constexpr Eigen::Index kRestart = 1024;  // the phase is set anew, so that round-off does not grow
  Eigen::VectorXd sound = Eigen::VectorXd::Zero(n_frames);
  for (const BankPartial& partial : bank.partials) {
    if (partial.frequency_hz >= audio::highest_rendered_hz(sample_rate_hz)) continue;
    const Complex rate(-partial.decay_per_s / sample_rate_hz, 2.0 * kPi * partial.frequency_hz / sample_rate_hz);
    const Complex step = std::exp(rate), start = std::polar(partial.amplitude, partial.phase_rad);
    for (Eigen::Index first = 0; first < n_frames; first += kRestart) {
      const double envelope = std::exp(rate.real() * static_cast<double>(first));
      if (envelope < 1e-15) break;
      Complex z = start * std::exp(rate * static_cast<double>(first));
      for (Eigen::Index i = first; i < std::min(first + kRestart, n_frames); ++i) {
        sound[i] += z.real();
        z = {z.real() * step.real() - z.imag() * step.imag(), z.real() * step.imag() + z.imag() * step.real()};
      }
    }
  }
  return sound;
}

double pitch_hz(const ModalBank& bank) {
  for (const BankPartial& partial : bank.partials) {
    if (!partial.is_weak) return partial.frequency_hz;
  }
  return bank.partials.front().frequency_hz;
}

double time_to_amplitude_s(const ModalBank& bank, double amplitude, double sample_rate_hz) {
  const auto envelope = [&](double t) {
    double sum = 0.0;
    for (const BankPartial& partial : bank.partials) {
      if (partial.frequency_hz < audio::highest_rendered_hz(sample_rate_hz))
        sum += std::abs(partial.amplitude) * std::exp(-partial.decay_per_s * t);
    }
    return sum;
  };
  double low = 0.0, high = 1e-3;
  while (envelope(high) > amplitude) {
    low = high;
    high *= 2.0;
    if (high > 1e9) return std::numeric_limits<double>::infinity();
  }
  for (int i = 0; i < 60; ++i) (envelope(0.5 * (low + high)) > amplitude ? low : high) = 0.5 * (low + high);
  return high;
}

ModalBank struck_bank(const modal::ModalModel& model, const Eigen::VectorXd& decay_per_s,
                      const events::Strike& strike) {
  using Complex = std::complex<double>;
  const Eigen::VectorXd push = stage::push_at_nearest_node(model)(strike.point_m, strike.impulse_n_s);
  const Eigen::VectorXd gain = stage::heard_coupling(model, decay_per_s, push);
  const events::GaussianPulse pulse = events::gaussian_pulse(strike);
  ModalBank bank;
  for (Eigen::Index i = 0; i < model.n_modes(); ++i) {
    const double omega = model.angular_frequency_rad_s[i], decay = decay_per_s[i];
    if (!(decay < omega)) continue;
    const double damped = std::sqrt((omega - decay) * (omega + decay));
    const Complex pole(-decay, damped);
    // Im z = Re(-i z)
    const Complex z = Complex(0.0, -1.0) * (push[i] * gain[i] / damped) *
                      std::exp(pole * (0.5 * pole * std::pow(pulse.standard_deviation_s, 2) - pulse.centre_s));
    bank.partials.push_back({damped / (2.0 * kPi), decay, std::abs(z), std::arg(z)});
  }
  double loudest = 0.0;
  for (const BankPartial& partial : bank.partials) loudest = std::max(loudest, partial.amplitude);
  // The other one of a pair, and what is struck at its node.
  std::erase_if(bank.partials, [&](const BankPartial& partial) { return !(partial.amplitude > kSilent * loudest); });
  for (BankPartial& partial : bank.partials) partial.is_weak = !(partial.amplitude > kWeak * loudest);
  return bank;
}

void normalise(ModalBank& bank, double peak, double sample_rate_hz, double duration_s) {
  const auto n_frames = static_cast<Eigen::Index>(std::ceil(sample_rate_hz * duration_s));
  const double now = bank_sound(bank, sample_rate_hz, n_frames).cwiseAbs().maxCoeff();
  if (!(now > 0.0)) throw InputError(bank.name, "is silent: no partial rings below half the sample rate");
  for (BankPartial& partial : bank.partials) partial.amplitude *= peak / now;
}

}  // namespace klang::instrument
