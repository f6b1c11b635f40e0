#include "fit/specimen/specimen_schema.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMaxLength = 1e3;  // metres: nothing longer is struck and recorded

using enum FieldType;

std::vector<SchemaField> make_schema() {
  std::vector<SchemaField> fields = {
      {"", "name", kText, "the file's name", -kInf, kInf, "title of the problem", 0},
      {"", "material", kTable, "required", -kInf, kInf, "starting guess of the material", 0},
      {"", "specimen", kTableList, "required", -kInf, kInf, "one `[[specimen]]` a body, 1 or more", 0},
      {"", "fit", kTable, "the defaults below", -kInf, kInf, "what to fit", 0},

      {"material", "preset", kText, "none", -kInf, kInf,
       "a labelled material (`klang doctor` lists them); elastic constants must then be left out", 0},
      {"material", "lame_lambda_pa", kNumber, "with lame_mu_pa", -1e14, 1e14, "Lamé's first parameter λ", 0},
      {"material", "lame_mu_pa", kNumber, "with lame_lambda_pa", 0, 1e14, "Lamé's second parameter μ (shear modulus)",
       0},
      {"material", "youngs_modulus_pa", kNumber, "with poissons_ratio", 0, 1e14, "Young's modulus E", 0},
      {"material", "poissons_ratio", kNumber, "with youngs_modulus_pa", -1, 0.5, "Poisson's ratio ν", 0},
      {"material", "density_kg_m3", kNumber, "the preset's, or from mass_kg", 0, 1e6, "density ρ", 0},

      {"specimen", "name", kText, "`specimen-1`, ...", -kInf, kInf,
       "short and unique; becomes part of file names and of parameter names", 0},
      {"specimen", "shape", kTable, "required unless mesh is given", -kInf, kInf, "an analytic body", 0},
      {"specimen", "mesh", kText, "required unless shape is given", -kInf, kInf,
       "a mesh file: a closed surface or tetrahedra, in metres", 0},
      {"specimen", "mass_kg", kNumber, "none", 0, 1e6, "mass; gives the density by the body's volume", 0},
      {"specimen", "support", kTable, "free", -kInf, kInf,
       "how the body is held: a table, or the command line's text form (`\"clamped:x=0\"`)", 0},
      {"specimen", "recording", kText, "none", -kInf, kInf, "one sound file (or recordings, or partials)", 0},
      {"specimen", "recordings", kTextList, "none", -kInf, kInf, "sound files of the same body", 0},
      {"specimen", "partials", kText, "none", -kInf, kInf,
       "table of partials (CSV or JSON) made elsewhere, instead of recordings", 0},
      {"specimen", "strike_m", kNumberList, "none", -kMaxLength, kMaxLength,
       "x, y, z of the strike; the nearest surface node is taken", 3},
      {"specimen", "microphone_m", kNumberList, "none", -kMaxLength, kMaxLength, "x, y, z of the microphone", 3},
      {"specimen", "predict", kBoolean, "`false`", -kInf, kInf,
       "take no part in the fit: partials are predicted from the others' material and held against the recording", 0},
      {"specimen", "mount", kTableList, "none", -kInf, kInf,
       "places where wire or foam touches the body: viscous dampers, of one coefficient that is fitted with the "
       "damping",
       0},

      {"specimen.shape", "kind", kText, "required", -kInf, kInf,
       "tube, rod, box, shell_box, ellipsoid, sphere, bowl or revolution", 0},
      {"specimen.shape", "profile_csv", kText, "required for a revolution", -kInf, kInf,
       "closed polygon with columns r_m, z_m", 0},

      {"specimen.support", "kind", kText, "required", -kInf, kInf, "free, clamped or pinned", 0},
      {"specimen.support", "where", kText, "required unless free", -kInf, kInf,
       "`x=0`, `z>0.1`, `box:x0,y0,z0:x1,y1,z1` or `set:NAME`", 0},

      {"specimen.mount", "at_m", kNumberList, "required", -kMaxLength, kMaxLength,
       "x, y, z of the place; the nearest point of the surface is taken", 3},
      {"specimen.mount", "direction", kNumberList, "all directions", -kInf, kInf,
       "the damper acts along this direction alone (a foam pad: its normal), any length", 3},

      {"fit", "parameters", kTextList,
       "`[\"lame_lambda_pa\", \"lame_mu_pa\", \"rayleigh_stiffness_s\", \"rayleigh_mass_per_s\"]`", -kInf, kInf,
       "what is free: at most two elastic constants (any of the five names), `density_kg_m3`, the two Rayleigh "
       "numbers, and dimensions such as `D3.length_m`",
       0},
      {"fit", "radiation_damping", kBoolean, "`false`", -kInf, kInf,
       "compute how much of each matched mode's damping is sound that it radiates into the air (boundary elements), "
       "and rank "
       "the damping models with and without it",
       0},
      {"fit", "band_hz", kNumberList, "`[20, 20000]`", 0, 1e6, "lowest and highest frequency that is looked at", 2},
      {"fit", "priors", kTable, "none", -kInf, kInf,
       "what is known beforehand, a table by parameter name: `youngs_modulus_pa = { mean = 70e9, std = 2e9 }`; "
       "quote names that hold a point: `\"D3.length_m\"`",
       0},
      {"fit.priors.*", "mean", kNumber, "required", -1e15, 1e15, "expected value", 0},
      {"fit.priors.*", "std", kNumber, "required", 0, 1e15, "its standard deviation", 0},
  };
  return fields;
}

