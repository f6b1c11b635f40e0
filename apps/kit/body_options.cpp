#include "apps/kit/body_options.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <nlohmann/json.hpp>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/physics/solid/fitted_material.hpp"

namespace klang::apps {

std::map<std::string, double> parse_assignments(const std::string& option, const std::string& text) {
  std::map<std::string, double> values;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw InputError(option, "is not a list of name=number", part, "for example length_m=0.5,wall_m=0.001");
    }
    double value = 0.0;
    const char* first = part.data() + equals + 1;
    const char* last = part.data() + part.size();
    const auto parsed = std::from_chars(first, last, value);
    if (parsed.ec != std::errc() || parsed.ptr != last) {
      throw InputError(option, "is not a number", part, "name=number");
    }
    if (!values.emplace(part.substr(0, equals), value).second) {
      throw InputError(option, "is given twice", part.substr(0, equals));
    }
    begin = end + 1;
  }
  return values;
}

bool is_fit_file(const std::string& material) { return material.ends_with(".json"); }

namespace {

/// "; did you mean NAME" where one of the given names is nearly that.
std::string given_for(const std::string& name, const std::map<std::string, double>& values) {
  for (const auto& [given, value] : values)
    if (const std::string hint = did_you_mean(given, {name}); !hint.empty()) return hint;
  return {};
}

}  // namespace

solid::Material parse_material(const std::string& text) {
  if (is_fit_file(text)) {
    const nlohmann::json fit = solid::read_fit_json(text);
    if (const auto contradiction = solid::contradiction_of(fit, text)) warn(*contradiction);
    return solid::fitted_material(fit, text);
  }
  if (text.find('=') == std::string::npos) return solid::material_preset(text);
  auto values = parse_assignments("--material", text);
  const auto take = [&](const std::string& name) {
    const auto found = values.find(name);
    if (found == values.end()) {
      throw InputError(
          "--material", "lacks " + name, text,
          "a preset, a fit.json, or lame_lambda_pa, lame_mu_pa, density_kg_m3, or youngs_modulus_pa, poissons_ratio, "
          "density_kg_m3" +
              given_for(name, values));
    }
    const double value = found->second;
    values.erase(found);
    return value;
  };
  solid::Material material;
  if (values.contains("youngs_modulus_pa") || values.contains("poissons_ratio")) {
    const double youngs_modulus_pa = take("youngs_modulus_pa");
    const double poissons_ratio = take("poissons_ratio");
    material = solid::from_youngs_modulus(youngs_modulus_pa, poissons_ratio, take("density_kg_m3"));
  } else {
    material.lame_lambda_pa = take("lame_lambda_pa");
    material.lame_mu_pa = take("lame_mu_pa");
    material.density_kg_m3 = take("density_kg_m3");
  }
  if (!values.empty()) {
    throw InputError("--material", "has an unknown or superfluous name", values.begin()->first,
                     "lame_lambda_pa, lame_mu_pa or youngs_modulus_pa, poissons_ratio; and density_kg_m3");
  }
  solid::validate(material);
  return material;
}

void BodyOptions::add_to(CLI::App& app, CommonOptions& common, bool shape_is_positional) {
  std::string kinds;
  for (const std::string& kind : mesh::shape_kinds()) kinds += (kinds.empty() ? "" : ", ") + kind;
  if (shape_is_positional) {
    app.add_option("shape-or-file", shape, "A shape (" + kinds + ") or a mesh file")->required();
  } else {
    app.add_option("--shape", shape, "One of: " + kinds);
    app.add_option("--mesh", mesh_file,
                   "Mesh file instead of a shape: tetrahedra (.vtu, .msh, .node/.ele) or a closed surface "
                   "(.stl, .obj, .ply, .off)");
  }
  app.add_option("--dims", dims, "Dimensions of the shape: name_m=value,... in metres");
  app.add_option("--profile", profile, "revolution: CSV file of the closed profile, columns r_m, z_m");
  app.add_option("--element", element, "p1 (linear) or p2 (quadratic, curved)")
      ->check(CLI::IsMember({"p1", "p2"}))
      ->capture_default_str();
  add_fields(app, common, *this, {{"max_edge_m"}, {"unit_m"}, {"max_triangles"}, {"refinement", "--refine"}});
}

std::optional<mesh::ShapeSpec> BodyOptions::shape_spec() const {
  if (!mesh_file.empty() && !shape.empty()) throw InputError("--mesh", "excludes --shape", shape);
  if (!mesh_file.empty()) {
    if (!dims.empty()) throw InputError("--dims", "belongs to --shape, not to --mesh", dims);
    return std::nullopt;
  }
  if (shape.empty()) throw InputError("body", "is not given", "", "--shape KIND --dims ... or --mesh FILE");
  mesh::ShapeSpec spec;
  spec.kind = shape;
  if (!dims.empty()) spec.dims = parse_assignments("--dims", dims);
  spec.profile_csv = profile;
  mesh::validate(spec);
  return spec;
}

mesh::TetMesh BodyOptions::build(double wavelength_m, mesh::BodyNotes* notes, Monitor& monitor) const {
  validate_fields("command line", *this);
  if (const auto spec = shape_spec()) {
    mesh::ShapeMeshOptions options;
    options.order = order();
    options.max_edge_m = max_edge_m;
    options.wavelength_m = wavelength_m;
    options.refinement = refinement;
    mesh::TetMesh mesh = mesh::mesh_shape(*spec, options);
    if (notes != nullptr)
      for (const std::string& warning : mesh::body_warnings(mesh, 1.0, {})) notes->warn("--dims: " + warning);
    return mesh;
  }
  mesh::LoadOptions options;
  options.order = order();
  options.max_edge_m = max_edge_m;
  options.wavelength_m = wavelength_m;
  options.unit_m = unit_m;
  options.max_triangles = max_triangles;
  mesh::TetMesh mesh = mesh::load_body(mesh_file, options, notes, monitor);
  if (notes != nullptr)
    for (const std::string& warning : mesh::body_warnings(mesh, unit_m, "--unit-m"))
      notes->warn(mesh_file + ": " + warning);
  return mesh;
}

mesh::TetMesh BodyOptions::build_and_tell(const CommonOptions& common, mesh::BodyNotes& notes,
                                          std::vector<std::string>& warnings, Monitor& monitor) const {
  notes.note = [&common](const std::string& text) { note(common, text); };
  notes.warning = [&warnings](const std::string& text) {
    warn(text);
    warnings.push_back(text);
  };
  return build(0.0, &notes, monitor);
}

std::vector<std::filesystem::path> BodyOptions::inputs(const std::string& material) const {
  std::vector<std::filesystem::path> files;
  if (!mesh_file.empty()) files.emplace_back(mesh_file);
  if (!profile.empty()) files.emplace_back(profile);
  if (is_fit_file(material)) files.emplace_back(material);
  return files;
}

}  // namespace klang::apps
