#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "core/sound/stage/listener.hpp"

namespace klang::stage {

/// Reads a CSV with the columns time_s,x_m,y_m,z_m and, optionally, three more: right_x_m,right_y_m,right_z_m (the
/// first three are then the left ear) or facing_x,facing_y,facing_z (direction of the nose, any length but 0). The line
/// of names may be left out for 4 columns and for the right ear. Lines that are empty or begin with # do not count.
/// ears_m: distance of two ears either side of the position, along facing x z; without facing columns the listener
/// faces `faces`. Must be given with facing columns, and not with a right ear.
/// @throws InputError with file and line: not a number, times that do not rise, wrong number of columns, more than 10^6
///         rows
Listener read_listener(const std::filesystem::path& path, std::optional<double> ears_m, const Eigen::Vector3d& faces);

}  // namespace klang::stage
