#include "fit/specimen/specimen.hpp"

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "fit/specimen/specimen_schema.hpp"

namespace klang::fit {
namespace {

constexpr std::size_t kMaxSpecimens = 1000;
constexpr std::size_t kMaxTomlBytes = 1 << 20;

std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return "\"" + text->get().substr(0, 80) + "\"";
  if (const auto number = node.value<double>()) return to_text(*number);
  if (node.is_table()) return "a table";
  if (node.is_array()) return "a list";
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  return "a date or time";
}

/// Reads values of one table by the schema; every complaint carries file, line and key.
class Reader {
 public:
  Reader(const toml::table& table, std::string file, std::string schema_table, std::string shown_table)
      : table_(table), file_(std::move(file)), schema_(std::move(schema_table)), shown_(std::move(shown_table)) {
    for (const auto& [key, node] : table_) {
      if (!find_field(schema_, key.str())) {
        throw InputError(place(node, key.str()), "unknown key", "", known_keys(schema_));
      }
    }
  }

  std::string place(const toml::node& node, std::string_view key) const { return at(node.source().begin.line, key); }
  std::string place(std::string_view key) const {
    const toml::node* node = table_.get(key);
    return at((node ? *node : static_cast<const toml::node&>(table_)).source().begin.line, key);
  }
  const toml::node* find(std::string_view key) const { return table_.get(key); }
  bool has(std::string_view key) const { return find(key) != nullptr; }

  std::optional<std::string> text(std::string_view key) const {
    const toml::node* node = find(key);
    if (!node) return std::nullopt;
    return text_of(*node, key);
  }

  std::optional<double> number(std::string_view key) const {
    const toml::node* node = find(key);
    if (!node) return std::nullopt;
    return number_of(*node, key);
  }

  double required_number(std::string_view key) const {
    if (const auto value = number(key)) return *value;
    throw InputError(place(key), "is missing", "", range_text(*find_field(schema_, key)));
  }

  bool flag(std::string_view key) const {
    const toml::node* node = find(key);
    if (!node) return false;
    if (const auto* value = node->as_boolean()) return value->get();
    throw InputError(place(*node, key), "must be true or false", shown(*node));
  }

  std::vector<std::string> texts(std::string_view key) const {
    std::vector<std::string> values;
    for (const toml::node& element : list(key)) values.push_back(text_of(element, key));
    return values;
  }

  std::vector<double> numbers(std::string_view key) const {
    const toml::array& array = list(key);
    const auto n_wanted = static_cast<std::size_t>(find_field(schema_, key)->list_length);
    if (n_wanted > 0 && array.size() != n_wanted) {
      throw InputError(place(key), "has a wrong number of entries", std::to_string(array.size()),
                       std::to_string(n_wanted));
    }
    std::vector<double> values;
    for (const toml::node& element : array) values.push_back(number_of(element, key));
    return values;
  }

  std::vector<double> required_numbers(std::string_view key) const {
    if (has(key)) return numbers(key);
    throw InputError(place(key), "is missing", "", find_field(schema_, key)->meaning);
  }

  std::vector<const toml::table*> tables(std::string_view key) const {
    std::vector<const toml::table*> tables;
    if (!has(key)) return tables;
    for (const toml::node& element : list(key)) {
      if (!element.is_table()) throw InputError(place(element, key), "must be a table", shown(element));
      tables.push_back(element.as_table());
    }
    return tables;
  }

  const toml::table& sub_table(std::string_view key) const {
    const toml::node& node = *find(key);
    if (const auto* table = node.as_table()) return *table;
    throw InputError(place(node, key), "must be a table", shown(node));
  }

 private:
  std::string at(toml::source_index line, std::string_view key) const {
    std::string text = file_;
    if (line > 0) text += ":" + std::to_string(line);
    text += ": ";
    if (!shown_.empty()) text += shown_ + ".";
    text += key;
    return text;
  }

