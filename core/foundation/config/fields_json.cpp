#include "core/foundation/config/fields_json.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"

namespace klang {
namespace {

using nlohmann::json;

std::string key(const Field& field) { return std::string(field.name); }

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
constexpr double kLargestExactInteger = 9007199254740992.0;  // 2^53

}  // namespace

void JsonWriter::operator()(const Field& field, double value) { object_[key(field)] = json_number(value); }
void JsonWriter::operator()(const Field& field, std::int64_t value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, std::uint64_t value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, bool value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, const std::string& value) {
  if (!is_empty(field, value.empty())) object_[key(field)] = value;
}
void JsonWriter::operator()(const Field& field, const std::vector<int>& values) {
  if (!is_empty(field, values.empty())) object_[key(field)] = values;
}
void JsonWriter::operator()(const Field& field, const std::vector<std::string>& values) {
  if (!is_empty(field, values.empty())) object_[key(field)] = values;
}
void JsonWriter::operator()(const Field& field, const JsonText& value) {
  if (is_empty(field, value.text.empty())) return;
  object_[key(field)] = value.text.empty() ? json() : json::parse(value.text);
}

void JsonWriter::operator()(const Field& field, const std::vector<double>& values) {
  if (is_empty(field, values.empty())) return;
  json& list = inner_list(field);
  for (const double value : values) list.push_back(json_number(value));
}

void JsonWriter::operator()(const Field& field, const std::vector<std::vector<double>>& rows) {
  if (is_empty(field, rows.empty())) return;
  json& list = inner_list(field);
  for (const auto& row : rows) {
    json& inner = list.emplace_back(json::array());
    for (const double value : row) inner.push_back(json_number(value));
  }
}

void JsonWriter::operator()(const Field& field, const std::map<std::string, double>& values) {
  if (is_empty(field, values.empty())) return;
  json& object = inner_object(field);
  for (const auto& [name, value] : values) object[name] = json_number(value);
}

void JsonWriter::null(const Field& field) { object_[key(field)] = nullptr; }
bool JsonWriter::is_empty(const Field& field, bool empty) {
  if (!empty || field.when_empty == WhenEmpty::kKept) return false;
  if (field.when_empty == WhenEmpty::kNull) null(field);
  return true;
}
json& JsonWriter::inner_object(const Field& field) { return object_[key(field)] = json::object(); }
json& JsonWriter::inner_list(const Field& field) { return object_[key(field)] = json::array(); }
json& JsonWriter::next_object(json& list) { return list.emplace_back(json::object()); }

JsonReader::JsonReader(const json& object, std::string place) : object_(object), place_(std::move(place)) {
  if (!object.is_object()) throw InputError(place_, "not an object");
}

const json* JsonReader::find(const Field& field) const {
  const auto found = object_.find(field.name);
  if (found != object_.end() && !found->is_null()) return &*found;
  if (field.required) throw InputError(place_of(field), "missing");
  return nullptr;
}

bool JsonReader::is_null(const Field& field) const {
  const auto found = object_.find(field.name);
  return found != object_.end() && found->is_null();
}

std::string JsonReader::place_of(const Field& field) const { return place_ + "." + key(field); }

void JsonReader::wrong(const Field& field, const std::string& problem, const std::string& allowed) const {
  const json& value = object_.at(key(field));
  throw InputError(place_of(field), problem, value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 60),
                   allowed);
}

void JsonReader::require_range(const Field& field, double value) const {
  if (!field.range.holds(value)) wrong(field, "out of range", field.range.text());
}

void JsonReader::operator()(const Field& field, double& value) const {
  const json* found = find(field);
  if (found == nullptr) {
    if (is_null(field)) value = kNotMeasured;
    return;
  }
  if (!found->is_number()) wrong(field, "not a number");
  require_range(field, found->get<double>());
  value = found->get<double>();
}

/// Some writers end whole numbers with ".0".
bool JsonReader::is_whole(const json& number) {
  const auto value = number.get<double>();
  return number.is_number_integer() || (value == std::floor(value) && std::abs(value) <= kLargestExactInteger);
}

