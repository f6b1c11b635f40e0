#include "fit/specimen/specimen.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/shapes/shape_reader.hpp"
#include "core/physics/solid/material_reader.hpp"
#include "core/physics/solid/support_reader.hpp"
#include "fit/specimen/specimen_schema.hpp"

namespace klang::fit {
namespace {

constexpr std::size_t kMaxSpecimens = 1000, kMaxMounts = 1000;
constexpr std::size_t kMaxTomlBytes = 1 << 20;

void check_name(const TomlTable& table, const std::string& name) {
  const bool fits = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c >= 0x80 || std::isalnum(c) || c == '_' || c == '-' || c == '+' || c == '#' || c == ' ';
  });
  if (!fits || name.front() == ' ' || name.back() == ' ') {
    throw InputError(table.place("name"), "cannot be part of a file name", name,
                     "1 to 64 letters, digits, spaces and _ - + #");
  }
}

std::array<double, 3> point(const TomlTable& table, std::string_view key) {
  const std::vector<double> values = table.numbers(key);
  return {values[0], values[1], values[2]};
}

std::filesystem::path named_file(const TomlTable& table, std::string_view key, const std::filesystem::path& folder) {
  return existing_file(table.text(key), table.place(key), folder);
}

void read_body(const TomlTable& table, const std::filesystem::path& folder, Specimen& specimen) {
  if (table.has("shape") && table.has("mesh"))
    throw InputError(table.place("mesh"), "shape and mesh are both given", "", "one of them");
  if (table.has("shape")) {
    specimen.shape = mesh::read_shape(table.table("shape"), folder);
  } else if (table.has("mesh")) {
    specimen.mesh_file = named_file(table, "mesh", folder);
    specimen.unit_m = table.optional_number("unit_m").value_or(1.0);
  } else {
    throw InputError(table.place("shape"), "neither shape nor mesh is given", "", "one of them");
  }
  if (table.has("unit_m") && !specimen.mesh_file)
    throw InputError(table.place("unit_m"), "has no meaning without a mesh", "", "shapes are in metres");
  specimen.mass_kg = table.optional_number("mass_kg");
  specimen.support = solid::read_support(table);
}

/// length_m = { value = 0.25, std = 2e-5 } beside the table of tolerances.
void add_tolerance(const TomlTable& table, std::string_view key, Specimen& specimen) {
  const std::optional<double> std = table.standard_deviation(key);
  if (!std) return;
  if (!specimen.tolerance.emplace(key, *std).second)
    throw InputError(table.place(key), "its standard deviation is given twice", "", "here or in tolerance");
}

void read_tolerances(const TomlTable& table, Specimen& specimen) {
  if (!table.has("tolerance")) return;
  const TomlTable tolerance = table.table("tolerance");
  std::vector<std::string> names = {specimen.mass_kg ? "mass_kg" : "density_kg_m3"};
  if (specimen.shape) {
    for (const auto& [name, value] : specimen.shape->dims) names.push_back(name);
  }
  std::string allowed;
  for (const std::string& name : names) {
    allowed += (allowed.empty() ? "" : ", ") + name;
    if (const auto value = tolerance.optional_number(name)) specimen.tolerance[name] = *value;
  }
  for (const TomlField& field : specimen_schema()) {
    if (field.table != "specimen.tolerance" || specimen.tolerance.count(std::string(field.key))) continue;
    if (tolerance.has(field.key))
      throw InputError(tolerance.place(field.key), "is not given for this specimen", "", allowed);
  }
}

void read_sources(const TomlTable& table, const std::filesystem::path& folder, Specimen& specimen) {
  const int n_sources = int(table.has("recording")) + int(table.has("recordings")) + int(table.has("partials"));
  if (n_sources > 1) {
    throw InputError(table.place(table.has("partials") ? "partials" : "recordings"),
                     "the data are given more than once", "", "one of recording, recordings, partials");
  }
  if (table.has("recording")) specimen.recordings.push_back(named_file(table, "recording", folder));
  if (table.has("recordings")) {
    for (const std::string& path : table.texts("recordings"))
      specimen.recordings.push_back(existing_file(path, table.place("recordings"), folder));
    if (specimen.recordings.empty()) throw InputError(table.place("recordings"), "is an empty list");
  }
  if (table.has("partials")) specimen.partials = named_file(table, "partials", folder);
}