  std::string text_of(const toml::node& node, std::string_view key) const {
    const auto* value = node.as_string();
    if (!value) throw InputError(place(node, key), "must be a text", shown(node));
    if (value->get().find('\0') != std::string::npos || value->get().size() > 4096) {
      throw InputError(place(node, key), "is no usable text (a NUL byte, or over 4096 bytes)");
    }
    return value->get();
  }

  double number_of(const toml::node& node, std::string_view key) const {
    const SchemaField& field = *find_field(schema_, key);
    if (!node.is_number()) throw InputError(place(node, key), "must be a number", shown(node), range_text(field));
    const auto* integer = node.as_integer();  // toml++ gives no double for an integer that is not one exactly
    const double value = integer ? static_cast<double>(integer->get()) : node.as_floating_point()->get();
    if (!(value > field.low && value < field.high)) {
      throw InputError(place(node, key), "is out of range", to_text(value), range_text(field));
    }
    return value;
  }

  const toml::array& list(std::string_view key) const {
    const toml::node& node = *find(key);
    if (const auto* array = node.as_array()) return *array;
    throw InputError(place(node, key), "must be a list", shown(node));
  }

  const toml::table& table_;
  std::string file_, schema_, shown_;
};

/// Calls core functions that complain without knowing the file, and adds where.
template <class Function>
auto located(const std::string& place, Function&& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw InputError(place, error.what());
  }
}

std::filesystem::path existing_file(const Reader& reader, std::string_view key, const std::string& text,
                                    const std::filesystem::path& base) {
  const std::filesystem::path path = (base / text).lexically_normal();
  std::error_code error;
  if (text.empty() || !std::filesystem::is_regular_file(path, error)) {
    throw InputError(reader.place(key), "no such file", path.string());
  }
  return path;
}

void read_material(const Reader& reader, FitProblem& problem, bool& explicit_density) {
  const auto preset = reader.text("preset");
  const auto lambda = reader.number("lame_lambda_pa"), mu = reader.number("lame_mu_pa");
  const auto young = reader.number("youngs_modulus_pa"), poisson = reader.number("poissons_ratio");
  const auto density = reader.number("density_kg_m3");
  explicit_density = density.has_value();
  const bool lame = lambda || mu, engineering = young || poisson;
  constexpr std::string_view kAllowed =
      "preset, or lame_lambda_pa with lame_mu_pa, or youngs_modulus_pa with poissons_ratio";
  if (int(preset.has_value()) + int(lame) + int(engineering) != 1) {
    const char* problem_text = preset || lame || engineering ? "says the elasticity twice" : "says no elasticity";
    throw InputError(reader.place(preset ? "preset"
                                  : lame ? "lame_mu_pa"
                                         : "youngs_modulus_pa"),
                     problem_text, "", kAllowed);
  }
  if (lame && !(lambda && mu))
    throw InputError(reader.place(lambda ? "lame_lambda_pa" : "lame_mu_pa"), "stands alone", "", kAllowed);
  if (engineering && !(young && poisson)) {
    throw InputError(reader.place(young ? "youngs_modulus_pa" : "poissons_ratio"), "stands alone", "", kAllowed);
  }
  solid::Material& material = problem.material;
  if (preset) {
    material = located(reader.place("preset"), [&] { return solid::material_preset(*preset); });
  } else if (lame) {
    material.lame_lambda_pa = *lambda;
    material.lame_mu_pa = *mu;
  } else {
    material = located(reader.place("poissons_ratio"),
                       [&] { return solid::from_youngs_modulus(*young, *poisson, density.value_or(1000.0)); });
  }
  problem.density_given = density || preset;
  if (density) material.density_kg_m3 = *density;
  if (!problem.density_given) material.density_kg_m3 = 0.0;
  solid::Material trial = material;
  if (!problem.density_given) trial.density_kg_m3 = 1000.0;
  located(reader.place(lame     ? "lame_lambda_pa"
                       : preset ? "preset"
                                : "poissons_ratio"),
          [&] { solid::validate(trial); });
}

