#include "core/physics/solid/material.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/physics/solid/material_range.hpp"

namespace klang::solid {
namespace {

struct Preset {
  const char* name;
  double lame_lambda_pa;
  double lame_mu_pa;
  double density_kg_m3;
  const char* source;
};

constexpr const char* kTableSource = "O'Brien, Shen, Gatchalian 2002, Table 1 (as printed, no physical truth)";

constexpr Preset kS02Presets[] = {
    {"s02_chime", 4.98e10, 2.57e10, 2700, kTableSource},
    {"s02_bowl_1", 4.98e9, 2.57e9, 2700, kTableSource},
    {"s02_bowl_2", 5.00e8, 1.00e8, 750, kTableSource},
    {"s02_bunny_ceramic", 3.99e9, 2.05e9, 2700, kTableSource},
    {"s02_plastic_shelf", 2.49e10, 1.28e10, 2700, kTableSource},
    {"s02_aluminum_shelf", 4.98e10, 2.56e10, 2700, kTableSource},
    {"s02_wood_shelf", 5.00e8, 1.00e8, 750, kTableSource},
    {"s02_bunny_metal", 4.99e10, 2.56e10, 2700, kTableSource},
    {"s02_blocks", 5.00e8, 1.00e8, 550, kTableSource},
    {"s02_the_end", 1.49e9, 7.70e8, 2700, kTableSource},
};

struct EngineeringPreset {
  const char* name;
  double youngs_modulus_pa;
  double poissons_ratio;
  double density_kg_m3;
  std::array<double, 2> young_gpa, poisson, density;  // between which its alloys, glasses or grades lie
};

// Room-temperature values for the isotropic solid; a real alloy or glass differs by some per cent.
constexpr const char* kHandbookSource = "typical handbook value at 20 C; real pieces differ by some per cent";
constexpr const char* kRangeSource =
    "Ashby 2011, Materials Selection in Mechanical Design, appendix A, and ASM Handbook vol. 2; steels, brass and "
    "glasses "
    "of every usual grade, dynamic moduli at 20 C";
constexpr EngineeringPreset kEngineeringPresets[] = {
    {"aluminium", 69e9, 0.33, 2700, {66, 75}, {0.32, 0.36}, {2600, 2850}},
    {"brass", 104e9, 0.34, 8500, {95, 117}, {0.31, 0.37}, {8300, 8800}},
    {"bronze", 110e9, 0.34, 8800, {95, 125}, {0.31, 0.37}, {7400, 8950}},
    {"copper", 124e9, 0.34, 8960, {114, 135}, {0.32, 0.37}, {8850, 9000}},
    {"steel", 210e9, 0.29, 7850, {196, 217}, {0.27, 0.30}, {7700, 8000}},
    {"stainless_steel", 193e9, 0.29, 8000, {186, 212}, {0.26, 0.31}, {7600, 8100}},
    {"titanium", 114e9, 0.34, 4430, {100, 122}, {0.30, 0.37}, {4350, 4850}},
    {"soda_lime_glass", 72e9, 0.22, 2500, {66, 76}, {0.19, 0.25}, {2420, 2580}},
    {"borosilicate_glass", 63e9, 0.20, 2230, {60, 67}, {0.17, 0.22}, {2180, 2320}},
    {"porcelain", 72e9, 0.19, 2700, {50, 90}, {0.15, 0.26}, {2200, 2850}},
    {"pmma", 3.2e9, 0.37, 1190, {2.2, 6.5}, {0.32, 0.42}, {1150, 1220}},
};

}  // namespace

double Material::youngs_modulus_pa() const {
  return lame_mu_pa * (3 * lame_lambda_pa + 2 * lame_mu_pa) / (lame_lambda_pa + lame_mu_pa);
}
double Material::poissons_ratio() const { return lame_lambda_pa / (2 * (lame_lambda_pa + lame_mu_pa)); }
double Material::bulk_modulus_pa() const { return lame_lambda_pa + 2 * lame_mu_pa / 3; }
double Material::shear_speed_m_s() const { return std::sqrt(lame_mu_pa / density_kg_m3); }

Material from_youngs_modulus(double youngs_modulus_pa, double poissons_ratio, double density_kg_m3) {
  const char* place = "material";
  checked_open(place, "youngs_modulus_pa", youngs_modulus_pa, 0, HUGE_VAL);
  checked_open(place, "poissons_ratio", poissons_ratio, -1, 0.5);
  checked_open(place, "density_kg_m3", density_kg_m3, 0, HUGE_VAL);
  Material material;
  material.lame_lambda_pa = youngs_modulus_pa * poissons_ratio / ((1 + poissons_ratio) * (1 - 2 * poissons_ratio));
  material.lame_mu_pa = youngs_modulus_pa / (2 * (1 + poissons_ratio));
  material.density_kg_m3 = density_kg_m3;
  validate(material);
  return material;
}

void validate(const Material& material) {
  const char* place = "material";
  checked_open(place, "lame_mu_pa", material.lame_mu_pa, 0, HUGE_VAL);
  checked_open(place, "lame_lambda_pa", material.lame_lambda_pa, -HUGE_VAL, HUGE_VAL);
  if (!(material.bulk_modulus_pa() > 0)) {
    throw InputError(place, "lame_lambda_pa + 2/3 lame_mu_pa (the bulk modulus) must be positive",
                     klang::to_text(material.bulk_modulus_pa()), "> 0");
  }
  checked_open(place, "density_kg_m3", material.density_kg_m3, 0, HUGE_VAL);
}

Material material_preset(std::string_view name) {
  for (const auto& preset : kEngineeringPresets) {
    if (name != preset.name) continue;
    Material material = from_youngs_modulus(preset.youngs_modulus_pa, preset.poissons_ratio, preset.density_kg_m3);
    material.name = preset.name;
    material.source = kHandbookSource;
    return material;
  }
  for (const auto& preset : kS02Presets) {
    if (name != preset.name) continue;
    return {preset.lame_lambda_pa, preset.lame_mu_pa, preset.density_kg_m3, preset.name, preset.source};
  }
  throw unknown_word("material", "unknown preset", name, name, material_preset_names());
}

std::optional<MaterialRange> material_range(std::string_view name) {
  for (const auto& preset : kEngineeringPresets) {
    if (name == preset.name)
      return MaterialRange{
          {1e9 * preset.young_gpa[0], 1e9 * preset.young_gpa[1]}, preset.poisson, preset.density, kRangeSource};
  }
  return std::nullopt;
}

std::vector<std::string> material_preset_names() {
  std::vector<std::string> names;
  for (const auto& preset : kEngineeringPresets) names.emplace_back(preset.name);
  for (const auto& preset : kS02Presets) names.emplace_back(preset.name);
  return names;
}

}  // namespace klang::solid
