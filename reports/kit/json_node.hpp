#pragma once
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "reports/kit/result_data.hpp"

namespace klang::reports::detail {

/// One object of the file with the path that leads to it, so that every complaint says where.
class Node {
 public:
  Node(const nlohmann::json& value, std::string place) : value_(value), place_(std::move(place)) {}

  const nlohmann::json& raw() const { return value_; }
  const std::string& place() const { return place_; }
  bool has(const char* key) const { return value_.is_object() && value_.contains(key) && !value_.at(key).is_null(); }

  Node child(const char* key) const {
    static const nlohmann::json nothing;
    return {has(key) ? value_.at(key) : nothing, place_ + "." + key};
  }

  Number number(const char* key) const {
    if (!has(key)) return {};
    const nlohmann::json& value = value_.at(key);
    if (!value.is_number()) fail(key, "not a number", value);
    const double number = value.get<double>();
    if (!std::isfinite(number)) return {};
    return number;
  }

  double required(const char* key) const {
    const Number value = number(key);
    if (!value) throw InputError(place_ + "." + key, "missing");
    return *value;
  }

  std::optional<int> integer(const char* key) const {
    const Number value = number(key);
    if (!value) return {};
    if (!(std::abs(*value) <= 1e9)) fail(key, "not an index or a count", value_.at(key));
    return static_cast<int>(*value);
  }

  std::optional<bool> boolean(const char* key) const {
    if (!has(key)) return {};
    if (!value_.at(key).is_boolean()) fail(key, "not true or false", value_.at(key));
    return value_.at(key).get<bool>();
  }

  std::string text(const char* key) const {
    if (!has(key)) return {};
    if (!value_.at(key).is_string()) fail(key, "not a text", value_.at(key));
    return value_.at(key).get<std::string>();
  }

  template <class Function>
  void each(const char* key, Function&& function) const {
    if (!has(key)) return;
    const nlohmann::json& list = value_.at(key);
    if (!list.is_array()) fail(key, "not a list", list);
    for (std::size_t i = 0; i < list.size(); ++i) {
      function(Node(list[i], place_ + "." + key + "[" + std::to_string(i) + "]"));
    }
  }

  std::vector<double> numbers(const char* key) const {
    std::vector<double> values;
    each(key, [&](const Node& entry) {
      if (!entry.raw().is_number()) throw InputError(entry.place(), "not a number", entry.raw().dump());
      values.push_back(entry.raw().get<double>());
    });
    return values;
  }

  std::vector<std::string> texts(const char* key) const {
    std::vector<std::string> values;
    each(key, [&](const Node& entry) {
      if (!entry.raw().is_string()) throw InputError(entry.place(), "not a text", entry.raw().dump());
      values.push_back(entry.raw().get<std::string>());
    });
    return values;
  }

 private:
  [[noreturn]] void fail(const char* key, const char* problem, const nlohmann::json& value) const {
    throw InputError(place_ + "." + key, problem,
                     value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).substr(0, 60));
  }

  const nlohmann::json& value_;
  std::string place_;
};

}  // namespace klang::reports::detail