mesh::ShapeSpec read_shape(const toml::table& table, const std::string& file, const std::string& shown_table,
                           const std::filesystem::path& base) {
  const Reader reader(table, file, "specimen.shape", shown_table);
  mesh::ShapeSpec shape;
  const auto kind = reader.text("kind");
  if (!kind) throw InputError(reader.place("kind"), "is missing", "", find_field("specimen.shape", "kind")->meaning);
  shape.kind = *kind;
  const auto& dimensions = located(reader.place("kind"), [&] { return mesh::shape_dimensions(*kind); });
  const bool has_profile = mesh::find_shape(*kind).facts().has_profile;
  std::string allowed = "kind";
  for (const std::string& name : dimensions) allowed += ", " + name;
  if (has_profile) allowed += ", profile_csv";
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (name == "kind" || (name == "profile_csv" && has_profile)) continue;
    if (std::find(dimensions.begin(), dimensions.end(), name) == dimensions.end()) {
      throw InputError(reader.place(node, name), "is no dimension of a " + *kind, "", allowed);
    }
    shape.dims[name] = *reader.number(name);
  }
  for (const std::string& name : dimensions) {
    if (!shape.dims.count(name)) throw InputError(reader.place(name), "is missing", "", allowed);
  }
  if (has_profile) {
    const auto profile = reader.text("profile_csv");
    if (!profile) throw InputError(reader.place("profile_csv"), "is missing");
    shape.profile_csv = existing_file(reader, "profile_csv", *profile, base);
  }
  located(reader.place("kind"), [&] { mesh::validate(shape); });
  return shape;
}

solid::Support read_support(const Reader& specimen, const std::string& file, const std::string& shown_table) {
  const toml::node& node = *specimen.find("support");
  const std::string place = specimen.place("support");
  if (node.is_string()) return located(place, [&] { return solid::parse_support(node.as_string()->get()); });
  const Reader reader(specimen.sub_table("support"), file, "specimen.support", shown_table + ".support");
  const auto kind = reader.text("kind"), where = reader.text("where");
  if (!kind) throw InputError(reader.place("kind"), "is missing", "", "free, clamped, pinned");
  if (*kind != "free" && *kind != "clamped" && *kind != "pinned") {
    throw InputError(reader.place("kind"), "unknown kind of support", *kind, "free, clamped, pinned");
  }
  if (*kind == "free") {
    if (where) throw InputError(reader.place("where"), "has no meaning for a free body", *where);
    return {};
  }
  if (!where) throw InputError(reader.place("where"), "is missing");
  return located(reader.place("where"), [&] { return solid::parse_support(*kind + ":" + *where); });
}

void check_name(const Reader& reader, const std::string& name) {
  const bool fits = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c >= 0x80 || std::isalnum(c) || c == '_' || c == '-' || c == '+' || c == '#' || c == ' ';
  });
  if (!fits || name.front() == ' ' || name.back() == ' ') {
    throw InputError(reader.place("name"), "cannot be part of a file name", name,
                     "1 to 64 letters, digits, spaces and _ - + #");
  }
}

std::array<double, 3> point(const std::vector<double>& values) { return {values[0], values[1], values[2]}; }

