#include "core/foundation/config/fields_csv.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"

namespace klang {

std::string csv_cell(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

std::string csv_cell(double value) { return std::isfinite(value) ? to_text(value) : std::string(); }

bool CsvRow::is_left_out(std::string_view name) const {
  return std::find(left_out_.begin(), left_out_.end(), name) != left_out_.end();
}

void CsvRow::add(const std::string& name, const std::string& cell) {
  if (!first_) {
    head_ += ',';
    cells_ += ',';
  }
  first_ = false;
  head_ += name;
  cells_ += cell;
}

}  // namespace klang
