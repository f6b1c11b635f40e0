#pragma once
/// The one place where signs, units and reference levels are fixed. Nothing else restates them.
///
/// Time:     a steady oscillation is Re(X e^{+i omega t}); outgoing waves are h_n^(2).
///           A decaying partial is amplitude * exp(-decay_per_s t) * cos(2 pi frequency_hz t + phase_rad),
///           t counted from its strike; decay_per_s is the decay of the amplitude (half that of the energy).
/// Space:    right-handed, metres; surface normals point out of the solid.
/// Modes:    K u = omega^2 M u with u^T M u = 1, K = lambda K_lambda + mu K_mu.
/// Damping:  C = rayleigh_stiffness_s K + rayleigh_mass_per_s M, so that
///           decay_per_s = (rayleigh_stiffness_s omega^2 + rayleigh_mass_per_s) / 2.
/// Pitch:    cents(f, g) = 1200 log2(f / g).
namespace klang {

inline constexpr double kPi = 3.141592653589793238462643383279502884;

/// Sound-pressure levels are in dB re 20 uPa; digital levels are in dB re full scale (a sine of amplitude 1 = 0 dB).
inline constexpr double kReferencePressurePa = 20e-6;

/// The band in which partials and modes are looked for unless another is asked.
inline constexpr double kAudibleLowHz = 20.0;
inline constexpr double kAudibleHighHz = 20000.0;

struct Band {
  double low_hz = kAudibleLowHz;
  double high_hz = kAudibleHighHz;
};

/// 1200 log2(frequency_hz / reference_hz); both > 0.
double cents(double frequency_hz, double reference_hz);

}  // namespace klang
