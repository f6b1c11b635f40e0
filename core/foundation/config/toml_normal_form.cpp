#include "core/foundation/config/toml_normal_form.hpp"

#include <toml++/toml.h>

#include <sstream>

namespace klang {

std::string toml_normal_form(std::string_view text, std::span<const std::string_view> keys) {
  try {
    const toml::table root = toml::parse(text);
    toml::table part;
    for (const std::string_view key : keys)
      if (const toml::node* node = root.get(key)) part.insert(key, *node);
    std::ostringstream out;
    out << part;
    return out.str();
  } catch (const toml::parse_error&) {
    return "";
  }
}

}  // namespace klang
