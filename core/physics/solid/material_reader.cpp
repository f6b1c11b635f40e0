#include "core/physics/solid/material_reader.hpp"

#include <limits>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/physics/solid/fitted_material.hpp"

namespace klang::solid {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::string_view kAllowedKeys =
    "preset, fit, or lame_lambda_pa with lame_mu_pa, or youngs_modulus_pa with poissons_ratio";

}  // namespace

std::vector<TomlField> material_fields(std::string_view table, std::string_view density_presence) {
  using enum TomlType;
  return {
      {table, "preset", kText, "none", -kInf, kInf,
       "a labelled material (`klang doctor` lists them); elastic constants must then be left out"},
      {table, "fit", kText, "none", -kInf, kInf,
       "fit.json of `klang fit`: the elastic constants and the density that it found; constants must then be left out"},
      {table, "lame_lambda_pa", kNumber, "with lame_mu_pa", -1e14, 1e14, "Lamé's first parameter λ", true},
      {table, "lame_mu_pa", kNumber, "with lame_lambda_pa", 0, 1e14, "Lamé's second parameter μ (shear modulus)", true},
      {table, "youngs_modulus_pa", kNumber, "with poissons_ratio", 0, 1e14, "Young's modulus E", true},
      {table, "poissons_ratio", kNumber, "with youngs_modulus_pa", -1, 0.5, "Poisson's ratio ν", true},
      {table, "density_kg_m3", kNumber, density_presence, 0, 1e6, "density ρ", true},
  };
}

MaterialInput read_material(const TomlTable& table, const std::filesystem::path& folder) {
  const auto preset = table.optional_text("preset");
  const auto lambda = table.optional_number("lame_lambda_pa"), mu = table.optional_number("lame_mu_pa");
  const auto young = table.optional_number("youngs_modulus_pa"), poisson = table.optional_number("poissons_ratio");
  const auto density = table.optional_number("density_kg_m3");
  const auto fit = table.optional_text("fit");
  const bool lame = lambda || mu, engineering = young || poisson;
  if (int(preset.has_value()) + int(fit.has_value()) + int(lame) + int(engineering) != 1) {
    const char* problem = preset || fit || lame || engineering ? "says the elasticity twice" : "says no elasticity";
    const char* key = fit ? "fit" : preset ? "preset" : lame ? "lame_mu_pa" : "youngs_modulus_pa";
    throw InputError(table.place(key), problem, "", kAllowedKeys);
  }
  if (lame && !(lambda && mu))
    throw InputError(table.place(lambda ? "lame_lambda_pa" : "lame_mu_pa"), "stands alone", "", kAllowedKeys);
  if (engineering && !(young && poisson))
    throw InputError(table.place(young ? "youngs_modulus_pa" : "poissons_ratio"), "stands alone", "", kAllowedKeys);
  MaterialInput input;
  Material& material = input.material;
  if (preset) {
    material = located(table.place("preset"), [&] { return material_preset(*preset); });
  } else if (fit) {
    const std::filesystem::path path = existing_file(*fit, table.place("fit"), folder);
    input.files.push_back(path);
    material =
        located(table.place("fit"), [&] { return fitted_material(read_fit_json(path), path, density.value_or(0.0)); });
  } else if (lame) {
    material.lame_lambda_pa = *lambda;
    material.lame_mu_pa = *mu;
  } else {
    material = located(table.place("poissons_ratio"),
                       [&] { return from_youngs_modulus(*young, *poisson, density.value_or(1000.0)); });
  }
  input.density_given = density || preset || fit;
  input.density_named = density.has_value();
  if (density) material.density_kg_m3 = *density;
  if (!input.density_given) material.density_kg_m3 = 0.0;
  Material trial = material;
  if (!input.density_given) trial.density_kg_m3 = 1000.0;
  located(table.place(lame     ? "lame_lambda_pa"
                      : fit    ? "fit"
                      : preset ? "preset"
                               : "poissons_ratio"),
          [&] { validate(trial); });
  return input;
}

}  // namespace klang::solid