std::vector<SchemaField> dimension_fields() {
  std::vector<SchemaField> fields;
  for (const std::string& kind : mesh::shape_kinds()) {
    for (const std::string& name : mesh::shape_dimensions(kind)) {
      // shape_dimensions returns a reference to a table that lives as long as the program.
      const auto same = [&](const SchemaField& field) { return field.key == name; };
      if (std::none_of(fields.begin(), fields.end(), same)) {
        fields.push_back({"specimen.shape", name, kNumber, "by kind", 0, kMaxLength, "", 0});
      }
    }
  }
  return fields;
}

std::string kinds_with(std::string_view dimension) {
  std::string text;
  for (const std::string& kind : mesh::shape_kinds()) {
    for (const std::string& name : mesh::shape_dimensions(kind)) {
      if (name == dimension) text += (text.empty() ? "" : ", ") + kind;
    }
  }
  return text;
}

}  // namespace

const std::vector<SchemaField>& specimen_schema() {
  static const std::vector<SchemaField> schema = [] {
    auto fields = make_schema();
    const auto after_kind = std::find_if(fields.begin(), fields.end(), [](const SchemaField& field) {
      return field.table == "specimen.shape" && field.key == "profile_csv";
    });
    const auto dimensions = dimension_fields();
    fields.insert(after_kind, dimensions.begin(), dimensions.end());
    return fields;
  }();
  return schema;
}

const SchemaField* find_field(std::string_view table, std::string_view key) {
  for (const SchemaField& field : specimen_schema()) {
    if (field.table == table && field.key == key) return &field;
  }
  return nullptr;
}

std::string_view type_text(FieldType type) {
  switch (type) {
    case kText:
      return "text";
    case kNumber:
      return "number";
    case kBoolean:
      return "true or false";
    case kTextList:
      return "list of texts";
    case kNumberList:
      return "list of numbers";
    case kTable:
      return "table";
    case kTableList:
      return "list of tables";
  }
  return "";
}

std::string range_text(const SchemaField& field) {
  std::string text;
  if (std::isfinite(field.low)) text = "above " + to_text(field.low);
  if (std::isfinite(field.high)) text += (text.empty() ? "below " : ", below ") + to_text(field.high);
  return text;
}

std::string known_keys(std::string_view table) {
  std::string text;
  for (const SchemaField& field : specimen_schema()) {
    if (field.table == table) text.append(text.empty() ? "" : ", ").append(field.key);
  }
  return text;
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
  std::string_view table = "?";
  for (const SchemaField& field : specimen_schema()) {
    if (field.table != table) {
      table = field.table;
      text += "\n## ";
      text += table.empty() ? "top level" : "`" + std::string(table) + "`";
      text += "\n| key | type | range | default | meaning |\n| --- | --- | --- | --- | --- |\n";
    }
    const std::string meaning =
        field.meaning.empty() ? "dimension of: " + kinds_with(field.key) : std::string(field.meaning);
    std::string type(type_text(field.type));
    if (field.list_length > 0) type += " (" + std::to_string(field.list_length) + ")";
    text.append("| `").append(field.key).append("` | ").append(type).append(" | ").append(range_text(field));
    text.append(" | ").append(field.presence).append(" | ").append(meaning).append(" |\n");
  }
  text +=
      "\n## Rules\n"
      "- `material`: a preset, or `lame_lambda_pa` with `lame_mu_pa`, or `youngs_modulus_pa` with `poissons_ratio`.\n"
      "- Density: `density_kg_m3` or the preset's; a specimen with `mass_kg` uses its mass instead. An explicit\n"
      "  `density_kg_m3` together with a `mass_kg` is an error.\n"
      "- A specimen has a `shape` or a `mesh`, not both; `recording`, `recordings` or `partials`, not two of them.\n"
      "- A prior needs its parameter among `parameters`, or is one of the elastic constants.\n"
      "- A dimension is fitted by the name `SPECIMEN.dimension`, e.g. `D3.length_m`.\n";
  return text;
}

}  // namespace klang::fit