Specimen read_specimen(const toml::table& table, std::size_t number, const std::string& file,
                       const std::filesystem::path& base) {
  const std::string shown_table = "specimen[" + std::to_string(number) + "]";
  const Reader reader(table, file, "specimen", shown_table);
  Specimen specimen;
  specimen.name = reader.text("name").value_or("specimen-" + std::to_string(number));
  check_name(reader, specimen.name);
  if (reader.has("shape") && reader.has("mesh")) {
    throw InputError(reader.place("mesh"), "shape and mesh are both given", "", "one of them");
  }
  if (reader.has("shape")) {
    specimen.shape = read_shape(reader.sub_table("shape"), file, shown_table + ".shape", base);
  } else if (const auto path = reader.text("mesh")) {
    specimen.mesh_file = existing_file(reader, "mesh", *path, base);
  } else {
    throw InputError(reader.place("shape"), "neither shape nor mesh is given", "", "one of them");
  }
  specimen.mass_kg = reader.number("mass_kg");
  if (reader.has("support")) specimen.support = read_support(reader, file, shown_table);
  const int n_sources = int(reader.has("recording")) + int(reader.has("recordings")) + int(reader.has("partials"));
  if (n_sources > 1) {
    throw InputError(reader.place(reader.has("partials") ? "partials" : "recordings"),
                     "the data are given more than once", "", "one of recording, recordings, partials");
  }
  if (const auto path = reader.text("recording")) {
    specimen.recordings.push_back(existing_file(reader, "recording", *path, base));
  }
  if (reader.has("recordings")) {
    for (const std::string& path : reader.texts("recordings")) {
      specimen.recordings.push_back(existing_file(reader, "recordings", path, base));
    }
    if (specimen.recordings.empty()) throw InputError(reader.place("recordings"), "is an empty list");
  }
  if (const auto path = reader.text("partials")) specimen.partials = existing_file(reader, "partials", *path, base);
  if (reader.has("strike_m")) specimen.strike_m = point(reader.numbers("strike_m"));
  if (reader.has("microphone_m")) specimen.microphone_m = point(reader.numbers("microphone_m"));
  for (const toml::table* entry : reader.tables("mount")) {
    const Reader mount(*entry, file, "specimen.mount", shown_table + ".mount");
    specimen.mounts.push_back({point(mount.required_numbers("at_m")), std::nullopt});
    if (!mount.has("direction")) continue;
    specimen.mounts.back().direction = point(mount.numbers("direction"));
    if (*specimen.mounts.back().direction == std::array<double, 3>{})
      throw InputError(mount.place("direction"), "is zero");
  }
  specimen.predict = reader.flag("predict");
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

std::string allowed_names() {
  std::string text;
  for (const std::string& name : material_parameter_names()) text += name + ", ";
  return text + "SPECIMEN.DIMENSION";
}

void read_priors(const Reader& reader, const toml::table& table, const std::string& file, const std::string& prefix,
                 FitProblem& problem) {
  for (const auto& [key, node] : table) {
    const std::string name = prefix + std::string(key.str());
    const std::string place = reader.place(node, "priors." + name);
    const toml::table* entry = node.as_table();
    if (!entry) throw InputError(place, "must be a table", shown(node), "{ mean = ..., std = ... }");
    const bool is_entry = entry->contains("mean") || entry->contains("std");
    if (!is_entry && prefix.empty()) {  // an unquoted D3.length_m is a table in a table
      read_priors(reader, *entry, file, name + ".", problem);
      continue;
    }
    if (const auto wrong = name_problem(problem, name); !wrong.empty()) {
      throw InputError(place, wrong, name, allowed_names());
    }
    const auto& asked = problem.parameters;
    if (!is_elastic(name) && std::find(asked.begin(), asked.end(), name) == asked.end()) {
      throw InputError(place, "prior of a parameter that is not fitted", name);
    }
    const Reader values(*entry, file, "fit.priors.*", "fit.priors." + name);
    problem.priors[name] = {values.required_number("mean"), values.required_number("std")};
  }
}

void read_fit(const Reader& reader, const std::string& file, FitProblem& problem) {
  if (reader.has("parameters")) {
    problem.parameters = reader.texts("parameters");
    if (problem.parameters.empty()) throw InputError(reader.place("parameters"), "is an empty list");
  }
  std::set<std::string> seen;
  int n_elastic = 0;
  for (const std::string& name : problem.parameters) {
    if (const auto wrong = name_problem(problem, name); !wrong.empty()) {
      throw InputError(reader.place("parameters"), wrong, name, allowed_names());
    }
    const bool is_new = seen.insert(name == "shear_modulus_pa" ? "lame_mu_pa" : name).second;
    if (!is_new) throw InputError(reader.place("parameters"), "parameter named twice", name);
    n_elastic += is_elastic(name) ? 1 : 0;
  }
  if (n_elastic > 2) {
    throw InputError(reader.place("parameters"), "an isotropic solid has two elastic constants",
                     std::to_string(n_elastic), "at most 2");
  }
  if (seen.count("density_kg_m3")) {
    const bool used = std::any_of(problem.specimens.begin(), problem.specimens.end(),
                                  [](const Specimen& specimen) { return !specimen.mass_kg; });
    if (!used) {
      throw InputError(reader.place("parameters"), "density_kg_m3 is given by the masses and cannot be fitted");
    }
  }
  if (reader.has("band_hz")) {
    const auto band = reader.numbers("band_hz");
    if (!(band[0] < band[1])) {
      throw InputError(reader.place("band_hz"), "must rise", to_text(band[0]) + ", " + to_text(band[1]));
    }
    problem.band = {band[0], band[1]};
  }
  problem.radiation_damping = reader.flag("radiation_damping");
  if (reader.has("priors")) read_priors(reader, reader.sub_table("priors"), file, "", problem);
}

}  // namespace

