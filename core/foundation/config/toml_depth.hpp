#pragma once
#include <cstddef>
#include <string_view>

namespace klang {

/// Whether a key of a TOML document ("a.b.c = 1", "[a.b.c]") has more parts than any of this program's files: each is a table in the
/// one before, and what frees or prints such a tree recurses. (toml++ limits the depth of lists and inline tables itself.)
bool toml_keys_too_deep(std::string_view text);
inline constexpr int kDeepestTomlKey = 32;

}  // namespace klang
