#include "core/foundation/config/fields.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang {
namespace {

std::string message(const std::string& place, const std::vector<Violation>& violations,
                    const std::function<std::string(const std::string& field)>& name_of) {
  std::string all;
  for (const Violation& v : violations) {
    const std::string what = name_of(v.field) + (v.problem.empty() ? "" : " " + v.problem);
    all += (all.empty() ? "" : "; ") + std::string(InputError("", what, v.value, v.allowed).what());
  }
  return InputError(place, all).what();
}

}  // namespace

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

OptionsError::OptionsError(std::string place, std::vector<Violation> violations)
    : InputError(message(place, violations, [](const std::string& field) { return field; })),
      place_(std::move(place)),
      violations_(std::move(violations)) {}

std::string OptionsError::text(const std::function<std::string(const std::string& field)>& name_of) const {
  return message(place_, violations_, name_of);
}

void FieldCheck::number(const Field& field, double value) {
  if (std::isfinite(value) && field.range.holds(value)) return;
  violations_.push_back(out_of_range(prefix_ + std::string(field.name), value, field.range));
}

Violation out_of_range(std::string field, double value, const Range& range) {
  const std::string allowed = range.text();
  return {std::move(field), "is out of range", to_text(value), allowed.empty() ? "a finite number" : allowed};
}

OptionsError option_error(std::string field, std::string problem, std::string value, std::string allowed) {
  return {{}, {{std::move(field), std::move(problem), std::move(value), std::move(allowed)}}};
}

void throw_violations(std::string_view place, std::vector<Violation> violations) {
  if (!violations.empty()) throw OptionsError(std::string(place), std::move(violations));
}

}  // namespace klang