FitProblem parse_fit_problem(std::string_view text, const std::string& name, const std::filesystem::path& base_folder) {
  if (text.size() > kMaxTomlBytes) throw InputError(name, "is too long", std::to_string(text.size()), "1 MiB");
  toml::table root;
  try {
    root = toml::parse(text, name);
  } catch (const toml::parse_error& error) {
    throw InputError(name + ":" + std::to_string(error.source().begin.line), error.description());
  }
  FitProblem problem;
  problem.source_text = text;
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa", "rayleigh_stiffness_s", "rayleigh_mass_per_s"};
  const Reader top(root, name, "", "");
  problem.name = top.text("name").value_or(std::filesystem::path(name).stem().string());
  if (!top.has("material")) throw InputError(name, "[material] is missing");
  const Reader material(top.sub_table("material"), name, "material", "material");
  bool explicit_density = false;
  read_material(material, problem, explicit_density);

  const toml::node* list = top.find("specimen");
  if (!list) throw InputError(name, "no [[specimen]] is given");
  const toml::array* specimens = list->as_array();
  if (!specimens || specimens->empty() || specimens->size() > kMaxSpecimens) {
    throw InputError(top.place("specimen"), "must be a list of 1 to 1000 tables", shown(*list), "[[specimen]]");
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < specimens->size(); ++i) {
    const toml::table* table = (*specimens)[i].as_table();
    if (!table) throw InputError(top.place("specimen"), "must be tables", shown((*specimens)[i]), "[[specimen]]");
    Specimen specimen = read_specimen(*table, i + 1, name, base_folder);
    const std::string place =
        name + ":" + std::to_string((*specimens)[i].source().begin.line) + ": specimen[" + std::to_string(i + 1) + "]";
    if (!names.insert(specimen.name).second) throw InputError(place + ".name", "is used twice", specimen.name);
    if (specimen.mass_kg && explicit_density) {
      throw InputError(place + ".mass_kg", "mass and density_kg_m3 are both given", to_text(*specimen.mass_kg),
                       "one of them");
    }
    if (!specimen.mass_kg && !problem.density_given) {
      throw InputError(place, "has neither a mass_kg nor a density", "",
                       "material.density_kg_m3, a preset, or mass_kg");
    }
    problem.specimens.push_back(std::move(specimen));
  }
  if (std::all_of(problem.specimens.begin(), problem.specimens.end(), [](const Specimen& s) { return s.predict; }))
    throw InputError(top.place("specimen"), "all have predict = true", "", "one or more that are fitted");
  const toml::table empty;
  read_fit(Reader(top.has("fit") ? top.sub_table("fit") : empty, name, "fit", "fit"), name, problem);
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
