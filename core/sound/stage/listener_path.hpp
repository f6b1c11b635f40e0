#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "core/sound/transfer/transfer_model.hpp"

namespace klang::acoustics {

/// Where the ears are, at rising times; straight lines between, at rest before the first and after the last.
struct ListenerPath {
  Eigen::VectorXd time_s;   ///< n_rows >= 1
  Eigen::Matrix3Xd left_m;  ///< n_rows; the only ear where right_m is empty
  Eigen::Matrix3Xd right_m;

  bool stereo() const { return right_m.cols() > 0; }
  bool moves() const { return time_s.size() > 1; }
  /// Position of an ear (0 left, 1 right) at a time.
  Eigen::Vector3d ear_m(int ear, double time_at_s) const;
  /// Middle of the ears.
  Eigen::Vector3d head_m(double time_at_s) const;
};

/// Reads a CSV with the columns time_s,x_m,y_m,z_m and, optionally, three more: right_x_m,right_y_m,right_z_m (the first
/// three are then the left ear) or facing_x,facing_y,facing_z (direction of the nose, any length but 0). The line of names may
/// be left out for 4 columns and for the right ear. Lines that are empty or begin with # do not count.
/// ears_m: distance of two ears either side of the position, along facing x z; without facing columns the listener faces
/// `faces`. Must be given with facing columns, and not with a right ear.
/// @throws InputError with file and line: not a number, times that do not rise, wrong number of columns, more than 10^6 rows
ListenerPath read_listener_path(const std::filesystem::path& path, std::optional<double> ears_m,
                                const Eigen::Vector3d& faces);

/// A listener at rest at x_m; two ears facing `faces` where ears_m is given.
ListenerPath listener_at(const Eigen::Vector3d& x_m, std::optional<double> ears_m, const Eigen::Vector3d& faces);

/// distance_m from the centre of the mode that radiates most power, where its far field is strongest; along z where no mode
/// radiates.
Eigen::Vector3d default_listener_m(const TransferModel& model, double distance_m);

}  // namespace klang::acoustics
