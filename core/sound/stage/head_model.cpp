#include "core/sound/stage/head_model.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::bubble {

void HeadModel::validate() const {
  checked("head", "radius_m", radius_m, 0.01, 0.5);
  checked("head", "ear_azimuth_deg", ear_azimuth_deg, 0.0, 180.0);
  checked("head", "sound_speed_m_s", sound_speed_m_s, 10.0, 1e4);
  if (!(facing.head<2>().norm() > 0.0) || !facing.allFinite())
    throw InputError("head", "faces no horizontal direction");
}

double HeadModel::angle_rad(int ear, const Eigen::Vector3d& source_m) const {
  const double side = ear == 0 ? 1.0 : -1.0;  // left is counter-clockwise from the nose, seen from above
  const Eigen::Vector3d nose = Eigen::Vector3d(facing.x(), facing.y(), 0.0).normalized();
  const Eigen::Vector3d axis = Eigen::AngleAxisd(side * ear_azimuth_deg * kPi / 180.0, Eigen::Vector3d::UnitZ()) * nose;
  const Eigen::Vector3d way = source_m - centre_m;
  return std::atan2(axis.cross(way).norm(), axis.dot(way));
}

double HeadModel::delay_s(double angle) const {
  const double across = radius_m / sound_speed_m_s;
  return angle < 0.5 * kPi ? -across * std::cos(angle) : across * (angle - 0.5 * kPi);
}

std::complex<double> HeadModel::shadow(double angle, double omega_rad_s) const {
  constexpr double kAlphaMin = 0.1, kAngleMinRad = 150.0 / 180.0 * kPi;
  const double alpha = (1.0 + 0.5 * kAlphaMin) + (1.0 - 0.5 * kAlphaMin) * std::cos(angle / kAngleMinRad * kPi);
  const double x = 0.5 * omega_rad_s * radius_m / sound_speed_m_s;
  return std::complex<double>(1.0, alpha * x) / std::complex<double>(1.0, x);
}

HeadModel HeadPath::at(const HeadModel& head, double time_s) const {
  if (times_s.empty()) return head;
  HeadModel moved = head;
  const auto next = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  const auto i = static_cast<std::size_t>(std::min(next, times_s.end() - 1) - times_s.begin());
  const std::size_t before = i > 0 && next != times_s.end() ? i - 1 : i;
  const double part = before < i ? (time_s - times_s[before]) / (times_s[i] - times_s[before]) : 0.0;
  moved.centre_m = centres_m[before] + part * (centres_m[i] - centres_m[before]);
  if (facings.empty()) return moved;
  const Eigen::Vector3d turned =
      facings[before].normalized() + part * (facings[i].normalized() - facings[before].normalized());
  if (turned.head<2>().norm() > 1e-6) moved.facing = turned;  // half way between opposite directions there is none
  return moved;
}

}  // namespace klang::bubble