void JsonReader::operator()(const Field& field, std::int64_t& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_number()) wrong(field, "not a number");
  if (!is_whole(*found)) wrong(field, "not a whole number");
  require_range(field, found->get<double>());
  value = found->is_number_integer() ? found->get<std::int64_t>() : static_cast<std::int64_t>(found->get<double>());
}

void JsonReader::operator()(const Field& field, std::uint64_t& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_number()) wrong(field, "not a number");
  if (!is_whole(*found) || found->get<double>() < 0) wrong(field, "not a whole number of 0 or more");
  value = found->is_number_integer() ? found->get<std::uint64_t>() : static_cast<std::uint64_t>(found->get<double>());
}

void JsonReader::operator()(const Field& field, int& value) const {
  std::int64_t wide = value;
  (*this)(field, wide);
  if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max())
    wrong(field, "not an index or a count");
  value = static_cast<int>(wide);
}

void JsonReader::operator()(const Field& field, bool& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_boolean()) wrong(field, "not true or false");
  value = found->get<bool>();
}

void JsonReader::operator()(const Field& field, std::string& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_string()) wrong(field, "not a text");
  value = found->get<std::string>();
}

void JsonReader::operator()(const Field& field, JsonText& value) const {
  const json* found = find(field);
  if (found != nullptr) value.text = found->dump(2, ' ', false, json::error_handler_t::replace);
}

namespace {

[[noreturn]] void wrong_entry(const std::string& place, const char* problem, const json& entry) {
  throw InputError(place, problem, entry.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 60));
}

std::string entry_place(const std::string& place, std::size_t i) { return place + "[" + std::to_string(i) + "]"; }

std::vector<double> numbers_of(const json& list, const std::string& place, const Range& range) {
  if (!list.is_array()) throw InputError(place, "not a list");
  std::vector<double> values;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const json& entry = list[i];
    if (!entry.is_number() && !entry.is_null()) wrong_entry(entry_place(place, i), "not a number", entry);
    values.push_back(entry.is_null() ? kNotMeasured : entry.get<double>());
    if (!entry.is_null() && !range.holds(values.back())) wrong_entry(entry_place(place, i), "out of range", entry);
  }
  return values;
}

}  // namespace

void JsonReader::operator()(const Field& field, std::vector<double>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_array()) wrong(field, "not a list");
  values = numbers_of(*found, place_of(field), field.range);
}

void JsonReader::operator()(const Field& field, std::vector<int>& values) const {
  const std::size_t n = list_size(field);
  if (has(field)) values.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const json& entry = (*find(field))[i];
    if (!entry.is_number_integer()) wrong_entry(entry_place(place_of(field), i), "not a whole number", entry);
    values.push_back(entry.get<int>());
  }
}

void JsonReader::operator()(const Field& field, std::vector<std::string>& values) const {
  const std::size_t n = list_size(field);
  if (has(field)) values.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const json& entry = (*find(field))[i];
    if (!entry.is_string()) wrong_entry(entry_place(place_of(field), i), "not a text", entry);
    values.push_back(entry.get<std::string>());
  }
}

void JsonReader::operator()(const Field& field, std::vector<std::vector<double>>& rows) const {
  const std::size_t n = list_size(field);
  if (has(field)) rows.clear();
  for (std::size_t i = 0; i < n; ++i)
    rows.push_back(numbers_of((*find(field))[i], entry_place(place_of(field), i), field.range));
}

void JsonReader::operator()(const Field& field, std::map<std::string, double>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_object()) wrong(field, "not an object");
  values.clear();
  for (const auto& [name, value] : found->items()) {
    if (value.is_null()) continue;
    if (!value.is_number()) wrong_entry(place_of(field) + "." + name, "not a number", value);
    values[name] = value.get<double>();
  }
}

JsonReader JsonReader::inner(const Field& field) const { return {*find(field), place_of(field)}; }

std::size_t JsonReader::list_size(const Field& field) const {
  const json* found = find(field);
  if (found == nullptr) return 0;
  if (!found->is_array()) wrong(field, "not a list");
  return found->size();
}

JsonReader JsonReader::item(const Field& field, std::size_t index) const {
  return {(*find(field))[index], entry_place(place_of(field), index)};
}

}  // namespace klang
