#pragma once
#include <filesystem>
#include <string_view>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::solid {

/// A [material] table: a preset, a fit, or lame_lambda_pa with lame_mu_pa, or youngs_modulus_pa with poissons_ratio.
struct MaterialInput {
  Material material;                         ///< density 0 where none is given
  bool density_given = false;                ///< by density_kg_m3, the preset or the fit
  bool density_named = false;                ///< by density_kg_m3
  std::vector<std::filesystem::path> files;  ///< that were read
};

/// The keys of such a table.
/// @param density_presence  what stands for the density where it is left out; lives as long as the program
std::vector<TomlField> material_fields(std::string_view table, std::string_view density_presence);

/// @param folder  that a file's name is relative to
/// @throws InputError
MaterialInput read_material(const TomlTable& table, const std::filesystem::path& folder);

}  // namespace klang::solid
