#include "core/sound/stage/listener_path.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/math/sphere_quadrature.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {
namespace {

constexpr std::size_t kMostRows = 1000000;
constexpr double kFarthest = 1e5;
enum class Columns { kOneEar, kRightEar, kFacing };

Columns columns_of(const std::vector<std::string_view>& names, const std::string& place) {
  const std::vector<std::string_view> one = {"time_s", "x_m", "y_m", "z_m"};
  std::vector<std::string_view> right = one, facing = one;
  right.insert(right.end(), {"right_x_m", "right_y_m", "right_z_m"});
  facing.insert(facing.end(), {"facing_x", "facing_y", "facing_z"});
  if (names == one) return Columns::kOneEar;
  if (names == right) return Columns::kRightEar;
  if (names == facing) return Columns::kFacing;
  throw InputError(place, "has unknown columns", {},
                   "time_s,x_m,y_m,z_m and nothing, right_x_m,right_y_m,right_z_m or facing_x,facing_y,facing_z");
}

// Half the vector from the left ear to the right one: nose x up, up being z (x where the nose points up or down).
Eigen::Vector3d half_ears(const Eigen::Vector3d& nose, double ears_m) {
  Eigen::Vector3d right = nose.normalized().cross(Eigen::Vector3d::UnitZ());
  if (!(right.norm() > 1e-6)) right = Eigen::Vector3d::UnitX();
  return 0.5 * ears_m * right.normalized();
}

Eigen::Vector3d along(const ListenerPath& path, const Eigen::Matrix3Xd& points, double t) {
  const Eigen::Index n = path.time_s.size();
  const double* const begin = path.time_s.data();
  const auto after = static_cast<Eigen::Index>(std::upper_bound(begin, begin + n, t) - begin);
  if (after == 0) return points.col(0);
  if (after == n) return points.col(n - 1);
  const double share = (t - path.time_s[after - 1]) / (path.time_s[after] - path.time_s[after - 1]);
  return points.col(after - 1) + share * (points.col(after) - points.col(after - 1));
}

}  // namespace

Eigen::Vector3d ListenerPath::ear_m(int ear, double time_at_s) const {
  return along(*this, ear == 0 ? left_m : right_m, time_at_s);
}

Eigen::Vector3d ListenerPath::head_m(double time_at_s) const {
  return stereo() ? Eigen::Vector3d(0.5 * (ear_m(0, time_at_s) + ear_m(1, time_at_s))) : ear_m(0, time_at_s);
}

ListenerPath read_listener_path(const std::filesystem::path& path, std::optional<double> ears_m,
                                const Eigen::Vector3d& faces) {
  CsvFile file(path, std::size_t{1} << 28);
  if (ears_m) checked("command line", "--ears-m", *ears_m, 0.001, 10.0);
  std::optional<Columns> columns;
  std::vector<std::vector<double>> rows;
  while (file.next()) {
    const auto& cells = file.cells();
    const std::string place = path.string() + ":" + std::to_string(file.line_number());
    if (!columns) {
      if (!csv_number(cells[0])) {
        columns = columns_of(cells, place);
        continue;
      }
      if (cells.size() != 4 && cells.size() != 7) {
        throw InputError(place, "has the wrong number of columns", std::to_string(cells.size()), "4 or 7");
      }
      columns = cells.size() == 4 ? Columns::kOneEar : Columns::kRightEar;
    }
    const std::size_t expected = *columns == Columns::kOneEar ? 4 : 7;
    if (cells.size() != expected) {
      throw InputError(place, "has the wrong number of columns", std::to_string(cells.size()),
                       std::to_string(expected));
    }
    std::vector<double> values(expected);
    for (std::size_t i = 0; i < expected; ++i) {
      values[i] = csv_number(cells[i], place);
      if (!(std::abs(values[i]) <= kFarthest))
        throw InputError(place, "is out of range", std::string(cells[i]), "-1e5 to 1e5");
    }
    if (!rows.empty() && !(values[0] > rows.back()[0])) {
      throw InputError(place, "time_s does not rise", to_text(values[0]), "more than " + to_text(rows.back()[0]));
    }
    rows.push_back(std::move(values));
    if (rows.size() > kMostRows) throw InputError(path.string(), "has too many rows", {}, "1000000");
  }
  if (rows.empty()) throw InputError(path.string(), "has no position", {}, "a line time_s,x_m,y_m,z_m");
  if (*columns == Columns::kFacing && !ears_m)
    throw InputError(path.string(), "has facing columns, which need --ears-m");
  if (*columns == Columns::kRightEar && ears_m)
    throw InputError(path.string(), "has a right ear, so --ears-m has no meaning");

  ListenerPath result;
  const auto n = static_cast<Eigen::Index>(rows.size());
  result.time_s.resize(n);
  result.left_m.resize(3, n);
  if (*columns == Columns::kRightEar || ears_m) result.right_m.resize(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<double>& v = rows[static_cast<std::size_t>(i)];
    const Eigen::Vector3d x(v[1], v[2], v[3]);
    result.time_s[i] = v[0];
    result.left_m.col(i) = x;
    if (*columns == Columns::kRightEar) {
      result.right_m.col(i) << v[4], v[5], v[6];
    } else if (ears_m) {
      const Eigen::Vector3d nose =
          *columns == Columns::kFacing ? Eigen::Vector3d(v[4], v[5], v[6]) : Eigen::Vector3d(faces - x);
      if (!(nose.norm() > 0.0))
        throw InputError(path.string(), "a facing direction is 0", "row " + std::to_string(i + 1));
      const Eigen::Vector3d half = half_ears(nose, *ears_m);
      result.left_m.col(i) = x - half;
      result.right_m.col(i) = x + half;
    }
  }
  return result;
}

ListenerPath listener_at(const Eigen::Vector3d& x_m, std::optional<double> ears_m, const Eigen::Vector3d& faces) {
  ListenerPath path;
  path.time_s = Eigen::VectorXd::Zero(1);
  path.left_m = x_m;
  if (ears_m) {
    const Eigen::Vector3d half = half_ears(faces - x_m, checked("command line", "--ears-m", *ears_m, 0.001, 10.0));
    path.left_m = x_m - half;
    path.right_m = x_m + half;
  }
  return path;
}

Eigen::Vector3d default_listener_m(const TransferModel& model, double distance_m) {
  const ModeTransfer* strongest = nullptr;
  for (const ModeTransfer& mode : model.modes) {
    if (mode.radiated_power_w > (strongest == nullptr ? 0.0 : strongest->radiated_power_w)) strongest = &mode;
  }
  if (strongest == nullptr) {
    const Eigen::Vector3d centre =
        model.modes.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : model.modes[0].multipole.centre_m;
    return centre + distance_m * Eigen::Vector3d::UnitZ();
  }
  const Eigen::Matrix3Xd directions = sphere_quadrature(4 * strongest->multipole.order + 8).directions;
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double loudest =
      1.000001 * std::abs(far_field_pa_m(strongest->multipole, best));  // z unless another is really louder
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    const double level = std::abs(far_field_pa_m(strongest->multipole, directions.col(i)));
    if (level > loudest * 1.000001) {
      loudest = level;
      best = directions.col(i);
    }
  }
  return strongest->multipole.centre_m + distance_m * best;
}

}  // namespace klang::acoustics
