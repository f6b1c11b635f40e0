#pragma once

namespace klang::stage::detail {

/// Closed forms of z'' + 2 decay z' + omega^2 z = g, in extended precision so that the phase omega t keeps
/// 1e-13 rad over minutes. All damping regimes (under-, near-critically, critically, over-damped, rigid omega
/// = 0) in one form:
///   delta^2 = omega^2 - decay^2
///   h(t)  = e^(-decay t) t sinc(delta t)            response z to a unit jump of z'   [s]
///   h'(t) = e^(-decay t) (cos(delta t) - decay t sinc(delta t))                       [1]
///   H(t)  = int_0^t h                               response z to a unit constant force [s^2]
/// with sinh and cosh where delta^2 < 0. A free state moves as z(t) = z0 (h' + 2 decay h) + z0' h,
/// z'(t) = -omega^2 h z0 + h' z0' (H03 eqs. 8-11).
class OscillatorResponse {
 public:
  /// omega >= 0 [rad/s], decay >= 0 [1/s], finite.
  OscillatorResponse(double angular_frequency_rad_s, double decay_per_s);

  struct Impulse {
    long double z;   ///< h
    long double zd;  ///< h'
  };
  Impulse impulse(long double time_s) const;  ///< time_s >= 0
  long double step(long double time_s) const;

  long double omega_sq() const { return omega_sq_; }
  long double damping() const { return 2.0L * decay_; }

 private:
  long double decay_, omega_sq_, delta_sq_;
};

}  // namespace klang::stage::detail
