#include "core/sound/stage/spherical_head.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::stage {

void SphericalHead::validate() const {
  checked("head", "radius_m", radius_m, 0.01, 0.5);
  checked("head", "ear_azimuth_deg", ear_azimuth_deg, 0.0, 180.0);
  checked("head", "sound_speed_m_s", sound_speed_m_s, 10.0, 1e4);
  if (!(facing.head<2>().norm() > 0.0) || !facing.allFinite())
    throw InputError("head", "faces no horizontal direction");
}

double SphericalHead::angle_rad(int ear, const Eigen::Vector3d& source_m) const {
  const double side = ear == 0 ? 1.0 : -1.0;  // left is counter-clockwise from the nose, seen from above
  const Eigen::Vector3d nose = Eigen::Vector3d(facing.x(), facing.y(), 0.0).normalized();
  const Eigen::Vector3d axis = Eigen::AngleAxisd(side * ear_azimuth_deg * kPi / 180.0, Eigen::Vector3d::UnitZ()) * nose;
  const Eigen::Vector3d way = source_m - centre_m;
  return std::atan2(axis.cross(way).norm(), axis.dot(way));
}

double SphericalHead::delay_s(double angle) const {
  const double across = radius_m / sound_speed_m_s;
  return angle < 0.5 * kPi ? -across * std::cos(angle) : across * (angle - 0.5 * kPi);
}

std::complex<double> SphericalHead::shadow(double angle, double omega_rad_s) const {
  constexpr double kAlphaMin = 0.1, kAngleMinRad = 150.0 / 180.0 * kPi;
  const double alpha = (1.0 + 0.5 * kAlphaMin) + (1.0 - 0.5 * kAlphaMin) * std::cos(angle / kAngleMinRad * kPi);
  const double x = 0.5 * omega_rad_s * radius_m / sound_speed_m_s;
  return std::complex<double>(1.0, alpha * x) / std::complex<double>(1.0, x);
}

}  // namespace klang::stage
