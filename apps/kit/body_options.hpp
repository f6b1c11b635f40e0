#pragma once
#include <CLI/App.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/kit/command.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/solid/material.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::apps {

/// "length_m=0.5,wall_m=0.001" as names and numbers; InputError names the option and the bad part.
std::map<std::string, double> parse_assignments(const std::string& option, const std::string& text);

/// Whether --material names a file: the fit.json of klang fit.
bool is_fit_file(const std::string& material);

/// A preset's name, the path of a fit.json, or lame_lambda_pa=..,lame_mu_pa=..,density_kg_m3=.. or youngs_modulus_pa=..,poissons_ratio=..,density..
solid::Material parse_material(const std::string& text);

/// The options that say which body: --shape with --dims and --profile, or --mesh; and how it is meshed.
struct BodyOptions {
  std::string shape;
  std::string dims;
  std::string profile;
  std::string mesh_file;
  std::string element = "p2";
  double max_edge_m = 0.0;
  double unit_m = 1.0;
  int refinement = 0;
  int max_triangles = 0;

  void add_to(CLI::App& app, CommonOptions& common, bool shape_is_positional = false);
  std::optional<mesh::ShapeSpec> shape_spec() const;  ///< checked; empty when --mesh is given
  int order() const { return element == "p1" ? 1 : 2; }
  /// Meshes or reads the body. wavelength_m: shortest structural wavelength, 0 for the default resolution.
  /// notes, where given, tells what a file needed and what is suspicious about its body.
  mesh::TetMesh build(double wavelength_m = 0.0, mesh::BodyNotes* notes = nullptr,
                      Monitor& monitor = silent_monitor()) const;
  /// The same, with notes and warnings on the terminal; warnings are added to those of the result, too.
  mesh::TetMesh build_and_tell(const CommonOptions& common, mesh::BodyNotes& notes, std::vector<std::string>& warnings,
                               Monitor& monitor) const;
  std::vector<std::filesystem::path> inputs(const std::string& material) const;  ///< files that were read

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"max_edge_m", "Longest element edge in metres; 0: chosen by the program", between(0.0, 1e3)},
          self.max_edge_m);
    visit({"unit_m", "Mesh files: length of the file's unit in metres (0.001: millimetres)", between(1e-9, 1e6)},
          self.unit_m);
    visit({"max_triangles", "Surface files: make the surface coarser first, down to this many triangles; 0: as it is",
           between(0.0, 2e7)},
          self.max_triangles);
    visit({"refinement", "Halve every edge this often (shapes)", between(0.0, 4.0)}, self.refinement);
  }
};

}  // namespace klang::apps
