#pragma once
/// Frequency and damping of a spherical gas bubble as plain functions of any scalar: double, automatic derivatives
/// (Ceres Jets) or Taylor series in time. No checks here; bubble_physics.hpp has the checked form.
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::bubble {

/// Dimensionless damping and the decay of the amplitude.
template <class T>
struct BubbleDamping {
  T delta_radiation, delta_viscous, delta_thermal;
  T decay_per_s;  ///< beta
};

/// Prosperetti's response of the gas: pressure over relative volume change, both as seen at angular frequency omega.
///   Phi = 3 gamma / (1 - 3 (gamma - 1) i chi [ (i/chi)^(1/2) coth (i/chi)^(1/2) - 1 ]),  chi = D / (omega r^2)
/// real: 3 times the polytropic index (gamma when fast, 1 when slow); imaginary: the loss by heat.
/// Source: Prosperetti, Crum and Commander 1988, J. Acoust. Soc. Am. 83, 502-514.
template <class T>
struct GasResponse {
  T real, imaginary;
};

template <class T>
GasResponse<T> gas_response(const BubbleMedium& medium, const T& radius_m, const T& angular_frequency_rad_s) {
  using std::cos;
  using std::exp;
  using std::sin;
  using std::sqrt;
  const double gamma = medium.heat_capacity_ratio;
  const T chi = medium.gas_diffusivity_m2_s / (angular_frequency_rad_s * radius_m * radius_m);
  // (i/chi)^(1/2) = (1 + i) a. coth((1 + i) a) = (sinh 2a - i sin 2a) / (cosh 2a - cos 2a), over cosh 2a against
  // overflow.
  const T a = sqrt(T(0.5) / chi);
  const T fall = exp(T(-2.0) * a);
  const T below = T(1.0) + fall * fall - T(2.0) * fall * cos(T(2.0) * a);
  const T coth_real = (T(1.0) - fall * fall) / below;
  const T coth_imag = T(-2.0) * fall * sin(T(2.0) * a) / below;
  const T bracket_real = a * (coth_real - coth_imag) - T(1.0);
  const T bracket_imag = a * (coth_real + coth_imag);
  // 1 - 3 (gamma - 1) i chi (x + i y) = (1 + k y) - i k x
  const T k = T(3.0 * (gamma - 1.0)) * chi;
  const T p = T(1.0) + k * bracket_imag, q = k * bracket_real;
  const T norm = T(3.0 * gamma) / (p * p + q * q);
  return {norm * p, norm * q};
}

/// Angular frequency of the free, undamped breathing mode in an unbounded liquid.
///   Leighton:    omega0^2 = [3 gamma (p0 + 2 sigma/r) - 2 sigma/r] / (rho r^2)
///   Prosperetti: omega0^2 = [Re Phi(omega0) (p0 + 2 sigma/r) - 2 sigma/r] / (rho r^2)
///   paper:       omega0^2 = [3 gamma p0 - 2 sigma/r] / (rho r^2)
template <class T>
T undamped_angular_frequency_rad_s(const BubbleMedium& medium, BubbleTheory theory, const T& radius_m) {
  using std::sqrt;
  const T tension = T(2.0 * medium.surface_tension_n_m) / radius_m;
  const T gas_pressure = T(medium.static_pressure_pa) + tension;
  const double stiffness = 3.0 * medium.heat_capacity_ratio;
  const T scale = sqrt(T(medium.liquid_density_kg_m3)) * radius_m;
  if (theory == BubbleTheory::kPaper) return sqrt(T(stiffness * medium.static_pressure_pa) - tension) / scale;
  T omega = sqrt(T(stiffness) * gas_pressure - tension) / scale;
  if (theory == BubbleTheory::kProsperetti) {
    // The index changes slowly with frequency: each turn wins a digit or more, also of derivatives.
    for (int turn = 0; turn < 40; ++turn) {
      omega = sqrt(gas_response(medium, radius_m, omega).real * gas_pressure - tension) / scale;
    }
  }
  return omega;
}

/// Damping of a bubble that breathes at omega0, which may be raised by a surface nearby.
///   decay = omega0 delta / sqrt(delta^2 + 4), delta the sum of
///   delta_radiation = omega0 r / c_f, delta_viscous = 4 mu / (rho omega0 r^2),
///   delta_thermal   = 2 [sqrt(psi - 3) - (3 gamma - 1) / (3 (gamma - 1))] / (psi - 4)
///   psi = 16 / (9 (gamma - 1)^2) G g / f0, f0 = omega0 / 2 pi, G = 3 gamma p0 / (4 pi rho D),
///   g = 1 + 2 sigma / (p0 r) (1 - 1 / (3 gamma))
/// Prosperetti: delta_thermal = Im Phi / [Re Phi - 2 sigma / (r (p0 + 2 sigma/r))] at omega0, decay = omega0 delta / 2.
/// Paper: g = 9.8 and omega0 for f0, as printed.
template <class T>
BubbleDamping<T> bubble_damping(const BubbleMedium& medium, BubbleTheory theory, const T& radius_m,
                                const T& omega0_rad_s) {
  using std::sqrt;
  const double gamma = medium.heat_capacity_ratio, p0 = medium.static_pressure_pa;
  const T tension = T(2.0 * medium.surface_tension_n_m) / radius_m;
  BubbleDamping<T> damping;
  damping.delta_radiation = omega0_rad_s * radius_m / T(medium.liquid_sound_speed_m_s);
  damping.delta_viscous =
      T(4.0 * medium.liquid_viscosity_pa_s / medium.liquid_density_kg_m3) / (omega0_rad_s * radius_m * radius_m);
  if (theory == BubbleTheory::kProsperetti) {
    const GasResponse<T> gas = gas_response(medium, radius_m, omega0_rad_s);
    damping.delta_thermal = gas.imaginary / (gas.real - tension / (T(p0) + tension));
  } else {
    constexpr double kPrintedG = 9.8;
    const double conduction =
        3.0 * gamma * p0 / (4.0 * kPi * medium.liquid_density_kg_m3 * medium.gas_diffusivity_m2_s);
    const double factor = 16.0 / (9.0 * (gamma - 1.0) * (gamma - 1.0)) * conduction;
    const T psi = theory == BubbleTheory::kPaper
                      ? T(factor * kPrintedG) / omega0_rad_s
                      : T(factor * 2.0 * kPi) * (T(1.0) + tension * T((1.0 - 1.0 / (3.0 * gamma)) / p0)) / omega0_rad_s;
    // Where the bracket is negative the form does not hold; below psi = 4 it would pass for damping, and a great one.
    const T bracket = sqrt(psi - T(3.0)) - T((3.0 * gamma - 1.0) / (3.0 * (gamma - 1.0)));
    damping.delta_thermal = T(2.0) * bracket / (psi < T(4.0) ? T(4.0) - psi : psi - T(4.0));
  }
  const T delta = damping.delta_radiation + damping.delta_viscous + damping.delta_thermal;
  damping.decay_per_s = theory == BubbleTheory::kProsperetti ? T(0.5) * omega0_rad_s * delta
                                                             : omega0_rad_s * delta / sqrt(delta * delta + T(4.0));
  return damping;
}

}  // namespace klang::bubble
