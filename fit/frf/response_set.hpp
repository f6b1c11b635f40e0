#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/conventions.hpp"

/// Measured responses of a body at several places: frequency response functions, or free decays.
namespace klang::fit {

/// Where a response was measured and along which axis of its file: direction 1, 2, 3 for +x, +y, +z, negative for the other way,
/// 0 where the file does not say.
struct ResponsePoint {
  int node = 0, direction = 0;
};

struct ResponseSet {
  std::string origin;
  bool in_time = false;      ///< free decays, else FRFs
  Eigen::VectorXd abscissa;  ///< frequency_hz or time_s, rising
  Eigen::MatrixXcd values;   ///< responses x lines; free decays are real
  std::vector<ResponsePoint> points;
  std::map<int, Eigen::Vector3d> nodes_m;  ///< those that the file places
  int derivative = 2;                      ///< of the displacement: 0 receptance, 1 mobility, 2 accelerance
  std::string unit;                        ///< "m/s^2/N" of FRFs, "m/s^2" of decays; the scale is the file's
  std::vector<std::string> warnings;

  Eigen::Index n_responses() const { return values.rows(); }
  Eigen::Index n_lines() const { return values.cols(); }
};

/// Whether a path is read here: .uff, .unv, .uf58 or .mat.
bool is_response_file(const std::filesystem::path& path);

/// Universal files: dataset 58 (text, or 58b with IEEE numbers of either byte order) with FRFs (function type 4) or time responses
/// (type 1); places by datasets 15 or 2411, their unit of length by 164. MATLAB (libmatio): `frequency_hz` with `frf` (responses x
/// lines, complex), or `time_s` with `response`; `unit` ("m/s^2/N", "m/s/N", "m/N"; "m/s^2" ...); optional `node`, `direction` (1 to 3
/// with sign) and `points_m` (responses x 3).
/// @throws InputError: missing, damaged, no such data, kinds mixed, lines that differ between responses or do not rise, numbers that are
///         not finite, fewer than 16 lines
ResponseSet read_responses(const std::filesystem::path& path);
ResponseSet read_universal_bytes(std::string_view bytes, const std::string& name);

/// Derivative of the displacement that a unit means. @throws InputError: a unit of another quantity
int derivative_of_unit(const std::string& unit, const std::string& place);

/// From the first line to the last; of free decays from two periods within them up to half their sample rate.
Band whole_band(const ResponseSet& set);

/// What every reader holds its result against. @throws InputError as read_responses
void validate(const ResponseSet& set);

}  // namespace klang::fit
