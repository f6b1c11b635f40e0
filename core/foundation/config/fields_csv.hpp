#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang {

/// Text as a cell, quoted where needed (RFC 4180).
std::string csv_cell(std::string_view text);
/// SI, shortest exact decimals; empty where it was not measured (not finite).
std::string csv_cell(double value);

/// The names of a described struct's fields and their values as CSV cells: numbers, texts, words, booleans, optional ones, and
/// intervals of two numbers (ci95_low, ci95_high); other fields have no column.
class CsvRow {
 public:
  explicit CsvRow(const std::vector<std::string_view>& left_out = {}) : left_out_(left_out) {}

  template <class T>
  void operator()(const Field& field, const T& value) {
    if (is_left_out(field.name)) return;
    const std::string name(field.name);
    if constexpr (std::same_as<T, bool>) {
      add(name, value ? "true" : "false");
    } else if constexpr (std::integral<T>) {
      add(name, std::to_string(value));
    } else if constexpr (std::floating_point<T>) {
      add(name, csv_cell(value));
    } else if constexpr (Worded<T>) {
      add(name, csv_cell(to_text(value)));
    } else if constexpr (std::convertible_to<T, std::string>) {
      add(name, csv_cell(std::string_view(value)));
    } else if constexpr (std::same_as<T, std::optional<std::array<double, 2>>>) {
      add(name + "_low", value ? csv_cell((*value)[0]) : std::string());
      add(name + "_high", value ? csv_cell((*value)[1]) : std::string());
    } else if constexpr (has_optional_cell<T>()) {
      if (value) {
        (*this)(field, *value);
      } else {
        add(name, {});
      }
    }
  }

  const std::string& head() const { return head_; }    ///< "name,value,ci95_low"
  const std::string& cells() const { return cells_; }  ///< "E,7e10,"

 private:
  template <class T>
  static constexpr bool has_optional_cell() {
    if constexpr (requires(const T& value) { value.has_value(); }) {
      using Inner = typename T::value_type;
      return std::is_arithmetic_v<Inner> || Worded<Inner> || std::convertible_to<Inner, std::string>;
    }
    return false;
  }
  bool is_left_out(std::string_view name) const;
  void add(const std::string& name, const std::string& cell);
  std::vector<std::string_view> left_out_;
  std::string head_, cells_;
  bool first_ = true;
};

/// A head line with the fields' names, then a line for each row. @param left_out  names of fields without a column
template <Described Row>
std::string csv_table(const std::vector<Row>& rows, const std::vector<std::string_view>& left_out = {}) {
  CsvRow names(left_out);
  const Row example{};
  Row::describe(example, names);
  std::string text = names.head() + "\n";
  for (const Row& row : rows) {
    CsvRow cells(left_out);
    Row::describe(row, cells);
    text += cells.cells() + "\n";
  }
  return text;
}

}  // namespace klang
