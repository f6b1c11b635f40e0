#pragma once
#include <string_view>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::solid {

/// A [material] table: a preset, or lame_lambda_pa with lame_mu_pa, or youngs_modulus_pa with poissons_ratio.
struct MaterialInput {
  Material material;           ///< density 0 where none is given
  bool density_given = false;  ///< by density_kg_m3 or the preset
  bool density_named = false;  ///< by density_kg_m3
};

/// The keys of such a table.
/// @param density_presence  what stands for the density where it is left out; lives as long as the program
std::vector<TomlField> material_fields(std::string_view table, std::string_view density_presence);

/// @throws InputError
MaterialInput read_material(const TomlTable& table);

}  // namespace klang::solid
