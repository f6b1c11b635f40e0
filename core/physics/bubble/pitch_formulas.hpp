#pragma once
/// How the pitch of a bubble rises as it nears the free surface, as plain functions of any scalar (double, Ceres Jets,
/// Taylor series). phi is the signed distance of the bubble's centre to the surface: negative in the liquid, 0 at the
/// surface.
#include <array>
#include <cmath>

namespace klang::bubble {

enum class PitchKind {
  kConstant,              ///< frequency of the unbounded liquid
  kHarmonicFluids,        ///< eq. (6) with omega updated at each step: d ln omega = K e^{-eta (phi/phi0 - 1)} dphi
  kHarmonicFluidsFrozen,  ///< eq. (6) with omega of the start in the increment
  kStrasberg,             ///< plane surface, Strasberg's formula
  kTwoSphere              ///< plane surface, exact: the bubble and its mirror image (bispherical series)
};

/// Eq. (6) has no limit of its own: from depth it multiplies the pitch by 5 (phi0 = -8 mm) to 161 (-25 mm), hence the
/// clamp.
struct PitchModel {
  PitchKind kind = PitchKind::kHarmonicFluids;
  double k_delta_per_m = 72.95;  ///< K, 0 to 1e4
  double eta = 1.24;             ///< 0.01 to 100
  double phi0_m = -0.008;        ///< -1 to -1e-5
  double largest_factor = 3.0;   ///< no model raises the pitch above this, 1 to 1000
  void validate() const;         ///< InputError
};

/// Integral of K e^{-eta (phi/phi0 - 1)} from phi_start to phi:
///   K e^eta |phi0| / eta (e^{-eta phi/phi0} - e^{-eta phi_start/phi0})
/// @param phi_m, phi_start_m, phi0_m  all negative; eta > 0
/// Only K e^eta |phi0| / eta and eta / |phi0| enter: from one drop with a known rise two numbers follow, not three.
template <class T>
T pitch_integral(const T& phi_m, const T& phi_start_m, const T& k_delta_per_m, const T& eta, const T& phi0_m) {
  using std::exp;
  return k_delta_per_m * exp(eta) * (-phi0_m) / eta * (exp(-eta * phi_m / phi0_m) - exp(-eta * phi_start_m / phi0_m));
}

/// Pitch over that at phi_start by eq. (6) of Zheng and James 2009, before any clamp: exp(I), or 1 + I when frozen,
/// with I = pitch_integral. (The paper has the damped frequency in the increment; with a damping of 0.04 that is 0.02 %
/// of I.)
template <class T>
T harmonic_fluids_factor(const T& phi_m, const T& phi_start_m, const T& k_delta_per_m, const T& eta, const T& phi0_m,
                         bool frozen = false) {
  using std::exp;
  const T integral = pitch_integral(phi_m, phi_start_m, k_delta_per_m, eta, phi0_m);
  return frozen ? T(1.0) + integral : T(exp(integral));
}

/// Strasberg's formula for a plane free surface: (1 - r/2d - (r/2d)^4)^(-1/2); 1.512 at touch, 0.03 % low at d = 2 r
/// and 7 % low at d = 1.05 r. Source: Strasberg 1953, J. Acoust. Soc. Am. 25, 536-537.
template <class T>
T strasberg_factor(const T& depth_over_radius) {
  using std::sqrt;
  const T x = T(0.5) / depth_over_radius;
  return T(1.0) / sqrt(T(1.0) - x - x * x * x * x);
}

namespace detail {

/// sum_{n >= 1} 1 / sinh(n a), a > 0, to round-off: the series, or for small a (where it converges slowly) its Mellin
/// expansion
///   [ln(2/a) + Euler's gamma] / a - sum_k 2 (1 - 2^k) zeta(-k)^2 / k! a^k,  k = 1, 3, 5, ...
template <class T>
T sinh_series(const T& a) {
  using std::exp;
  using std::log;
  if (a < T(0.5)) {
    constexpr double kEulerGamma = 0.57721566490153286061;
    constexpr std::array<double, 8> kZeta = {-1.0 / 12,     1.0 / 120, -1.0 / 252,   1.0 / 240, -1.0 / 132,
                                             691.0 / 32760, -1.0 / 12, 3617.0 / 8160};  // at -1, -3, ..., -15
    T sum = (log(T(2.0) / a) + T(kEulerGamma)) / a;
    T power = a;
    double factorial = 1.0, two_to_k = 2.0;
    for (int i = 0; i < 8; ++i) {
      const auto zeta = kZeta[static_cast<std::size_t>(i)];
      sum = sum - T(2.0 * (1.0 - two_to_k) * zeta * zeta / factorial) * power;
      power = power * a * a;
      const double k = 2.0 * i + 1.0;
      factorial *= (k + 1.0) * (k + 2.0);
      two_to_k *= 4.0;
    }
    return sum;
  }
  T sum = T(0.0), fall = exp(-a), term = fall;
  const T step = fall;
  while (term > T(1e-18)) {
    sum = sum + T(2.0) * term / (T(1.0) - term * term);
    term = term * step;
  }
  return sum;
}

}  // namespace detail

/// Exact pitch factor beside a plane free surface (the bubble's pressure uniform, the liquid incompressible):
///   f^2 / f_inf^2 = sinh(a) sum_n 1 / sinh(n a), cosh a = d / r
/// 1.158 at d = 2 r, 1.571 at 1.05 r, grows without limit (as a logarithm) at touch.
/// @param depth_over_radius  above 1
template <class T>
T two_sphere_factor(const T& depth_over_radius) {
  using std::log;
  using std::sqrt;
  const T sinh_a = sqrt((depth_over_radius - T(1.0)) * (depth_over_radius + T(1.0)));
  const T a = log(depth_over_radius + sinh_a);
  return sqrt(sinh_a * detail::sinh_series(a));
}

/// The same beside a rigid wall: sinh(a) sum_n (-1)^(n+1) / sinh(n a); sqrt(ln 2) = 0.8326 at touch.
template <class T>
T rigid_wall_factor(const T& depth_over_radius) {
  using std::log;
  using std::sqrt;
  const T sinh_a = sqrt((depth_over_radius - T(1.0)) * (depth_over_radius + T(1.0)));
  const T a = log(depth_over_radius + sinh_a);
  return sqrt(sinh_a * (detail::sinh_series(a) - T(2.0) * detail::sinh_series(T(2.0) * a)));
}

/// Pitch factor of a model, clamped to 1 / largest_factor ... largest_factor (a bubble that sinks falls in pitch).
/// Against the frequency of the unbounded liquid; eq. (6) takes that as the frequency at phi_start.
/// @param phi_m  the plane models take the depth as -phi, at least 1.001 r
template <class T>
T pitch_factor(const PitchModel& model, const T& radius_m, const T& phi_m, const T& phi_start_m) {
  T factor(1.0);
  switch (model.kind) {
    case PitchKind::kConstant:
      return factor;
    case PitchKind::kHarmonicFluids:
    case PitchKind::kHarmonicFluidsFrozen:
      factor = harmonic_fluids_factor(phi_m, phi_start_m, T(model.k_delta_per_m), T(model.eta), T(model.phi0_m),
                                      model.kind == PitchKind::kHarmonicFluidsFrozen);
      break;
    case PitchKind::kStrasberg:
    case PitchKind::kTwoSphere: {
      T ratio = -phi_m / radius_m;
      if (!(ratio > T(1.001))) ratio = T(1.001);
      factor = model.kind == PitchKind::kStrasberg ? strasberg_factor(ratio) : two_sphere_factor(ratio);
      break;
    }
  }
  if (!(factor < T(model.largest_factor))) factor = T(model.largest_factor);
  if (!(factor > T(1.0 / model.largest_factor))) factor = T(1.0 / model.largest_factor);
  return factor;
}

}  // namespace klang::bubble
