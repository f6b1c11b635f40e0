#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace klang {

/// Deeper lists and objects in each other than any file of this program has; what writes or draws a deep document recurses.
inline constexpr int kDeepestJson = 64;

/// A document that stands in a file. @throws InputError: not JSON, or deeper than kDeepestJson
nlohmann::json parse_json(std::string_view text, const std::string& place);

/// The text under a key of an object, empty where there is none or where it is no text.
std::string text_under(const nlohmann::json& object, std::string_view key);

}  // namespace klang
