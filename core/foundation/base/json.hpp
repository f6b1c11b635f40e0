#pragma once
#include <nlohmann/json.hpp>
#include <optional>

namespace klang {

/// The number, or null where it was not measured or is not finite (JSON has no NaN).
nlohmann::json json_number(double value);
nlohmann::json json_number(const std::optional<double>& value);

/// Two-space indent, a line break at the end; keys in alphabetical order.
std::string json_text(const nlohmann::json& value);

}  // namespace klang
