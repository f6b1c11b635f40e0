#pragma once
#include <array>
#include <optional>
#include <string_view>

namespace klang::solid {

/// Between what bounds pieces of a material lie at room temperature.
struct MaterialRange {
  std::array<double, 2> youngs_modulus_pa{}, poissons_ratio{}, density_kg_m3{};
  const char* source = "";
};

/// Of an engineering preset (material.hpp); empty for the others.
std::optional<MaterialRange> material_range(std::string_view preset);

}  // namespace klang::solid
