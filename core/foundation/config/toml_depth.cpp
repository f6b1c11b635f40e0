#include "core/foundation/config/toml_depth.hpp"

namespace klang {
namespace {

/// The end of a text that starts at `at` with a quote; the end of the document where it does not end.
std::size_t end_of_text(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const bool escapes = quote == '"';
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  if (text.substr(at, 3) == three) {
    for (std::size_t i = at + 3; i < text.size(); ++i) {
      if (escapes && text[i] == '\\')
        ++i;
      else if (text.substr(i, 3) == three)
        return i + 3;
    }
    return text.size();
  }
  for (std::size_t i = at + 1; i < text.size(); ++i) {
    if (escapes && text[i] == '\\')
      ++i;
    else if (text[i] == quote || text[i] == '\n')
      return i + 1;
  }
  return text.size();
}

}  // namespace

bool toml_keys_too_deep(std::string_view text) {
  int n_dots = 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_text(text, at);
      continue;
    }
    if (c == '#') {
      while (at < text.size() && text[at] != '\n') ++at;
      continue;
    }
    if (c == '.' && ++n_dots >= kDeepestTomlKey) return true;
    if (c == '=' || c == '\n' || c == ',' || c == '[' || c == '{') n_dots = 0;
    ++at;
  }
  return false;
}

}  // namespace klang
