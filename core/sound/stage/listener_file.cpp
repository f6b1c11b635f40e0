#include "core/sound/stage/listener_file.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::stage {
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

struct Rows {
  Columns columns = Columns::kOneEar;
  std::vector<std::vector<double>> values;
};

Rows rows_of(CsvFile& file, const std::filesystem::path& path) {
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
  return {*columns, std::move(rows)};
}

}  // namespace

Listener read_listener(const std::filesystem::path& path, std::optional<double> ears_m, const Eigen::Vector3d& faces) {
  CsvFile file(path, std::size_t{1} << 28);
  if (ears_m) checked_ears(*ears_m);
  const auto [columns, rows] = rows_of(file, path);
  if (columns == Columns::kFacing && !ears_m)
    throw option_error("ears_m", "is missing", {}, "the ears' distance, for the facing columns of " + path.string());
  if (columns == Columns::kRightEar && ears_m)
    throw option_error("ears_m", "has no meaning: " + path.string() + " has a right ear");

  const auto n = static_cast<Eigen::Index>(rows.size());
  std::vector<double> times_s;
  Eigen::Matrix3Xd left_m(3, n), right_m(3, columns == Columns::kRightEar || ears_m ? n : 0);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::vector<double>& v = rows[static_cast<std::size_t>(i)];
    const Eigen::Vector3d x(v[1], v[2], v[3]);
    times_s.push_back(v[0]);
    left_m.col(i) = x;
    if (columns == Columns::kRightEar) {
      right_m.col(i) << v[4], v[5], v[6];
    } else if (ears_m) {
      const Eigen::Vector3d nose =
          columns == Columns::kFacing ? Eigen::Vector3d(v[4], v[5], v[6]) : Eigen::Vector3d(faces - x);
      if (!(nose.norm() > 0.0))
        throw InputError(path.string(), "a facing direction is 0", "row " + std::to_string(i + 1));
      const Eigen::Vector3d half = half_ears(nose, *ears_m);
      left_m.col(i) = x - half;
      right_m.col(i) = x + half;
    }
  }
  return Listener::ears(std::move(times_s), std::move(left_m), std::move(right_m));
}

}  // namespace klang::stage
