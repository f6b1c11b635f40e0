#pragma once
/// A ringing bubble of slowly changing pitch as plain functions of any scalar: what a fit needs.
///   q(t) = A (omega_d(0)/omega_d(t))^(1/2) exp(-int beta) sin(int omega_d)      radius, from the onset on
///   p(t) ~ r^2 q'' ~ r^2 omega0(t)^2 q(t)                                      pressure of a small source
/// This is the oscillator q'' + 2 beta q' + omega0^2 q = 0 to first order in (d omega/dt)/omega^2 (about 1e-3 for
/// drops): against the exact solution it is off by up to 0.02 of the envelope for a pitch that doubles in 30 ms, most
/// of it a slow drift of the phase, int beta' / (2 omega_d) dt. bubble_ring.hpp has the next orders.
#include <cmath>
#include <cstddef>
#include <span>

#include "core/physics/bubble/bubble_formulas.hpp"

namespace klang::bubble {

template <class T>
struct RingRate {
  T omega0_rad_s;   ///< undamped
  T omega_d_rad_s;  ///< heard: sqrt(omega0^2 - beta^2)
  T decay_per_s;    ///< beta, of the amplitude of q at constant pitch
};

/// Rates at a moment when the pitch is factor times that of the unbounded liquid; the damping follows the new
/// frequency.
template <class T>
RingRate<T> ring_rate(const BubbleMedium& medium, BubbleTheory theory, const T& radius_m, const T& omega_inf_rad_s,
                      const T& factor) {
  using std::sqrt;
  const T omega0 = omega_inf_rad_s * factor;
  const T decay = bubble_damping(medium, theory, radius_m, omega0).decay_per_s;
  return {omega0, T(sqrt(omega0 * omega0 - decay * decay)), decay};
}

/// Level of the pressure over exp(-int beta): (omega_d(0)/omega_d)^(1/2) (omega0/omega0(0))^2, about factor^(3/2).
template <class T>
T pressure_rise(const RingRate<T>& now, const RingRate<T>& onset) {
  using std::sqrt;
  const T ratio = now.omega0_rad_s / onset.omega0_rad_s;
  return T(sqrt(onset.omega_d_rad_s / now.omega_d_rad_s)) * ratio * ratio;
}

/// int omega_d dt and int beta dt from time 0 to each of the ascending times, by Gauss's rule of 3 points (order 6) in
/// each interval; rate(T time) gives a RingRate<T>. Intervals of a millisecond are enough for drops.
template <class T, class Rate>
void integrate_rates(std::span<const double> times_s, const Rate& rate, std::span<T> phase_rad, std::span<T> decay) {
  constexpr double kNode = 0.38729833462074168852;  // sqrt(0.6) / 2
  constexpr double kOffset[3] = {-kNode, 0.0, kNode}, kWeight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  T phase(0.0), fall(0.0);
  double from = 0.0;
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double width = times_s[i] - from, middle = 0.5 * (times_s[i] + from);
    for (int g = 0; g < 3; ++g) {
      const RingRate<T> at = rate(T(middle + kOffset[g] * width));
      phase = phase + T(kWeight[g] * width) * at.omega_d_rad_s;
      fall = fall + T(kWeight[g] * width) * at.decay_per_s;
    }
    phase_rad[i] = phase;
    decay[i] = fall;
    from = times_s[i];
  }
}

/// Numbers of eq. (39): the fall at which the attack is over, and twice the square of its width.
inline constexpr double kAttackFall = 0.85, kAttackWidth = 0.0028125;

/// Soft attack, eq. (39): factor on q from the onset on; C1 at e^{-beta t} = 0.85, that is t = 0.1625 / beta, and 1
/// after.
template <class T>
T attack_window(const T& decay_per_s, const T& time_s) {
  using std::exp;
  const T fallen = exp(-decay_per_s * time_s);
  if (fallen < T(kAttackFall)) return T(1.0);
  const T x = fallen - T(kAttackFall);
  return exp(-x * x / T(kAttackWidth));
}

}  // namespace klang::bubble
