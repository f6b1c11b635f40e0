#pragma once
#include <string_view>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"

namespace klang::damping {

/// A law with its numbers.
struct LawValue {
  const DampingLaw* law = nullptr;
  std::vector<double> parameters;
};

/// The keys of a table { model = "rayleigh", its parameters }.
std::vector<TomlField> damping_fields(std::string_view table);

/// Reads such a table. @throws InputError for an unknown law, and for parameters of another
LawValue read_damping(const TomlTable& table);

}  // namespace klang::damping
