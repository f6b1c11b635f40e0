#include "core/foundation/base/parse_json.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"

namespace klang {
namespace {

/// Depth of brackets outside of texts.
int deepest(std::string_view text) {
  int depth = 0, most = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_text) {
      if (c == '\\')
        ++i;
      else if (c == '"')
        in_text = false;
    } else if (c == '"') {
      in_text = true;
    } else if (c == '[' || c == '{') {
      most = std::max(most, ++depth);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return most;
}

}  // namespace

nlohmann::json parse_json(std::string_view text, const std::string& place) {
  if (const int depth = deepest(text); depth > kDeepestJson)
    throw InputError(place, "its lists and objects are nested too deep", std::to_string(depth) + " levels",
                     "up to " + std::to_string(kDeepestJson));
  nlohmann::json document = nlohmann::json::parse(text, nullptr, false);
  if (document.is_discarded()) throw InputError(place, "is not JSON, or cut short");
  return document;
}

std::string text_under(const nlohmann::json& object, std::string_view key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace klang
