#pragma once
/// How far a free bubble has risen, as plain functions of any scalar.
#include <cmath>

#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::bubble {

inline constexpr double kGravityMS2 = 9.80665;

/// Rise of a round bubble from rest or with a start: M v' = (rho - rho_g) V g - c v |v| with inertia M = rho_g V + rho
/// V / 2 (the liquid it has to move aside) and drag c = C_d rho 4 pi r^2 / 2. Zheng and James 2009 take the liquid's
/// mass for the bubble's, so that theirs sinks (docs/errata.md).
template <class T>
struct RiseLaw {
  T terminal_speed_m_s;
  T time_constant_s;  ///< M v_t / ((rho - rho_g) V g)
};

/// @param drag_coefficient  on the area 4 pi r^2: 0.2 is 0.8 on the usual pi r^2
template <class T>
RiseLaw<T> rise_law(const BubbleMedium& medium, const T& radius_m, const T& drag_coefficient) {
  using std::sqrt;
  const double rho = medium.liquid_density_kg_m3, gas = medium.gas_density_kg_m3;
  const T speed = sqrt(T(2.0 / 3.0 * kGravityMS2 * (rho - gas) / rho) * radius_m / drag_coefficient);
  return {speed, T((gas + 0.5 * rho) / ((rho - gas) * kGravityMS2)) * speed};
}

/// Way upwards after a time, from the start's speed upwards (negative: it sinks at first). Closed form:
///   v_t tau ln(cosh(t/tau) + (v0/v_t) sinh(t/tau)) for v0 >= 0;
///   while it sinks -v_t tau ln(cos(t/tau) - (v0/v_t) sin(t/tau))
template <class T>
T risen_m(const RiseLaw<T>& law, const T& start_speed_m_s, const T& time_s) {
  using std::atan;
  using std::cos;
  using std::exp;
  using std::log;
  using std::sin;
  using std::sqrt;
  const T length = law.terminal_speed_m_s * law.time_constant_s;
  T start = start_speed_m_s / law.terminal_speed_m_s, x = time_s / law.time_constant_s, sunk(0.0);
  if (start < T(0.0)) {
    const T turn = atan(-start);
    if (x < turn) return -length * log(cos(x) - start * sin(x));
    sunk = T(0.5) * length * log(T(1.0) + start * start);
    x = x - turn;
    start = T(0.0);
  }
  return length * (x + log((T(1.0) + start + (T(1.0) - start) * exp(T(-2.0) * x)) * T(0.5))) - sunk;
}

}  // namespace klang::bubble
