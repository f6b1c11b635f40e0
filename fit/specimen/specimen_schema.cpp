#include "fit/specimen/specimen_schema.hpp"

#include <limits>

#include "core/geometry/shapes/shape_reader.hpp"
#include "core/physics/solid/material_reader.hpp"
#include "core/physics/solid/support_reader.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMaxLength = 1e3;  // metres: nothing longer is struck and recorded

using enum TomlType;

template <class... Lists>
std::vector<TomlField> joined(std::vector<TomlField> first, const Lists&... rest) {
  (first.insert(first.end(), rest.begin(), rest.end()), ...);
  return first;
}

const std::vector<TomlField>& top_fields() {
  static const std::vector<TomlField> fields = {
      {"", "name", kText, "the file's name", -kInf, kInf, "title of the problem"},
      {"", "material", kTable, "required", -kInf, kInf, "starting guess of the material"},
      {"", "specimen", kTables, "required", -kInf, kInf, "one `[[specimen]]` a body, 1 or more"},
      {"", "fit", kTable, "the defaults below", -kInf, kInf, "what to fit"},
  };
  return fields;
}

const std::vector<TomlField>& body_fields() {
  static const std::vector<TomlField> fields = {
      {"specimen", "name", kText, "`specimen-1`, ...", -kInf, kInf,
       "short and unique; becomes part of file names and of parameter names"},
      {"specimen", "shape", kTable, "required unless mesh is given", -kInf, kInf, "an analytic body"},
      {"specimen", "mesh", kText, "required unless shape is given", -kInf, kInf,
       "a mesh file: a closed surface or tetrahedra"},
      {"specimen", "unit_m", kNumber, "1", 0, 1e3, "length of the mesh file's unit in metres: 0.001 for millimetres",
       true},
      {"specimen", "mass_kg", kNumber, "none", 0, 1e6, "mass; gives the density by the body's volume", true},
      {"specimen", "tolerance", kTable, "none", -kInf, kInf,
       "how far what is given may be off, as standard deviations by name: `{ height_m = 2e-5, mass_kg = 1e-4 }`; "
       "enters the "
       "intervals of E, G and ν"},
      {"specimen", "support", kTable, "free", -kInf, kInf,
       "how the body is held: a table, or the command line's text form (`\"clamped:x=0\"`)"},
      {"specimen", "recording", kText, "none", -kInf, kInf, "one sound file (or recordings, or partials)"},
      {"specimen", "recordings", kTexts, "none", -kInf, kInf, "sound files of the same body"},
      {"specimen", "partials", kText, "none", -kInf, kInf,
       "table of partials (CSV or JSON), or measured responses (.uff, .unv, .mat: their poles), instead of recordings"},
      {"specimen", "strike_m", kNumbers, "none", -kMaxLength, kMaxLength,
       "x, y, z of the strike; the nearest surface node is taken", true, 3},
      {"specimen", "microphone_m", kNumbers, "none", -kMaxLength, kMaxLength, "x, y, z of the microphone", true, 3},
      {"specimen", "predict", kBoolean, "`false`", -kInf, kInf,
       "take no part in the fit: partials are predicted from the others' material and held against the recording"},
      {"specimen", "mount", kTables, "none", -kInf, kInf,
       "places where wire or foam touches the body: viscous dampers, of one coefficient that is fitted with the "
       "damping"},
  };
  return fields;
}

