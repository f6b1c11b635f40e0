#include "core/physics/bubble/time_series.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/csv.hpp"

namespace klang::bubble {
namespace {

constexpr std::size_t kMaxRows = 10'000'000;
constexpr std::string_view kFrequency = "frequency_hz";
constexpr double kLargestStep = 1.5;  // of the middle one; one missing frame makes 2

void check_even(const std::vector<double>& times_s, const std::string& file) {
  if (times_s.size() < 4) return;
  std::vector<double> steps;
  for (std::size_t i = 1; i < times_s.size(); ++i) steps.push_back(times_s[i] - times_s[i - 1]);
  std::vector<double> sorted = steps;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double middle = sorted[sorted.size() / 2];
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] <= kLargestStep * middle) continue;
    throw InputError(file, "misses frames between " + to_text(times_s[i]) + " s and " + to_text(times_s[i + 1]) + " s",
                     "step " + to_text(steps[i]) + " s", "up to " + to_text(kLargestStep * middle) + " s");
  }
}

/// The columns of a file, time_s first. Times must rise, but not those of a table over time and frequency.
std::vector<std::vector<double>> read_columns(const std::filesystem::path& path,
                                              std::span<const std::string_view> needed,
                                              std::span<const std::string_view> optional) {
  CsvFile lines(path);
  const std::string& file = lines.name();
  std::vector<std::string_view> names = {"time_s"};
  names.insert(names.end(), needed.begin(), needed.end());
  names.insert(names.end(), optional.begin(), optional.end());
  std::string known;
  for (const std::string_view name : names) known.append(known.empty() ? "" : ", ").append(name);
  std::vector<std::size_t> target;  // of each cell in a line
  std::vector<std::vector<double>> columns(names.size());
  bool rising = true;
  while (lines.next()) {
    const std::string place = lines.place();
    const auto& cells = lines.cells();
    if (target.empty()) {
      for (const std::string_view cell : cells) {
        const auto found = std::find(names.begin(), names.end(), cell);
        const auto index = static_cast<std::size_t>(found - names.begin());
        if (found == names.end()) throw InputError(place, "unknown column", cell.substr(0, 40), known);
        if (std::find(target.begin(), target.end(), index) != target.end())
          throw InputError(place, "names a column twice", cell);
        target.push_back(index);
        if (cell == kFrequency) rising = false;
      }
      for (std::size_t i = 0; i <= needed.size(); ++i) {
        if (std::find(target.begin(), target.end(), i) == target.end())
          throw InputError(place, "misses the column", names[i], known);
      }
      continue;
    }
    if (cells.size() != target.size())
      throw InputError(place, "has a wrong number of columns", std::to_string(cells.size()),
                       std::to_string(target.size()));
    for (std::size_t i = 0; i < cells.size(); ++i) columns[target[i]].push_back(csv_number(cells[i], place));
    const auto& times = columns[0];
    if (rising && times.size() > 1 && !(times.back() > times[times.size() - 2]))
      throw InputError(place, "time_s does not rise", to_text(times.back()),
                       "above " + to_text(times[times.size() - 2]));
    if (times.size() > kMaxRows) throw InputError(file, "has too many rows", "", std::to_string(kMaxRows));
  }
  if (columns[0].empty()) throw InputError(file, "has no rows");
  return columns;
}

}  // namespace

TimeSeries read_time_series(const std::filesystem::path& path, std::span<const std::string_view> needed,
                            std::span<const std::string_view> optional, bool even) {
  std::vector<std::vector<double>> columns = read_columns(path, needed, optional);
  if (even) check_even(columns[0], path.string());
  TimeSeries series{std::move(columns[0]), {}};
  for (std::size_t i = 1; i < columns.size(); ++i) series.columns.push_back(std::move(columns[i]));
  return series;
}

TransferSeries::TransferSeries(std::vector<Row> rows, const std::string& name) : rows_(std::move(rows)) {
  if (rows_.empty()) throw InputError(name, "has no rows");
  const bool known = std::any_of(rows_.begin(), rows_.end(), [](const Row& row) { return row.frequency_hz != 0.0; });
  for (const Row& row : rows_) {
    const std::string at = name + ", at " + to_text(row.time_s) + " s";
    if (!std::isfinite(row.time_s) || !std::isfinite(row.pressure_pa_per_m.real()) ||
        !std::isfinite(row.pressure_pa_per_m.imag()))
      throw InputError(at, "is not finite");
    if (known) checked(at, "frequency_hz", row.frequency_hz, 1.0, 1e6);
  }
  std::stable_sort(rows_.begin(), rows_.end(), [](const Row& a, const Row& b) {
    return a.time_s != b.time_s ? a.time_s < b.time_s : a.frequency_hz < b.frequency_hz;
  });
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const bool same_time = i > 0 && rows_[i].time_s == rows_[i - 1].time_s;
    if (same_time && rows_[i].frequency_hz == rows_[i - 1].frequency_hz)
      throw InputError(
          name, "says a time twice",
          to_text(rows_[i].time_s) + " s" + (known ? " at " + to_text(rows_[i].frequency_hz) + " Hz" : ""));
    if (same_time) continue;
    times_s_.push_back(rows_[i].time_s);
    first_row_.push_back(i);
  }
  first_row_.push_back(rows_.size());
}

