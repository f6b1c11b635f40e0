#pragma once
#include <Eigen/Core>
#include <complex>

namespace klang::stage {

/// Sound at the two ears of a spherical head: arrival times and head shadow of the structural model of Brown and Duda
/// 1998, IEEE Trans. Speech Audio Process. 6, 476-488. Their echoes of pinna, shoulders and room are left out, so that
/// front and back, and up and down, differ only as far as the angle to the ears does.
///   delay    T(a) = -(R/c) cos a for a < 90 deg, else (R/c) (a - 90 deg), against the head's centre
///   shadow   H(omega, a) = (1 + i alpha omega R / 2c) / (1 + i omega R / 2c)
///            alpha(a) = (1 + 0.1/2) + (1 - 0.1/2) cos(a / 150 deg * 180 deg)
/// with a the angle between the source and the ear seen from the head's centre.
struct SphericalHead {
  Eigen::Vector3d centre_m = {0.0, -1.0, 0.5};
  Eigen::Vector3d facing = {0.0, 1.0, 0.0};  ///< direction of the nose; its horizontal part counts
  double radius_m = 0.0875;                  ///< 0.01 to 0.5
  double ear_azimuth_deg = 100.0;            ///< of each ear from the nose; 0 to 180
  double sound_speed_m_s = 343.0;            ///< 10 to 1e4
  void validate() const;                     ///< InputError

  /// Angle between ear (0 left, 1 right) and source, 0 to pi.
  double angle_rad(int ear, const Eigen::Vector3d& source_m) const;
  double delay_s(double angle_rad) const;
  /// The shortest delay, -R/c: against it no sound arrives too early.
  double lead_s() const { return radius_m / sound_speed_m_s; }
  std::complex<double> shadow(double angle_rad, double omega_rad_s) const;
};

}  // namespace klang::stage
