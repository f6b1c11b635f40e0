#include "fit/ringdown/partial_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/csv.hpp"

namespace klang::fit {
namespace {

enum class Rule { kAboveZero, kAtLeastZero, kAny, kWord };

struct Column {
  const char* name;
  std::optional<double> Partial::*member;  ///< null for frequency_hz and kind
  Rule rule;
  bool is_word() const { return rule == Rule::kWord; }
};

constexpr std::array<Column, 9> kColumns{{
    {"frequency_hz", nullptr, Rule::kAboveZero},
    {"frequency_std_hz", &Partial::frequency_std_hz, Rule::kAboveZero},
    {"decay_per_s", &Partial::decay_per_s, Rule::kAtLeastZero},
    {"decay_std_per_s", &Partial::decay_std_per_s, Rule::kAboveZero},
    {"amplitude", &Partial::amplitude, Rule::kAtLeastZero},
    {"amplitude_std", &Partial::amplitude_std, Rule::kAboveZero},
    {"phase_rad", &Partial::phase_rad, Rule::kAny},
    {"phase_std_rad", &Partial::phase_std_rad, Rule::kAboveZero},
    {"kind", nullptr, Rule::kWord},
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
  if (!kind) throw InputError(place, "kind is none", quoted(word), allowed_words<PartialKind>());
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

}  // namespace

PartialTable parse_partial_csv(std::string_view text, const std::string& name) {
  CsvFile file(std::string(text), name);
  std::vector<const Column*> columns;
  std::vector<Partial> partials;
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
    Partial partial;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (columns[i] == nullptr) continue;
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
    partials.push_back(partial);
  }
  if (columns.empty())
    throw InputError(name, "is empty", {}, "a header line with frequency_hz, then one line per partial");
  PartialTable table = finished(std::move(partials), name);
  table.left_out_columns = std::move(left_out);
  return table;
}

PartialTable parse_partial_json(std::string_view text, const std::string& name) {
  const auto root = parse_json(text, name);
  const auto* rows = &root;
  if (root.is_object()) {
    const auto found = root.find("partials");
    if (found == root.end()) throw InputError(name, "has no key partials");
    rows = &*found;
  }
  if (!rows->is_array()) throw InputError(name, "partials is not a list");
  std::vector<Partial> partials;
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const auto& row = (*rows)[i];
    const std::string place = name + ", partials[" + std::to_string(i) + "]";
    if (!row.is_object()) throw InputError(place, "is not an object");
    Partial partial;
    for (const Column& column : kColumns) {
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
    partials.push_back(partial);
  }
  return finished(std::move(partials), name);
}

PartialTable read_partial_table(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  constexpr std::size_t kMaxBytes = std::size_t{64} << 20;
  if (extension == ".csv") return parse_partial_csv(read_file(path, kMaxBytes), path.string());
  if (extension == ".json") return parse_partial_json(read_file(path, kMaxBytes), path.string());
  throw InputError(path.string(), "is no partial table by its extension", extension, ".csv or .json");
}

void write_partial_table(const std::filesystem::path& path, const PartialTable& table) {
  std::string text;
  for (const Column& column : kColumns) {
    if (!text.empty()) text += ',';
    text += column.name;
  }
  text += '\n';
  for (const Partial& partial : table.partials) {
    text += klang::to_text(partial.frequency_hz);
    for (std::size_t i = 1; i < kColumns.size(); ++i) {
      text += ',';
      if (kColumns[i].is_word()) {
        text += to_text(partial.kind);
        continue;
      }
      const auto& cell = partial.*kColumns[i].member;
      if (cell) text += klang::to_text(*cell);
    }
    text += '\n';
  }
  write_file(path, text);
}

}  // namespace klang::fit
