#include "core/physics/fracture/dynamic/hold_path.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"

namespace klang::fracture {

using Eigen::Vector3d;

HoldPath::HoldPath(HoldKind kind, std::vector<Row> rows, const std::string& place)
    : kind_(kind), rows_(std::move(rows)) {
  if (rows_.empty()) throw InputError(place, "has no rows", "", "time_s, x, y, z");
  if (kind_ == HoldKind::kAcceleration && rows_.front().time_s > 0.0)
    throw InputError(place, "begins late", to_text(rows_.front().time_s), "accelerations from time 0 on");
  integral_.push_back(Vector3d::Zero());
  double_integral_.push_back(Vector3d::Zero());
  for (std::size_t i = 1; i < rows_.size(); ++i) {
    const double dt = rows_[i].time_s - rows_[i - 1].time_s;
    if (!(dt > 0.0)) throw InputError(place, "has times that do not rise", to_text(rows_[i].time_s));
    const Vector3d a = rows_[i - 1].value, b = rows_[i].value;
    double_integral_.push_back(double_integral_.back() + integral_.back() * dt + (2.0 * a + b) * dt * dt / 6.0);
    integral_.push_back(integral_.back() + 0.5 * (a + b) * dt);
  }
}

bool HoldPath::is_still() const {
  return start_velocity_.isZero(0.0) &&
         std::all_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.value.isZero(0.0); });
}

std::size_t HoldPath::row_before(double time_s) const {
  const auto after =
      std::upper_bound(rows_.begin(), rows_.end(), time_s, [](double t, const Row& row) { return t < row.time_s; });
  return after == rows_.begin() ? 0 : static_cast<std::size_t>(after - rows_.begin()) - 1;
}

namespace {

/// Value, integral and double integral since the row, of a line between rows.
struct Local {
  Vector3d value, slope;
  double t = 0.0;
};

Local local(const std::vector<HoldPath::Row>& rows, std::size_t i, double time_s) {
  Local l{rows[i].value, Vector3d::Zero(), time_s - rows[i].time_s};
  if (i + 1 < rows.size() && l.t >= 0.0)
    l.slope = (rows[i + 1].value - rows[i].value) / (rows[i + 1].time_s - rows[i].time_s);
  return l;
}

}  // namespace

Vector3d HoldPath::acceleration_m_s2(double time_s) const {
  if (rows_.empty() || kind_ == HoldKind::kPosition) return Vector3d::Zero();
  const Local l = local(rows_, row_before(time_s), time_s);
  return kind_ == HoldKind::kVelocity ? l.slope : Vector3d(l.value + l.slope * l.t);
}

Vector3d HoldPath::velocity_m_s(double time_s) const {
  if (rows_.empty()) return Vector3d::Zero();
  const std::size_t i = row_before(time_s);
  const Local l = local(rows_, i, time_s);
  if (kind_ == HoldKind::kPosition) return l.slope;
  if (kind_ == HoldKind::kVelocity) return l.value + l.slope * l.t;
  const auto integral = [&](std::size_t row, const Local& at) -> Vector3d {
    return integral_[row] + at.value * at.t + 0.5 * at.slope * at.t * at.t;
  };
  const std::size_t zero = row_before(0.0);
  return start_velocity_ + integral(i, l) - integral(zero, local(rows_, zero, 0.0));
}

Vector3d HoldPath::displacement_m(double time_s) const {
  if (rows_.empty()) return Vector3d::Zero();
  const std::size_t i = row_before(time_s), zero = row_before(0.0);
  const Local l = local(rows_, i, time_s), l0 = local(rows_, zero, 0.0);
  if (kind_ == HoldKind::kPosition) return l.value + l.slope * l.t;
  const auto once = [&](std::size_t row, const Local& at) -> Vector3d {
    return integral_[row] + at.value * at.t + 0.5 * at.slope * at.t * at.t;
  };
  if (kind_ == HoldKind::kVelocity) return once(i, l) - once(zero, l0);
  const auto twice = [&](std::size_t row, const Local& at) -> Vector3d {
    return double_integral_[row] + integral_[row] * at.t + 0.5 * at.value * at.t * at.t +
           at.slope * at.t * at.t * at.t / 6.0;
  };
  return start_velocity_ * time_s + twice(i, l) - twice(zero, l0) - once(zero, l0) * time_s;
}

std::vector<HoldPath::Row> read_hold_rows(const std::filesystem::path& csv) {
  CsvFile file(csv);
  if (!file.next()) throw InputError(csv.string(), "is empty", "", "a head line time_s,x,y,z and rows");
  std::array<std::size_t, 4> columns{};
  const std::array<const char*, 4> names = {"time_s", "x", "y", "z"};
  for (std::size_t i = 0; i < 4; ++i) {
    const auto found = std::find(file.cells().begin(), file.cells().end(), names[i]);
    if (found == file.cells().end()) throw InputError(file.place(), "lacks a column", names[i], "time_s, x, y, z");
    columns[i] = static_cast<std::size_t>(found - file.cells().begin());
  }
  const std::size_t n_columns = file.cells().size();
  std::vector<HoldPath::Row> rows;
  while (file.next()) {
    if (file.cells().size() != n_columns)
      throw InputError(file.place(), "has another number of cells than the head", std::to_string(file.cells().size()),
                       std::to_string(n_columns));
    HoldPath::Row row;
    row.time_s = csv_number(file.cells()[columns[0]], file.place());
    for (int axis = 0; axis < 3; ++axis)
      row.value[axis] = csv_number(file.cells()[columns[static_cast<std::size_t>(axis) + 1]], file.place());
    if (!(row.value.norm() <= 1e9) || !(std::abs(row.time_s) <= 1e6))
      throw InputError(file.place(), "is too large", "", "values within 1e9, times within 1e6");
    if (!rows.empty() && !(row.time_s > rows.back().time_s))
      throw InputError(file.place(), "time_s does not rise", to_text(row.time_s),
                       "above " + to_text(rows.back().time_s));
    rows.push_back(row);
  }
  if (rows.empty()) throw InputError(csv.string(), "has no rows", "", "time_s, x, y, z");
  return rows;
}

}  // namespace klang::fracture
