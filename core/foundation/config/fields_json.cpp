#include "core/foundation/config/fields_json.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"

namespace klang {
namespace {

using nlohmann::json;

std::string key(const Field& field) { return std::string(field.name); }

}  // namespace

void JsonWriter::operator()(const Field& field, double value) { object_[key(field)] = json_number(value); }
void JsonWriter::operator()(const Field& field, std::int64_t value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, std::uint64_t value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, bool value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, const std::string& value) { object_[key(field)] = value; }
void JsonWriter::operator()(const Field& field, const std::vector<int>& values) { object_[key(field)] = values; }
void JsonWriter::operator()(const Field& field, const std::vector<std::string>& values) {
  object_[key(field)] = values;
}

void JsonWriter::operator()(const Field& field, const std::vector<double>& values) {
  json& list = inner_list(field);
  for (const double value : values) list.push_back(json_number(value));
}

void JsonWriter::operator()(const Field& field, const std::vector<std::vector<double>>& rows) {
  json& list = inner_list(field);
  for (const auto& row : rows) {
    json& inner = list.emplace_back(json::array());
    for (const double value : row) inner.push_back(json_number(value));
  }
}

void JsonWriter::operator()(const Field& field, const std::map<std::string, double>& values) {
  json& object = inner_object(field);
  for (const auto& [name, value] : values) object[name] = json_number(value);
}

void JsonWriter::null(const Field& field) { object_[key(field)] = nullptr; }
json& JsonWriter::inner_object(const Field& field) { return object_[key(field)] = json::object(); }
json& JsonWriter::inner_list(const Field& field) { return object_[key(field)] = json::array(); }
json& JsonWriter::next_object(json& list) { return list.emplace_back(json::object()); }

JsonReader::JsonReader(const json& object, std::string place) : object_(object), place_(std::move(place)) {
  if (!object.is_object()) throw InputError(place_, "not a JSON object", {}, "an object");
}

const json* JsonReader::find(const Field& field) const {
  const auto found = object_.find(field.name);
  if (found != object_.end() && !found->is_null()) return &*found;
  if (field.required) throw InputError(place_of(field), "is missing");
  return nullptr;
}

std::string JsonReader::place_of(const Field& field) const { return place_ + ": " + key(field); }

void JsonReader::wrong(const Field& field, const std::string& allowed) const {
  const json& value = object_.at(key(field));
  throw InputError(place_of(field), "has the wrong type or value",
                   value.dump(-1, ' ', false, json::error_handler_t::replace).substr(0, 60), allowed);
}

void JsonReader::operator()(const Field& field, double& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_number()) wrong(field, "a number");
  const auto number = found->get<double>();
  if (!field.range.holds(number)) wrong(field, field.range.text());
  value = number;
}

void JsonReader::operator()(const Field& field, std::int64_t& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_number_integer()) wrong(field, "an integer");
  const auto number = found->get<std::int64_t>();
  if (!field.range.holds(static_cast<double>(number))) wrong(field, field.range.text());
  value = number;
}

void JsonReader::operator()(const Field& field, std::uint64_t& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_number_unsigned()) wrong(field, "an integer, 0 or more");
  value = found->get<std::uint64_t>();
}

void JsonReader::operator()(const Field& field, int& value) const {
  std::int64_t wide = value;
  (*this)(field, wide);
  if (wide < std::numeric_limits<int>::min() || wide > std::numeric_limits<int>::max()) wrong(field, "a smaller number");
  value = static_cast<int>(wide);
}

void JsonReader::operator()(const Field& field, bool& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_boolean()) wrong(field, "true or false");
  value = found->get<bool>();
}

void JsonReader::operator()(const Field& field, std::string& value) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_string()) wrong(field, "a text");
  value = found->get<std::string>();
}

void JsonReader::operator()(const Field& field, std::vector<double>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  const bool numbers = found->is_array() && std::all_of(found->begin(), found->end(), [](const json& entry) {
                         return entry.is_number() || entry.is_null();
                       });
  if (!numbers) wrong(field, "a list of numbers");
  values.clear();
  for (const json& entry : *found)
    values.push_back(entry.is_null() ? std::numeric_limits<double>::quiet_NaN() : entry.get<double>());
}

void JsonReader::operator()(const Field& field, std::vector<int>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  const bool integers = found->is_array() && std::all_of(found->begin(), found->end(), [](const json& entry) {
                          return entry.is_number_integer();
                        });
  if (!integers) wrong(field, "a list of integers");
  values = found->get<std::vector<int>>();
}

void JsonReader::operator()(const Field& field, std::vector<std::string>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  const bool texts = found->is_array() && std::all_of(found->begin(), found->end(),
                                                      [](const json& entry) { return entry.is_string(); });
  if (!texts) wrong(field, "a list of texts");
  values = found->get<std::vector<std::string>>();
}

void JsonReader::operator()(const Field& field, std::vector<std::vector<double>>& rows) const {
  const std::size_t n = list_size(field);
  rows.clear();
  for (std::size_t i = 0; i < n; ++i) {
    const json row = {{"row", (*find(field))[i]}};
    JsonReader(row, place_of(field) + "[" + std::to_string(i) + "]")({"row", ""}, rows.emplace_back());
  }
}

void JsonReader::operator()(const Field& field, std::map<std::string, double>& values) const {
  const json* found = find(field);
  if (found == nullptr) return;
  if (!found->is_object()) wrong(field, "an object of numbers");
  values.clear();
  for (const auto& [name, value] : found->items()) {
    if (value.is_null()) continue;
    if (!value.is_number()) wrong(field, "an object of numbers");
    values[name] = value.get<double>();
  }
}

JsonReader JsonReader::inner(const Field& field) const { return {*find(field), place_of(field)}; }

std::size_t JsonReader::list_size(const Field& field) const {
  const json* found = find(field);
  if (found == nullptr) return 0;
  if (!found->is_array()) wrong(field, "a list");
  return found->size();
}

JsonReader JsonReader::item(const Field& field, std::size_t index) const {
  return {(*find(field))[index], place_of(field) + "[" + std::to_string(index) + "]"};
}

}  // namespace klang