Specimen read_specimen(const TomlTable& table, std::size_t number, const std::filesystem::path& folder) {
  Specimen specimen;
  specimen.name = table.optional_text("name").value_or("specimen-" + std::to_string(number));
  check_name(table, specimen.name);
  read_body(table, folder, specimen);
  read_tolerances(table, specimen);
  if (specimen.mass_kg) add_tolerance(table, "mass_kg", specimen);
  if (specimen.shape) {
    const TomlTable shape = table.table("shape");
    for (const auto& [name, value] : specimen.shape->dims) add_tolerance(shape, name, specimen);
  }
  read_sources(table, folder, specimen);
  if (table.has("strike_m")) specimen.strike_m = point(table, "strike_m");
  if (table.has("microphone_m")) specimen.microphone_m = point(table, "microphone_m");
  for (const TomlTable& mount : table.tables("mount", kMaxMounts)) {
    specimen.mounts.push_back({point(mount, "at_m"), std::nullopt});
    if (!mount.has("direction")) continue;
    specimen.mounts.back().direction = point(mount, "direction");
    if (*specimen.mounts.back().direction == std::array<double, 3>{})
      throw InputError(mount.place("direction"), "is zero");
  }
  specimen.predict = table.boolean("predict", false);
  return specimen;
}

bool is_elastic(const std::string& name) {
  return name == "lame_lambda_pa" || name == "lame_mu_pa" || name == "shear_modulus_pa" ||
         name == "youngs_modulus_pa" || name == "poissons_ratio";
}

/// Empty when the name is a parameter of this problem, otherwise what is wrong.
std::string name_problem(const FitProblem& problem, const std::string& name) {
  const auto& names = material_parameter_names();
  if (std::find(names.begin(), names.end(), name) != names.end()) return {};
  const auto dot = name.rfind('.');
  if (dot == std::string::npos) return "unknown parameter";
  for (const Specimen& specimen : problem.specimens) {
    if (specimen.name != name.substr(0, dot)) continue;
    if (!specimen.shape) return "a mesh file has no dimensions to fit";
    return specimen.shape->dims.count(name.substr(dot + 1)) ? "" : "unknown dimension";
  }
  return "unknown specimen";
}

InputError unknown_name(const std::string& place, const std::string& problem, const std::string& name) {
  const auto& names = material_parameter_names();
  return InputError(InputError(place, problem, name, word_list(names) + ", SPECIMEN.DIMENSION").what() +
                    did_you_mean(name, names));
}

void read_priors(const TomlTable& fit, FitProblem& problem) {
  for (const auto& [name, prior] : fit.named_tables("priors")) {
    if (const auto wrong = name_problem(problem, name); !wrong.empty()) throw unknown_name(prior.place(), wrong, name);
    const auto& asked = problem.parameters;
    if (!is_elastic(name) && std::find(asked.begin(), asked.end(), name) == asked.end())
      throw InputError(prior.place(), "prior of a parameter that is not fitted", name);
    problem.priors[name] = {prior.number("mean"), prior.number("std")};
  }
}

void check_parameters(const TomlTable& fit, const FitProblem& problem) {
  const std::string place = fit.place("parameters");
  std::set<std::string> seen;
  int n_elastic = 0;
  for (const std::string& name : problem.parameters) {
    if (const auto wrong = name_problem(problem, name); !wrong.empty()) throw unknown_name(place, wrong, name);
    const bool is_new = seen.insert(name == "shear_modulus_pa" ? "lame_mu_pa" : name).second;
    if (!is_new) throw InputError(place, "parameter named twice", name);
    n_elastic += is_elastic(name) ? 1 : 0;
  }
  if (n_elastic > 2)
    throw InputError(place, "an isotropic solid has two elastic constants", std::to_string(n_elastic), "at most 2");
  if (seen.count("density_kg_m3")) {
    const bool used = std::any_of(problem.specimens.begin(), problem.specimens.end(),
                                  [](const Specimen& specimen) { return !specimen.mass_kg; });
    if (!used) throw InputError(place, "density_kg_m3 is given by the masses and cannot be fitted");
  }
}

