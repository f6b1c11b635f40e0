#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/solid/material.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::fit {

struct Prior {
  double mean = 0.0;
  double std = 0.0;  ///< > 0
};

/// A place where a wire or a pad of foam takes energy out of the body: a viscous damper there.
struct Mount {
  std::array<double, 3> at_m{};
  std::optional<std::array<double, 3>> direction;  ///< it acts along this alone; empty: along all three axes alike
};

/// One body with its recordings (or partials measured elsewhere).
struct Specimen {
  std::string name;
  std::optional<mesh::ShapeSpec> shape;  ///< this or mesh_file
  std::optional<std::filesystem::path> mesh_file;
  double unit_m = 1.0;  ///< length of the mesh file's unit [m]
  /// Standard deviations of what is given, by name: a dimension, mass_kg or density_kg_m3. They enter the intervals.
  std::map<std::string, double> tolerance;
  std::optional<double> mass_kg;  ///< gives the density by the body's volume
  solid::Support support;
  std::vector<std::filesystem::path> recordings;  ///< these or partials
  std::optional<std::filesystem::path> partials;
  std::optional<std::array<double, 3>> strike_m;  ///< nearest surface node is struck in the resynthesis
  std::optional<std::array<double, 3>> microphone_m;
  std::vector<Mount> mounts;  ///< one coefficient for all of them is fitted with the damping
  bool predict = false;       ///< takes no part in the fit: its partials are predicted and held against its recording
};

/// What specimen.toml says. Paths are made absolute against the file's folder.
struct FitProblem {
  std::string name;
  solid::Material material;                                ///< starting guess
  std::vector<std::filesystem::path> material_files = {};  ///< that it was read from
  bool density_given = true;                               ///< false: from mass_kg of each specimen
  std::vector<Specimen> specimens;
  std::vector<std::string> parameters;  ///< names as in fit.json
  std::map<std::string, Prior> priors;  ///< by parameter name
  Band band;
  bool radiation_damping = false;  ///< compute what the matched modes radiate, for the damping models
  std::string source_text;         ///< the TOML, for provenance
};

/// Reads and checks specimen.toml by the schema in fit/specimen_schema.hpp: unknown keys, wrong types and values out of
/// range are InputErrors that name file, line, key, value and what is allowed.
FitProblem read_fit_problem(const std::filesystem::path& path);
FitProblem parse_fit_problem(std::string_view toml, const std::string& name, const std::filesystem::path& base_folder);

/// The schema as a table of key, type, default, range, meaning: for --help and docs/specimen.md.
std::string specimen_schema_markdown();

}  // namespace klang::fit
