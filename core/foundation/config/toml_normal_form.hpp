#pragma once
#include <span>
#include <string>
#include <string_view>

namespace klang {

/// What stands under these keys of a TOML text, without comments and in the keys' order: the same for texts that say the same there. Empty for
/// a text that is no TOML.
std::string toml_normal_form(std::string_view text, std::span<const std::string_view> keys);

}  // namespace klang