void read_fit(const TomlTable& fit, FitProblem& problem) {
  if (fit.has("parameters")) {
    problem.parameters = fit.texts("parameters");
    if (problem.parameters.empty()) throw InputError(fit.place("parameters"), "is an empty list");
  }
  check_parameters(fit, problem);
  if (fit.has("band_hz")) {
    const auto band = fit.numbers("band_hz");
    if (!(band[0] < band[1]))
      throw InputError(fit.place("band_hz"), "must rise", to_text(band[0]) + ", " + to_text(band[1]));
    problem.band = {band[0], band[1]};
  }
  problem.radiation_damping = fit.boolean("radiation_damping", false);
  read_priors(fit, problem);
}

/// A tolerance is of what is given: a fitted number has its prior.
void check_tolerances(const FitProblem& problem, const std::string& place) {
  for (const Specimen& specimen : problem.specimens) {
    for (const auto& [name, value] : specimen.tolerance) {
      const std::string parameter = name == "density_kg_m3" ? name : specimen.name + "." + name;
      if (std::count(problem.parameters.begin(), problem.parameters.end(), parameter))
        throw InputError(place, "tolerance of a fitted number", parameter, "a prior under [fit.priors]");
    }
  }
}

void read_specimens(const TomlTable& top, const solid::MaterialInput& material, const std::filesystem::path& folder,
                    FitProblem& problem) {
  std::set<std::string> names;
  for (const TomlTable& table : top.tables("specimen", 1, kMaxSpecimens)) {
    const Specimen specimen = read_specimen(table, problem.specimens.size() + 1, folder);
    const std::string place = table.place();
    if (!names.insert(specimen.name).second) throw InputError(place + ".name", "is used twice", specimen.name);
    if (specimen.mass_kg && material.density_named) {
      throw InputError(place + ".mass_kg", "mass and density_kg_m3 are both given", to_text(*specimen.mass_kg),
                       "one of them");
    }
    if (!specimen.mass_kg && !material.density_given) {
      throw InputError(place, "has neither a mass_kg nor a density", "",
                       "material.density_kg_m3, a preset, or mass_kg");
    }
    problem.specimens.push_back(specimen);
  }
  if (std::all_of(problem.specimens.begin(), problem.specimens.end(), [](const Specimen& s) { return s.predict; }))
    throw InputError(top.place("specimen"), "all have predict = true", "", "one or more that are fitted");
}

}  // namespace

FitProblem parse_fit_problem(std::string_view text, const std::string& name, const std::filesystem::path& base_folder) {
  if (text.size() > kMaxTomlBytes) throw InputError(name, "is too long", std::to_string(text.size()), "1 MiB");
  const TomlTable top = TomlTable::parse(text, name, specimen_schema());
  FitProblem problem;
  problem.source_text = text;
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa", "rayleigh_stiffness_s", "rayleigh_mass_per_s"};
  problem.name = top.optional_text("name").value_or(std::filesystem::path(name).stem().string());
  if (!top.has("material")) throw InputError(name, "[material] is missing");
  const solid::MaterialInput material = solid::read_material(top.table("material"), base_folder);
  problem.material = material.material;
  problem.density_given = material.density_given;
  problem.material_files = material.files;
  if (!top.has("specimen")) throw InputError(name, "no [[specimen]] is given");
  read_specimens(top, material, base_folder, problem);
  read_fit(top.table("fit"), problem);
  check_tolerances(problem, top.place("specimen"));
  return problem;
}

FitProblem read_fit_problem(const std::filesystem::path& path) {
  const std::string text = read_file(path, kMaxTomlBytes);
  std::error_code error;
  const auto folder = std::filesystem::absolute(path, error).parent_path();
  FitProblem problem = parse_fit_problem(text, path.string(), folder);
  return problem;
}

}  // namespace klang::fit
