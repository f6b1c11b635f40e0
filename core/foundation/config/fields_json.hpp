#pragma once
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "core/foundation/config/fields.hpp"

namespace klang {

/// Writes described fields into a JSON object. What was not measured (empty, or a number that is not finite) becomes null;
/// Field::when_empty says otherwise.
class JsonWriter {
 public:
  explicit JsonWriter(nlohmann::json& object) : object_(object) {}

  void operator()(const Field& field, double value);
  void operator()(const Field& field, std::int64_t value);
  void operator()(const Field& field, std::uint64_t value);
  void operator()(const Field& field, int value) { (*this)(field, static_cast<std::int64_t>(value)); }
  void operator()(const Field& field, bool value);
  void operator()(const Field& field, const std::string& value);
  void operator()(const Field& field, const std::vector<double>& values);
  void operator()(const Field& field, const std::vector<int>& values);
  void operator()(const Field& field, const std::vector<std::string>& values);
  void operator()(const Field& field, const std::vector<std::vector<double>>& rows);
  void operator()(const Field& field, const std::map<std::string, double>& values);
  void operator()(const Field& field, const JsonText& value);
  template <std::size_t n>
  void operator()(const Field& field, const std::array<double, n>& values) {
    (*this)(field, std::vector<double>(values.begin(), values.end()));
  }
  template <Worded Enum>
  void operator()(const Field& field, Enum value) {
    (*this)(field, to_text(value));
  }
  template <class T>
  void operator()(const Field& field, const std::optional<T>& value) {
    if (value) {
      Field held = field;  // a value is there, also when it is an empty text
      if (held.when_empty == WhenEmpty::kLeftOut) held.when_empty = WhenEmpty::kKept;
      (*this)(held, *value);
    } else if (field.when_empty != WhenEmpty::kLeftOut) {
      null(field);
    }
  }
  template <Described T>
  void operator()(const Field& field, const T& value) {
    T::describe(value, JsonWriter(inner_object(field)));
  }
  template <Described T>
  void operator()(const Field& field, const std::vector<T>& values) {
    if (is_empty(field, values.empty())) return;
    nlohmann::json& list = inner_list(field);
    for (const T& value : values) T::describe(value, JsonWriter(next_object(list)));
  }

 private:
  void null(const Field& field);
  /// Writes null or nothing where the field asks for that instead of an empty value.
  bool is_empty(const Field& field, bool empty);
  nlohmann::json& inner_object(const Field& field);
  nlohmann::json& inner_list(const Field& field);
  static nlohmann::json& next_object(nlohmann::json& list);
  nlohmann::json& object_;
};

/// Adds the fields of value to object, which becomes an object where it was null.
template <Described T>
void write_fields(nlohmann::json& object, const T& value) {
  T::describe(value, JsonWriter(object));
}

/// The fields of value as a JSON object.
template <Described T>
nlohmann::json json_of(const T& value) {
  nlohmann::json object;
  write_fields(object, value);
  return object;
}

/// Reads described fields from a JSON object: what JsonWriter wrote comes back, null as a NaN or an optional without a value.
/// A key that is missing leaves a member as it is unless the field is required; a value of another type, or a number out of
/// its range, is an InputError that names the place. Keys that no field has are left alone: newer files may have more.
class JsonReader {
 public:
  /// @param place  "fit.json.partials[3]", for messages
  JsonReader(const nlohmann::json& object, std::string place);

  void operator()(const Field& field, double& value) const;
  void operator()(const Field& field, std::int64_t& value) const;
  void operator()(const Field& field, std::uint64_t& value) const;
  void operator()(const Field& field, int& value) const;
  void operator()(const Field& field, bool& value) const;
  void operator()(const Field& field, std::string& value) const;
  void operator()(const Field& field, std::vector<double>& values) const;
  void operator()(const Field& field, std::vector<int>& values) const;
  void operator()(const Field& field, std::vector<std::string>& values) const;
  void operator()(const Field& field, std::vector<std::vector<double>>& rows) const;
  void operator()(const Field& field, std::map<std::string, double>& values) const;
  void operator()(const Field& field, JsonText& value) const;
  template <std::size_t n>
  void operator()(const Field& field, std::array<double, n>& values) const {
    std::vector<double> list;
    (*this)(field, list);
    if (!has(field)) return;
    if (list.size() != n) wrong(field, "needs " + std::to_string(n) + " numbers");
    std::copy(list.begin(), list.end(), values.begin());
  }
  template <Worded Enum>
  void operator()(const Field& field, Enum& value) const {
    std::string text;
    (*this)(field, text);
    if (text.empty()) return;
    const std::optional<Enum> found = enum_from_text<Enum>(text);
    if (!found) wrong(field, "unknown word", allowed_words<Enum>());
    value = *found;
  }
  template <class T>
  void operator()(const Field& field, std::optional<T>& value) const {
    if (has(field)) {
      (*this)(field, value.emplace());
    } else if (is_null(field)) {
      value.reset();
    }
  }
  template <Described T>
  void operator()(const Field& field, T& value) const {
    if (has(field)) T::describe(value, inner(field));
  }
  template <Described T>
  void operator()(const Field& field, std::vector<T>& values) const {
    if (!has(field)) return;
    values.clear();
    for (std::size_t i = 0, n = list_size(field); i < n; ++i) T::describe(values.emplace_back(), item(field, i));
  }

 private:
  const nlohmann::json* find(const Field& field) const;  ///< nullptr where missing or null; complains of required ones
  bool has(const Field& field) const { return find(field) != nullptr; }
  bool is_null(const Field& field) const;
  JsonReader inner(const Field& field) const;
  std::size_t list_size(const Field& field) const;
  JsonReader item(const Field& field, std::size_t index) const;
  std::string place_of(const Field& field) const;
  static bool is_whole(const nlohmann::json& number);
  void require_range(const Field& field, double value) const;
  [[noreturn]] void wrong(const Field& field, const std::string& problem, const std::string& allowed = {}) const;
  const nlohmann::json& object_;
  std::string place_;
};

/// @throws InputError
template <Described T>
T read_fields(const nlohmann::json& object, std::string place) {
  T value{};
  T::describe(value, JsonReader(object, std::move(place)));
  return value;
}

}  // namespace klang
