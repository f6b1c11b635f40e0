#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/commands/mesh_document.hpp"
#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/geometry/files/mesh_file.hpp"
#include "core/geometry/mesh/quality.hpp"

namespace klang::apps {
namespace {

struct MeshOptions {
  BodyOptions body;
  std::string output;
  double density_kg_m3 = 0.0;
};

int run_mesh(MeshOptions options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const auto& kinds = mesh::shape_kinds();
  if (std::find(kinds.begin(), kinds.end(), options.body.shape) == kinds.end()) {
    std::swap(options.body.shape, options.body.mesh_file);
  }
  mesh::BodyNotes notes;
  std::vector<std::string> warnings;
  const mesh::TetMesh mesh = options.body.build_and_tell(common, notes, warnings, monitor);
  const mesh::MeshQuality quality = mesh::mesh_quality(mesh);
  MeshDocument document;
  document.header = make_header("mesh", "done", common,
                                {{"element", options.body.element},
                                 {"max_edge_m", options.body.max_edge_m},
                                 {"max_triangles", options.body.max_triangles},
                                 {"unit_m", options.body.unit_m}},
                                options.body.inputs({}));
  document.header.warnings = warnings;
  document.quality = quality;
  document.element = quality.order == 2 ? "p2" : "p1";
  document.repairs = notes.repairs;
  document.decimation = notes.decimation;
  document.n_expected_elements = notes.n_expected_elements;
  if (options.density_kg_m3 > 0.0) document.mass_kg = quality.mass_kg(options.density_kg_m3);
  if (!options.output.empty()) mesh::write_tet_mesh(options.output, mesh);
  write_json(common, json_of(document));
  say(common, "%d nodes, %d %s tetrahedra\n", mesh.n_nodes(), mesh.n_elements(),
      mesh.order() == 2 ? "quadratic" : "linear");
  say(common, "volume_m3 %.9g   surface_area_m2 %.9g\n", quality.volume_m3, quality.surface_area_m2);
  if (options.density_kg_m3 > 0.0) say(common, "mass_kg %.9g\n", quality.mass_kg(options.density_kg_m3));
  say(common,
      "edges %.4g to %.4g m; dihedral angles %.1f to %.1f deg; radius ratio %.3f at worst (element %d), %.3f mean\n",
      quality.shortest_edge_m, quality.longest_edge_m, quality.min_dihedral_deg, quality.max_dihedral_deg,
      quality.radius_ratio_min, quality.worst_element, quality.radius_ratio_mean);
  return kDone;
}

}  // namespace

Subcommand add_mesh(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<MeshOptions>();
  CLI::App* app = program.add_subcommand("mesh", "Make or import a tetrahedral mesh, with a quality report");
  options->body.add_to(*app, common, true);
  app->add_option("-o,--output", options->output, "Write the mesh (.vtu or .msh)");
  app->add_option("--density-kg-m3", options->density_kg_m3, "Also report the mass");
  app->footer(
      "Examples:\n"
      "  klang mesh tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 -o tube.vtu\n"
      "  klang mesh bell.stl --max-edge-m 0.004 -o bell.vtu --json quality.json");
  return {app,
          [options, &common] { return run_mesh(*options, common); },
          {result_kind<MeshDocument>("mesh", "the result of `klang mesh`")}};
}

}  // namespace klang::apps
