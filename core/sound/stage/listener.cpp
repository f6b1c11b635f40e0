#include "core/sound/stage/listener.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::stage {

Listener Listener::without_place(int n_channels) {
  Listener listener;
  listener.n_channels_ = n_channels;
  return listener;
}

Listener Listener::ears(std::vector<double> times_s, Eigen::Matrix3Xd left_m, Eigen::Matrix3Xd right_m) {
  Listener listener;
  listener.n_channels_ = right_m.cols() > 0 ? 2 : 1;
  listener.times_s_ = std::move(times_s);
  listener.left_m_ = std::move(left_m);
  listener.right_m_ = std::move(right_m);
  return listener;
}

Listener Listener::head(std::vector<double> times_s, Eigen::Matrix3Xd centres_m, Eigen::Matrix3Xd facings,
                        const SphericalHead& head) {
  Listener listener;
  listener.n_channels_ = 2;
  listener.has_head_ = true;
  listener.times_s_ = std::move(times_s);
  listener.left_m_ = std::move(centres_m);
  for (Eigen::Index i = 0; i < facings.cols(); ++i) facings.col(i) = Eigen::Vector3d(facings.col(i)).normalized();
  listener.facings_ = std::move(facings);
  listener.head_ = head;
  return listener;
}

void Listener::validate() const {
  if (n_channels_ < 1) throw InputError("listener", "has no channel", std::to_string(n_channels_));
  const auto n = static_cast<Eigen::Index>(times_s_.size());
  const auto fits = [&](const Eigen::Matrix3Xd& points, bool may_be_empty) {
    return points.allFinite() && (points.cols() == n || (may_be_empty && points.cols() == 0));
  };
  if (!fits(left_m_, false) || !fits(right_m_, true) || !fits(facings_, true))
    throw InputError("listener", "needs one finite place for each time");
  for (std::size_t i = 0; i < times_s_.size(); ++i) {
    if (!std::isfinite(times_s_[i]) || (i > 0 && !(times_s_[i - 1] < times_s_[i])))
      throw InputError("listener", "times do not rise", to_text(times_s_[i]));
  }
  if (!has_head_) return;
  for (std::size_t i = 0; i < times_s_.size(); ++i) head_at(times_s_[i]).validate();
}

Eigen::Vector3d Listener::along(const Eigen::Matrix3Xd& points, double t) const {
  const auto n = static_cast<Eigen::Index>(times_s_.size());
  const double* const begin = times_s_.data();
  const auto after = static_cast<Eigen::Index>(std::upper_bound(begin, begin + n, t) - begin);
  if (after == 0) return points.col(0);
  if (after == n) return points.col(n - 1);
  const double share = (t - begin[after - 1]) / (begin[after] - begin[after - 1]);
  return points.col(after - 1) + share * (points.col(after) - points.col(after - 1));
}

Eigen::Vector3d Listener::ear_m(int channel, double time_s) const {
  return along(channel == 0 || has_head_ ? left_m_ : right_m_, time_s);
}

Eigen::Vector3d Listener::centre_m(double time_s) const {
  if (has_head_ || !stereo()) return ear_m(0, time_s);
  return 0.5 * (ear_m(0, time_s) + ear_m(1, time_s));
}

SphericalHead Listener::head_at(double time_s) const {
  SphericalHead head = head_;
  head.centre_m = centre_m(time_s);
  if (facings_.cols() == 0) return head;
  const Eigen::Vector3d turned = along(facings_, time_s);
  if (turned.head<2>().norm() > 1e-6) head.facing = turned;  // half way between opposite directions there is none
  return head;
}

std::complex<double> Listener::shadow(int channel, double time_s, const Eigen::Vector3d& source_m,
                                      double omega_rad_s) const {
  if (!has_head_) return 1.0;
  const SphericalHead head = head_at(time_s);
  return head.shadow(head.angle_rad(channel, source_m), omega_rad_s);
}

double Listener::way_s(int channel, double time_s, const Eigen::Vector3d& source_m, double sound_speed_m_s) const {
  if (has_head_) {
    const SphericalHead head = head_at(time_s);
    const double ear_s = head.delay_s(head.angle_rad(channel, source_m));
    return ear_s + (propagation_delay ? (source_m - head.centre_m).norm() / sound_speed_m_s : 0.0);
  }
  if (!stereo() && !propagation_delay) return 0.0;
  const double to_ear_m = (source_m - ear_m(channel, time_s)).norm();
  return (propagation_delay ? to_ear_m : to_ear_m - (source_m - centre_m(time_s)).norm()) / sound_speed_m_s;
}

double Listener::lead_s(double sound_speed_m_s) const {
  if (has_head_) return head_.lead_s();
  if (!stereo() || propagation_delay) return 0.0;
  return 0.5 * (left_m_ - right_m_).colwise().norm().maxCoeff() / sound_speed_m_s;
}

Eigen::Vector3d half_ears(const Eigen::Vector3d& nose, double ears_m) {
  Eigen::Vector3d right = nose.normalized().cross(Eigen::Vector3d::UnitZ());
  if (!(right.norm() > 1e-6)) right = Eigen::Vector3d::UnitX();
  return 0.5 * ears_m * right.normalized();
}

double checked_ears(double ears_m) {
  const Range range = between(0.001, 10.0);
  if (!range.holds(ears_m)) throw_violations({}, {out_of_range("ears_m", ears_m, range)});
  return ears_m;
}

Listener listener_at(const Eigen::Vector3d& x_m, std::optional<double> ears_m, const Eigen::Vector3d& faces) {
  if (!ears_m) return Listener::ears({0.0}, x_m);
  const Eigen::Vector3d half = half_ears(faces - x_m, checked_ears(*ears_m));
  return Listener::ears({0.0}, x_m - half, x_m + half);
}

}  // namespace klang::stage
