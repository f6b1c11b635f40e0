#include "fit/ringdown/partial_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/csv.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/sound/audio/note.hpp"

namespace klang::fit {
namespace {

enum class Rule { kAboveZero, kAtLeastZero, kAny, kWord, kSpecimen, kDerived };

struct Column {
  const char* name;
  std::optional<double> Partial::*member;  ///< null for frequency_hz and for what is no number
  Rule rule;
  bool is_word() const { return rule == Rule::kWord; }
};

constexpr std::array<Column, 15> kColumns{{
    {"frequency_hz", nullptr, Rule::kAboveZero},
    {"frequency_std_hz", &Partial::frequency_std_hz, Rule::kAboveZero},
    {"decay_per_s", &Partial::decay_per_s, Rule::kAtLeastZero},
    {"decay_std_per_s", &Partial::decay_std_per_s, Rule::kAboveZero},
    {"amplitude", &Partial::amplitude, Rule::kAtLeastZero},
    {"amplitude_std", &Partial::amplitude_std, Rule::kAboveZero},
    {"phase_rad", &Partial::phase_rad, Rule::kAny},
    {"phase_std_rad", &Partial::phase_std_rad, Rule::kAboveZero},
    {"kind", nullptr, Rule::kWord},
    {"specimen", nullptr, Rule::kSpecimen},
    {"note", nullptr, Rule::kDerived},
    {"cents", nullptr, Rule::kDerived},
    {"beat_hz", nullptr, Rule::kDerived},
    {"stage", nullptr, Rule::kDerived},
    {"matched_mode", nullptr, Rule::kDerived},
}};

std::string column_names() {
  std::string names;
  for (const Column& column : kColumns) {
    if (!names.empty()) names += ", ";
    names += column.name;
  }
  return names;
}

/// At most 60 characters of a cell, for a message.
std::string quoted(std::string_view cell) {
  std::string text;
  text += '\'';
  text += cell.substr(0, 60);
  text += '\'';
  return text;
}

void store(Partial& partial, const Column& column, double value, const std::string& place, const std::string& shown) {
  constexpr double kLargest = 1e12;
  const bool bounded = std::isfinite(value) && std::abs(value) <= kLargest;
  const bool fits = column.rule == Rule::kAny || value > 0 || (column.rule == Rule::kAtLeastZero && value == 0);
  if (!bounded || !fits) {
    throw InputError(place, std::string(column.name) + " is out of range", shown,
                     column.rule == Rule::kAboveZero     ? "above 0, up to 1e12"
                     : column.rule == Rule::kAtLeastZero ? "0 to 1e12"
                                                         : "-1e12 to 1e12");
  }
  if (column.member == nullptr) {
    partial.frequency_hz = value;
  } else {
    partial.*column.member = value;
  }
}

void store_kind(Partial& partial, std::string_view word, const std::string& place) {
  const auto kind = enum_from_text<PartialKind>(word);
  if (!kind) throw InputError(place, "unknown kind", word, allowed_words<PartialKind>());
  partial.kind = *kind;
}

PartialTable finished(std::vector<Partial> partials, const std::string& name) {
  if (partials.empty()) throw InputError(name, "has no partials", "0 rows", "at least 1");
  std::stable_sort(partials.begin(), partials.end(),
                   [](const Partial& a, const Partial& b) { return a.frequency_hz < b.frequency_hz; });
  return {std::move(partials), name, {}};
}

/// Null for columns that mean nothing here, which are named in left_out.
std::vector<const Column*> header_columns(const std::vector<std::string_view>& cells, const std::string& place,
                                          std::vector<std::string>& left_out) {
  std::vector<const Column*> columns;
  for (const std::string_view cell : cells) {
    const auto found = std::find_if(kColumns.begin(), kColumns.end(), [&](const Column& c) { return cell == c.name; });
    if (found == kColumns.end()) {
      columns.push_back(nullptr);
      if (!cell.empty()) left_out.emplace_back(cell.substr(0, 60));
      continue;
    }
    if (std::find(columns.begin(), columns.end(), &*found) != columns.end()) {
      throw InputError(place, "column appears twice", std::string(cell));
    }
    columns.push_back(&*found);
  }
  if (std::find(columns.begin(), columns.end(), kColumns.data()) == columns.end()) {
    throw InputError(place, "the header has no column frequency_hz",
                     left_out.empty() ? std::string() : quoted(std::string_view(left_out.front())), column_names());
  }
  return columns;
}

/// The rows of one specimen; all where none or one is named.
std::vector<Partial> rows_of(std::string_view specimen, std::vector<std::pair<std::string, Partial>> rows,
                             const std::string& name) {
  std::vector<std::string> names;
  for (const auto& [row_specimen, partial] : rows) {
    if (std::find(names.begin(), names.end(), row_specimen) == names.end()) names.push_back(row_specimen);
  }
  std::vector<Partial> kept;
  if (names.size() > 1 && std::find(names.begin(), names.end(), specimen) == names.end())
    throw unknown_word(name, "holds several specimens, and none of this name", specimen, specimen, names);
  for (const auto& [row_specimen, partial] : rows) {
    if (names.size() < 2 || row_specimen == specimen) kept.push_back(partial);
  }
  return kept;
}

Partial partial_of_row(const nlohmann::json& row, const std::string& place) {
  if (!row.is_object()) throw InputError(place, "is not an object");
  Partial partial;
  for (const Column& column : kColumns) {
    if (column.rule == Rule::kSpecimen || column.rule == Rule::kDerived) continue;
    const auto cell = row.find(column.name);
    const bool missing = cell == row.end() || cell->is_null();
    if (missing && column.member == nullptr && !column.is_word()) throw InputError(place, "frequency_hz is missing");
    if (missing) continue;
    if (column.is_word()) {
      if (!cell->is_string()) throw InputError(place, "kind is no text", cell->type_name());
      store_kind(partial, cell->get<std::string>(), place);
      continue;
    }
    if (!cell->is_number()) throw InputError(place, std::string(column.name) + " is not a number", cell->type_name());
    const double value = cell->get<double>();
    store(partial, column, value, place, klang::to_text(value));
  }
  return partial;
}

}  // namespace

PartialTable parse_partial_csv(std::string_view text, const std::string& name, std::string_view specimen) {
  CsvFile file(std::string(text), name);
  std::vector<const Column*> columns;
  std::vector<std::pair<std::string, Partial>> rows;
  std::vector<std::string> left_out;
  while (file.next()) {
    const auto& cells = file.cells();
    const std::string place = file.place();
    if (columns.empty()) {
      columns = header_columns(cells, place, left_out);
      continue;
    }
    if (cells.size() != columns.size()) {
      throw InputError(place, "has the wrong number of cells", std::to_string(cells.size()),
                       std::to_string(columns.size()));
    }
    auto& [row_specimen, partial] = rows.emplace_back();
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (columns[i] == nullptr || columns[i]->rule == Rule::kDerived) continue;
      if (columns[i]->rule == Rule::kSpecimen) {
        row_specimen = cells[i];
        continue;
      }
      if (cells[i].empty() && (columns[i]->member != nullptr || columns[i]->is_word())) continue;
      const std::string shown = quoted(cells[i]);
      if (columns[i]->is_word()) {
        store_kind(partial, cells[i], place);
        continue;
      }
      const auto value = csv_number(cells[i]);
      if (!value) throw InputError(place, std::string(columns[i]->name) + " is not a number", shown);
      store(partial, *columns[i], *value, place, shown);
    }
  }
  if (columns.empty())
    throw InputError(name, "is empty", {}, "a header line with frequency_hz, then one line per partial");
  PartialTable table = finished(rows_of(specimen, std::move(rows), name), name);
  table.left_out_columns = std::move(left_out);
  return table;
}

