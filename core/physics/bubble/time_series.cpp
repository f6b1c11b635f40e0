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

}  // namespace

TimeSeries read_time_series(const std::filesystem::path& path, std::span<const std::string_view> needed,
                            std::span<const std::string_view> optional, bool even) {
  CsvFile lines(path);
  const std::string& file = lines.name();
  std::vector<std::string_view> names = {"time_s"};
  names.insert(names.end(), needed.begin(), needed.end());
  names.insert(names.end(), optional.begin(), optional.end());
  std::string known;
  for (const std::string_view name : names) known.append(known.empty() ? "" : ", ").append(name);
  std::vector<std::size_t> target;  // of each cell in a line
  std::vector<std::vector<double>> columns(names.size());
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
    if (times.size() > 1 && !(times.back() > times[times.size() - 2]))
      throw InputError(place, "time_s does not rise", to_text(times.back()),
                       "above " + to_text(times[times.size() - 2]));
    if (times.size() > kMaxRows) throw InputError(file, "has too many rows", "", std::to_string(kMaxRows));
  }
  if (columns[0].empty()) throw InputError(file, "has no rows");
  if (even) check_even(columns[0], file);
  TimeSeries series{std::move(columns[0]), {}};
  for (std::size_t i = 1; i < columns.size(); ++i) series.columns.push_back(std::move(columns[i]));
  return series;
}

std::complex<double> TransferSeries::at(double time_s) const {
  const auto next = std::lower_bound(times_s.begin(), times_s.end(), time_s);
  if (next == times_s.begin()) return pressure_pa_per_m.front();
  if (next == times_s.end()) return pressure_pa_per_m.back();
  const auto i = static_cast<std::size_t>(next - times_s.begin());
  const double part = (time_s - times_s[i - 1]) / (times_s[i] - times_s[i - 1]);
  return pressure_pa_per_m[i - 1] + part * (pressure_pa_per_m[i] - pressure_pa_per_m[i - 1]);
}

TransferSeries read_transfer_series(const std::filesystem::path& path) {
  TransferSeries result;
  if (path.extension() != ".json") {
    constexpr std::string_view kColumns[] = {"re", "im"};
    TimeSeries series = read_time_series(path, kColumns, {}, false);
    result.times_s = std::move(series.times_s);
    for (std::size_t i = 0; i < result.times_s.size(); ++i)
      result.pressure_pa_per_m.emplace_back(series.columns[0][i], series.columns[1][i]);
    return result;
  }
  const std::string file = path.string();
  const auto json = parse_json(read_file(path), file);
  const auto list = json.is_object() ? json.find("transfer") : json.end();
  if (!json.is_object() || list == json.end() || !list->is_array() || list->empty())
    throw InputError(file, "has no list \"transfer\" of {time_s, re, im}");
  for (const auto& row : *list) {
    const std::string place = file + ", transfer[" + std::to_string(result.times_s.size()) + "]";
    double values[3];
    constexpr const char* kKeys[] = {"time_s", "re", "im"};
    for (int i = 0; i < 3; ++i) {
      const bool present = row.is_object() && row.contains(kKeys[i]) && row[kKeys[i]].is_number();
      if (!present) throw InputError(place, "has no number", kKeys[i]);
      values[i] = row[kKeys[i]].get<double>();
      if (!std::isfinite(values[i])) throw InputError(place, "is not finite", kKeys[i]);
    }
    if (!result.times_s.empty() && !(values[0] > result.times_s.back()))
      throw InputError(place, "time_s does not rise", to_text(values[0]), "above " + to_text(result.times_s.back()));
    result.times_s.push_back(values[0]);
    result.pressure_pa_per_m.emplace_back(values[1], values[2]);
  }
  return result;
}

}  // namespace klang::bubble