std::complex<double> TransferSeries::at_time(std::size_t time, double frequency_hz) const {
  const auto begin = rows_.begin() + static_cast<std::ptrdiff_t>(first_row_[time]),
             end = rows_.begin() + static_cast<std::ptrdiff_t>(first_row_[time + 1]);
  const auto reduced = [&](const Row& row) {
    return has_frequency() ? row.pressure_pa_per_m / (row.frequency_hz * row.frequency_hz) : row.pressure_pa_per_m;
  };
  const auto next = std::lower_bound(begin, end, frequency_hz,
                                     [](const Row& row, double frequency) { return row.frequency_hz < frequency; });
  if (next == begin) return reduced(*begin);
  if (next == end) return reduced(*(end - 1));
  const Row &low = *(next - 1), &high = *next;
  const std::complex<double> a = reduced(low), b = reduced(high);
  const double share = std::log(frequency_hz / low.frequency_hz) / std::log(high.frequency_hz / low.frequency_hz);
  if (a == 0.0 || b == 0.0) return a + share * (b - a);
  const double turn = std::arg(b / a),
               along = (frequency_hz - low.frequency_hz) / (high.frequency_hz - low.frequency_hz);
  return a * std::polar(std::pow(std::abs(b) / std::abs(a), share), along * turn);
}

std::complex<double> TransferSeries::at(double time_s, double frequency_hz) const {
  const double scale = has_frequency() ? frequency_hz * frequency_hz : 1.0;
  const auto next = std::lower_bound(times_s_.begin(), times_s_.end(), time_s);
  if (next == times_s_.begin()) return scale * at_time(0, frequency_hz);
  const auto i = static_cast<std::size_t>(next - times_s_.begin());
  if (next == times_s_.end()) return scale * at_time(i - 1, frequency_hz);
  const double part = (time_s - times_s_[i - 1]) / (times_s_[i] - times_s_[i - 1]);
  const std::complex<double> before = at_time(i - 1, frequency_hz);
  return scale * (before + part * (at_time(i, frequency_hz) - before));
}

namespace {

/// The numbers of one entry of JSON's list; frequency_hz where neither it nor the file's options say one: 0.
TransferSeries::Row json_row(const nlohmann::json& row, double frequency_hz, const std::string& place) {
  double values[4] = {0.0, 0.0, 0.0, frequency_hz};
  constexpr const char* kKeys[] = {"time_s", "re", "im", "frequency_hz"};
  for (int i = 0; i < 4; ++i) {
    const bool present = row.is_object() && row.contains(kKeys[i]);
    if (i == 3 && !present) break;
    if (!present || !row[kKeys[i]].is_number()) throw InputError(place, "has no number", kKeys[i]);
    values[i] = row[kKeys[i]].get<double>();
    if (!std::isfinite(values[i])) throw InputError(place, "is not finite", kKeys[i]);
  }
  return {values[0], values[3], {values[1], values[2]}};
}

}  // namespace

TransferSeries read_transfer_series(const std::filesystem::path& path) {
  const std::string file = path.string();
  std::vector<TransferSeries::Row> rows;
  if (path.extension() != ".json") {
    constexpr std::string_view kColumns[] = {"re", "im"}, kOptional[] = {kFrequency};
    const std::vector<std::vector<double>> columns = read_columns(path, kColumns, kOptional);
    const bool known = !columns[3].empty();
    for (std::size_t i = 0; i < columns[0].size(); ++i)
      rows.push_back({columns[0][i], known ? columns[3][i] : 0.0, {columns[1][i], columns[2][i]}});
    return TransferSeries(std::move(rows), file);
  }
  const auto json = parse_json(read_file(path), file);
  const auto list = json.is_object() ? json.find("transfer") : json.end();
  if (!json.is_object() || list == json.end() || !list->is_array() || list->empty())
    throw InputError(file, "has no list \"transfer\" of {time_s, re, im}");
  const nlohmann::json provenance = json.value("provenance", nlohmann::json::object());
  const nlohmann::json options =
      provenance.is_object() ? provenance.value("options", nlohmann::json()) : nlohmann::json();
  const bool given = options.is_object() && options.contains("frequency_hz") && options["frequency_hz"].is_number();
  const double frequency_hz = given ? options["frequency_hz"].get<double>() : 0.0;
  for (const auto& row : *list)
    rows.push_back(json_row(row, frequency_hz, file + ", transfer[" + std::to_string(rows.size()) + "]"));
  return TransferSeries(std::move(rows), file);
}

}  // namespace klang::bubble