PartialTable parse_partial_json(std::string_view text, const std::string& name, std::string_view specimen) {
  const auto root = parse_json(text, name);
  std::vector<std::pair<std::string, Partial>> rows;
  const auto add = [&](const nlohmann::json& list, const std::string& row_specimen, const std::string& place) {
    if (!list.is_array()) throw InputError(place, "partials is not a list");
    for (std::size_t i = 0; i < list.size(); ++i)
      rows.emplace_back(row_specimen, partial_of_row(list[i], place + ", partials[" + std::to_string(i) + "]"));
  };
  const auto specimens = root.is_object() ? root.find("specimens") : root.end();
  if (root.is_object() && specimens != root.end() && specimens->is_array()) {  // fit.json
    for (const nlohmann::json& entry : *specimens) {
      if (!entry.is_object() || !entry.contains("partials")) throw InputError(name, "a specimen has no key partials");
      const auto named = entry.find("name");
      const bool is_text = named != entry.end() && named->is_string();
      add(entry["partials"], is_text ? named->get<std::string>() : std::string(), name);
    }
  } else if (root.is_object()) {
    const auto found = root.find("partials");
    if (found == root.end()) throw InputError(name, "has no key partials");
    add(*found, {}, name);
  } else {
    add(root, {}, name);
  }
  return finished(rows_of(specimen, std::move(rows), name), name);
}

PartialTable read_partial_table(const std::filesystem::path& path, std::string_view specimen) {
  const std::string extension = path.extension().string();
  constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
  if (extension == ".csv") return parse_partial_csv(read_file(path, kMaxBytes), path.string(), specimen);
  if (extension == ".json") return parse_partial_json(read_file(path, kMaxBytes), path.string(), specimen);
  throw InputError(path.string(), "is no partial table by its extension", extension, ".csv or .json");
}

void name_notes(std::vector<Partial>& partials, double a4_hz) {
  for (Partial& partial : partials) {
    const audio::NearestNote nearest = audio::nearest_note(partial.frequency_hz, a4_hz);
    partial.note = nearest.name;
    partial.cents = nearest.cents;
  }
}

std::string partial_csv(const PartialTable& table) { return csv_table(table.partials); }

void write_partial_table(const std::filesystem::path& path, const PartialTable& table) {
  write_file(path, partial_csv(table));
}

}  // namespace klang::fit
