#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "fit/iet/iet.hpp"

namespace klang::fit {
namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20, kMostSpecimens = 10000;

bool is_needed(std::string_view column, bool required, IetRecordings recordings) {
  return required && (column != "recording" || recordings == IetRecordings::kNeeded);
}

/// Fills the members of a specimen from the cells of its line.
class CellReader {
 public:
  CellReader(const std::map<std::string, std::string>& cells, std::string place, IetRecordings recordings)
      : cells_(cells), place_(std::move(place)), recordings_(recordings) {}

  void operator()(const Field& field, std::string& value) {
    value = cell(field);
    if (is_needed(field.name, field.required, recordings_) && value.empty())
      throw InputError(place_, std::string(field.name) + " is empty");
  }
  void operator()(const Field& field, double& value) {
    const std::string text = cell(field);
    value = csv_number(text, place_ + ", " + std::string(field.name), field.range.text());
    if (!field.range.holds(value))
      throw InputError(place_, std::string(field.name) + " is out of range", text, field.range.text());
  }
  void operator()(const Field& field, std::optional<double>& value) {
    if (cell(field).empty()) return;
    value.emplace();
    (*this)(field, *value);
  }
  void operator()(const Field& field, IetShape& value) {
    const std::string word = cell(field);
    const auto found = enum_from_text<IetShape>(word);
    if (!found) throw unknown_word(place_, "shape is none", word, word, {"bar", "rod", "disc"});
    value = *found;
  }

 private:
  std::string cell(const Field& field) const {
    const auto found = cells_.find(std::string(field.name));
    return found == cells_.end() ? std::string() : found->second;
  }
  const std::map<std::string, std::string>& cells_;
  std::string place_;
  IetRecordings recordings_;
};

}  // namespace

void check_dimensions(const IetSpecimen& specimen, const std::string& place) {
  const auto check = [&](const char* name, const std::optional<double>& value, bool wanted) {
    if (value.has_value() == wanted) return;
    throw InputError(place, std::string(name) + (wanted ? " is empty" : " has no meaning") + " for a " +
                                klang::to_text(specimen.shape));
  };
  const bool bar = specimen.shape == IetShape::kBar, rod = specimen.shape == IetShape::kRod;
  check("length_m", specimen.length_m, bar || rod);
  check("width_m", specimen.width_m, bar);
  check("thickness_m", specimen.thickness_m, !rod);
  check("diameter_m", specimen.diameter_m, !bar);
}

namespace {

std::vector<std::string> known_columns() {
  std::vector<std::string> names;
  for (const FieldRow& row : field_rows<IetSpecimen>()) names.push_back(row.name);
  return names;
}

std::vector<std::string> head_of(const CsvFile& file, IetRecordings recordings) {
  std::vector<std::string> columns;
  const std::vector<std::string> known = known_columns();
  for (const std::string_view cell : file.cells()) {
    const std::string name(cell);
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw unknown_word(file.place(), "unknown column", name, name, known);
    if (std::find(columns.begin(), columns.end(), name) != columns.end())
      throw InputError(file.place(), "column appears twice", name);
    columns.push_back(name);
  }
  for (const FieldRow& row : field_rows<IetSpecimen>()) {
    if (is_needed(row.name, row.required, recordings) &&
        std::find(columns.begin(), columns.end(), row.name) == columns.end())
      throw InputError(file.place(), "column is missing", row.name, word_list(known));
  }
  return columns;
}

}  // namespace

