#pragma once
#include <string_view>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::solid {

/// The keys of a support's table.
std::vector<TomlField> support_fields(std::string_view table);

/// The support that a body's table names under "support": a table { kind, where } or the text form ("clamped:x=0"); free where
/// there is none. @throws InputError
Support read_support(const TomlTable& body);

}  // namespace klang::solid
