#include "core/foundation/config/fields.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang {

bool Range::holds(double value) const {
  const bool low_holds = low_open ? value > low : value >= low;
  const bool high_holds = high_open ? value < high : value <= high;
  return low_holds && high_holds;
}

std::string Range::text() const {
  const bool has_low = std::isfinite(low), has_high = std::isfinite(high);
  if (has_low && has_high && !low_open && !high_open) return to_text(low) + " to " + to_text(high);
  std::string text;
  if (has_low) text = (low_open ? "above " : "at least ") + to_text(low);
  if (has_high) text += (text.empty() ? "" : ", ") + std::string(high_open ? "below " : "at most ") + to_text(high);
  return text;
}

std::string FieldRows::number_text(double value) { return std::isfinite(value) ? to_text(value) : std::string(); }

void FieldRows::add(const Field& field, std::string type, std::string default_text) {
  rows_.push_back({prefix_ + std::string(field.name), std::move(type), std::move(default_text), field.range.text(),
                   std::string(field.meaning), field.required});
}

std::string field_rows_markdown(const std::vector<FieldRow>& rows, bool with_defaults) {
  std::string text = with_defaults ? "| key | type | default | range | meaning |\n| --- | --- | --- | --- | --- |\n"
                                   : "| key | type | range | meaning |\n| --- | --- | --- | --- |\n";
  for (const FieldRow& row : rows) {
    text += "| `" + row.name + "` | " + row.type + " | ";
    if (with_defaults) text += (row.required ? "required" : row.default_text) + " | ";
    text += row.range + " | " + row.meaning + " |\n";
  }
  return text;
}

void FieldCheck::number(const Field& field, double value) {
  if (field.range.holds(value)) return;
  violations_.push_back(prefix_ + std::string(field.name) + " = " + to_text(value) + " (allowed: " +
                        (field.range.text().empty() ? "a finite number" : field.range.text()) + ")");
}

void throw_violations(std::string_view place, const std::vector<std::string>& violations) {
  if (violations.empty()) return;
  std::string all;
  for (const std::string& violation : violations) all += (all.empty() ? "" : "; ") + violation;
  throw InputError(place, all);
}

}  // namespace klang