const std::vector<TomlField>& fit_fields() {
  static const std::vector<TomlField> fields = {
      {"specimen.mount", "at_m", kNumbers, "required", -kMaxLength, kMaxLength,
       "x, y, z of the place; the nearest point of the surface is taken", true, 3},
      {"specimen.mount", "direction", kNumbers, "all directions", -kInf, kInf,
       "the damper acts along this direction alone (a foam pad: its normal), any length", true, 3},

      {"fit", "parameters", kTexts,
       "`[\"lame_lambda_pa\", \"lame_mu_pa\", \"rayleigh_stiffness_s\", \"rayleigh_mass_per_s\"]`", -kInf, kInf,
       "what is free: at most two elastic constants (any of the five names), `density_kg_m3`, the two Rayleigh "
       "numbers, and dimensions such as `D3.length_m`"},
      {"fit", "radiation_damping", kBoolean, "`false`", -kInf, kInf,
       "compute how much of each matched mode's damping is sound that it radiates into the air (boundary elements), "
       "and rank "
       "the damping models with and without it"},
      {"fit", "band_hz", kNumbers, "`[20, 20000]`", 0, 1e6, "lowest and highest frequency that is looked at", true, 2},
      {"fit", "priors", kTable, "none", -kInf, kInf,
       "what is known beforehand, a table by parameter name: `youngs_modulus_pa = { mean = 70e9, std = 2e9 }`; "
       "quote names that hold a point: `\"D3.length_m\"`"},
      {"fit.priors.*", "mean", kNumber, "required", -1e15, 1e15, "expected value", true},
      {"fit.priors.*", "std", kNumber, "required", 0, 1e15, "its standard deviation", true},
  };
  return fields;
}

/// The keys of a shape, whose dimensions may bring their standard deviation.
std::vector<TomlField> shape_fields_with_std() {
  std::vector<TomlField> fields = mesh::shape_fields("specimen.shape");
  for (TomlField& field : fields) field.with_std = field.type == kNumber;
  return fields;
}

/// The numbers of a shape, mass and density under the same names.
std::vector<TomlField> tolerance_fields() {
  std::vector<TomlField> fields;
  for (TomlField field : mesh::shape_fields("specimen.tolerance")) {
    if (field.type != kNumber) continue;
    field.presence = "exact";
    field.meaning = "standard deviation of this dimension";
    fields.push_back(field);
  }
  fields.push_back({"specimen.tolerance", "mass_kg", kNumber, "exact", 0, 1e6, "standard deviation of the mass", true});
  fields.push_back({"specimen.tolerance", "density_kg_m3", kNumber, "exact", 0, 1e6,
                    "standard deviation of the density, where no mass is given; one error for all specimens", true});
  return fields;
}

}  // namespace

const std::vector<TomlField>& specimen_schema() {
  static const std::vector<TomlField> schema = [] {
    std::vector<TomlField> fields =
        joined(top_fields(), solid::material_fields("material", "the preset's, or from mass_kg"), body_fields(),
               shape_fields_with_std(), tolerance_fields(), solid::support_fields("specimen.support"), fit_fields());
    for (TomlField& field : fields)
      field.with_std = field.with_std || (field.table == "specimen" && field.key == "mass_kg");
    return fields;
  }();
  return schema;
}

const std::vector<std::string>& material_parameter_names() {
  static const std::vector<std::string> names = {"lame_lambda_pa",       "lame_mu_pa",         "shear_modulus_pa",
                                                 "youngs_modulus_pa",    "poissons_ratio",     "density_kg_m3",
                                                 "rayleigh_stiffness_s", "rayleigh_mass_per_s"};
  return names;
}

std::string specimen_schema_markdown() {
  std::string text =
      "# `specimen.toml`\n\n"
      "Generated from the table in `fit/specimen/specimen_schema.cpp`; a test keeps the two equal. Unknown keys are "
      "errors.\n"
      "Paths are relative to the file's folder. Numbers are in the unit that their name ends with.\n";
  text += toml_schema_markdown(specimen_schema());
  text +=
      "\n## Rules\n"
      "- `material`: a preset, the `fit.json` of an earlier fit, or `lame_lambda_pa` with `lame_mu_pa`, or "
      "`youngs_modulus_pa` with `poissons_ratio`.\n"
      "- Density: `density_kg_m3` or the preset's or the fit's; a specimen with `mass_kg` uses its mass instead. An "
      "explicit\n"
      "  `density_kg_m3` together with a `mass_kg` is an error.\n"
      "- A specimen has a `shape` or a `mesh`, not both; `recording`, `recordings` or `partials`, not two of them.\n"
      "- A prior needs its parameter among `parameters`, or is one of the elastic constants.\n"
      "- A dimension is fitted by the name `SPECIMEN.dimension`, e.g. `D3.length_m`.\n";
  return text;
}

}  // namespace klang::fit
