#pragma once
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <vector>

#include "core/sound/stage/spherical_head.hpp"

namespace klang::stage {

/// The one listener of the house: where sound is heard and with what ears. Straight lines between its times, at rest
/// before the first and after the last.
class Listener {
 public:
  /// Channels without a place, such as pickups on a body: for voices that need no transfer.
  static Listener without_place(int n_channels = 1);
  /// One ear, or two (right_m as many columns as left_m), that do not shade the sound.
  /// @param times_s  rising, n >= 1;  @param left_m, right_m  3 x n
  static Listener ears(std::vector<double> times_s, Eigen::Matrix3Xd left_m, Eigen::Matrix3Xd right_m = {});
  /// A head that walks and turns.
  /// @param centres_m  3 x n;  @param facings  3 x n, or empty: the nose keeps the direction of head
  /// @param head       its radius, ears and sound speed count
  static Listener head(std::vector<double> times_s, Eigen::Matrix3Xd centres_m, Eigen::Matrix3Xd facings,
                       const SphericalHead& head);
  void validate() const;  ///< InputError

  bool propagation_delay = false;  ///< sound arrives distance / c later, which gives the Doppler shift

  int n_channels() const { return n_channels_; }
  bool stereo() const { return n_channels_ == 2; }
  bool has_place() const { return !times_s_.empty(); }
  bool has_head() const { return has_head_; }
  bool moves() const { return times_s_.size() > 1; }

  /// Where the pressure of a channel is taken: at its ear, or at the centre of the head that shades it.
  Eigen::Vector3d ear_m(int channel, double time_s) const;
  /// The middle of the ears, or of the head.
  Eigen::Vector3d centre_m(double time_s) const;
  SphericalHead head_at(double time_s) const;  ///< with has_head()

  /// What the head makes of a wave from source_m on its way to an ear, arrival time apart: 1 without a head.
  std::complex<double> shadow(int channel, double time_s, const Eigen::Vector3d& source_m, double omega_rad_s) const;
  /// Time from a source to an ear, heard at time_s. Without propagation_delay it is counted against the centre, so that
  /// it may be negative, and 0 for a single ear.
  double way_s(int channel, double time_s, const Eigen::Vector3d& source_m, double sound_speed_m_s) const;
  /// No way is shorter than -lead_s().
  double lead_s(double sound_speed_m_s) const;

 private:
  Eigen::Vector3d along(const Eigen::Matrix3Xd& points, double time_s) const;

  int n_channels_ = 1;
  bool has_head_ = false;
  std::vector<double> times_s_;
  Eigen::Matrix3Xd left_m_, right_m_;  // left_m_: the centre of a head
  Eigen::Matrix3Xd facings_;
  SphericalHead head_;
};

/// A listener at rest at x_m; two ears facing `faces` where ears_m, their distance, is given.
Listener listener_at(const Eigen::Vector3d& x_m, std::optional<double> ears_m, const Eigen::Vector3d& faces);

/// The ears' distance where it is within 0.001 to 10 m. @throws OptionsError, field "ears_m"
double checked_ears(double ears_m);

/// Half the vector from the left ear to the right one: nose x up, up being z (x where the nose points up or down).
Eigen::Vector3d half_ears(const Eigen::Vector3d& nose, double ears_m);

}  // namespace klang::stage