std::vector<IetSpecimen> read_iet_specimens(const std::filesystem::path& path, IetRecordings recordings) {
  CsvFile file(path, kMostBytes);
  std::vector<std::string> columns;
  std::vector<IetSpecimen> specimens;
  std::set<std::string> names;
  while (file.next()) {
    if (columns.empty()) {
      columns = head_of(file, recordings);
      continue;
    }
    if (file.cells().size() != columns.size())
      throw InputError(file.place(), "has the wrong number of cells", std::to_string(file.cells().size()),
                       std::to_string(columns.size()));
    std::map<std::string, std::string> cells;
    for (std::size_t i = 0; i < columns.size(); ++i) cells[columns[i]] = std::string(file.cells()[i]);
    IetSpecimen& specimen = specimens.emplace_back();
    IetSpecimen::describe(specimen, CellReader(cells, file.place(), recordings));
    check_dimensions(specimen, file.place());
    if (!names.insert(specimen.specimen).second)
      throw InputError(file.place(), "specimen is there twice", specimen.specimen);
    std::error_code error;
    if (recordings == IetRecordings::kNeeded &&
        !std::filesystem::is_regular_file(path.parent_path() / specimen.recording, error))
      throw InputError(file.place(), "no such recording", specimen.recording);
    if (specimens.size() > kMostSpecimens)
      throw InputError(path.string(), "has too many specimens", "", "up to " + std::to_string(kMostSpecimens));
  }
  if (specimens.empty()) throw InputError(path.string(), "has no specimen", "", word_list(known_columns()));
  return specimens;
}

void mark_outliers(std::vector<IetRow>& rows) {
  constexpr double kLimit = 3.5, kLeastSpread = 1e-6;
  constexpr std::size_t kFewest = 5;
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t n = values.size();
    return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
  };
  for (const IetShape shape : {IetShape::kBar, IetShape::kRod, IetShape::kDisc}) {
    for (const auto member : {&IetRow::e_e1876_pa, &IetRow::g_e1876_pa}) {
      std::vector<double> values, distances;
      for (const IetRow& row : rows)
        if (row.given.shape == shape && !row.implausible && row.*member) values.push_back(*(row.*member));
      if (values.size() < kFewest) continue;
      const double centre = median(values);
      for (const double value : values) distances.push_back(std::abs(value - centre));
      const double spread = std::max(median(distances), kLeastSpread * std::abs(centre));
      for (IetRow& row : rows) {
        if (row.given.shape != shape || !(row.*member)) continue;
        row.outlier = row.outlier || 0.6745 * std::abs(*(row.*member) - centre) / spread > kLimit;
      }
    }
  }
}

std::vector<IetSummary> summary_of(const std::vector<IetRow>& rows) {
  constexpr double kRoundOff = 1e-11;  // what is left of the spread of one and the same value
  const std::pair<const char*, std::optional<double> IetRow::*> quantities[] = {
      {"e_e1876_pa", &IetRow::e_e1876_pa},
      {"g_e1876_pa", &IetRow::g_e1876_pa},
      {"nu_e1876", &IetRow::nu_e1876},
      {"e_model_pa", &IetRow::e_model_pa},
      {"g_model_pa", &IetRow::g_model_pa},
      {"nu_model", &IetRow::nu_model},
      {"q_inverse_flexural", &IetRow::q_inverse_flexural}};
  std::vector<IetSummary> summary;
  for (const IetShape shape : {IetShape::kBar, IetShape::kRod, IetShape::kDisc}) {
    for (const auto& [name, member] : quantities) {
      std::vector<double> values;
      for (const IetRow& row : rows)
        if (row.given.shape == shape && row.counts() && row.*member) values.push_back(*(row.*member));
      if (values.empty()) continue;
      double sum = 0.0, squares = 0.0;
      for (const double value : values) sum += value;
      const double n = static_cast<double>(values.size()), mean = sum / n;
      for (const double value : values) squares += (value - mean) * (value - mean);
      IetSummary& line = summary.emplace_back();
      line.shape = shape;
      line.quantity = name;
      line.mean = mean;
      line.n = static_cast<int>(values.size());
      if (values.size() < 2) continue;
      const double std = std::sqrt(squares / (n - 1.0));
      line.std = std > kRoundOff * std::abs(mean) ? std : 0.0;
    }
  }
  return summary;
}

}  // namespace klang::fit
