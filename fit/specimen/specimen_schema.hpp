#pragma once
#include <string>
#include <vector>

#include "core/foundation/config/toml_table.hpp"

namespace klang::fit {

/// The keys of specimen.toml: drive the reader's checks, its messages and docs/specimen.md.
const std::vector<TomlField>& specimen_schema();

/// Names a fit accepts beside dimensions "SPECIMEN.length_m".
const std::vector<std::string>& material_parameter_names();

}  // namespace klang::fit
