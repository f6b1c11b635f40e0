#include "core/geometry/files/mesh_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/import_check.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"

namespace klang::mesh {
namespace {

constexpr double kLongBody_m = 5.0, kShortBody_m = 1e-3;
constexpr const char* kKnown = ".msh, .vtu, .node, .ele; surfaces .stl, .obj, .ply, .off";

double surface_edge_m(const SurfaceMesh& surface, const LoadOptions& options) {
  double edge_m = options.max_edge_m;
  if (options.wavelength_m > 0.0) {
    const double wanted = options.wavelength_m / (options.elements_per_wavelength * (options.order == 1 ? 2.0 : 1.0));
    edge_m = edge_m > 0.0 ? std::min(edge_m, wanted) : wanted;
  }
  if (edge_m > 0.0 || surface.vertices_m.rows() == 0) return edge_m;
  const double diagonal = (surface.vertices_m.colwise().maxCoeff() - surface.vertices_m.colwise().minCoeff()).norm();
  return diagonal > 0.0 && std::isfinite(diagonal) ? 0.125 * diagonal : 0.0;
}

std::string rounded_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// "2.4 million", "350000"
std::string count_text(double n) {
  if (n >= 1e6) return rounded_text(std::round(n / 1e5) / 10.0) + " million";
  return std::to_string(std::lround(n / 1e4) * 10000L);
}

/// Elements joined over nodes.
int n_separate_bodies(const TetMesh& mesh) {
  std::vector<int> root(static_cast<std::size_t>(mesh.n_nodes()));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int v) {
    while (root[v] != v) v = root[v] = root[root[v]];
    return v;
  };
  std::vector<bool> used(root.size(), false);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int c = 0; c < 4; ++c) {
      used[mesh.elements(e, c)] = true;
      root[find(mesh.elements(e, c))] = find(mesh.elements(e, 0));
    }
  int n = 0;
  for (std::size_t v = 0; v < root.size(); ++v)
    if (used[v] && find(static_cast<int>(v)) == static_cast<int>(v)) ++n;
  return n;
}

TetMesh mesh_of_surface_file(const std::filesystem::path& path, const LoadOptions& options, BodyNotes& notes,
                             Monitor& monitor) {
  notes.repairs.emplace();
  SurfaceMesh surface = read_mended_surface(path, *notes.repairs);
  surface.vertices_m *= options.unit_m;
  notes.repairs->weld_distance_m *= options.unit_m;
  monitor.throw_if_stopped();
  std::string name = path.string();
  if (notes.repairs->any()) {
    notes.say(name + ": mended: " + notes.repairs->text());
    name += " (mended: " + notes.repairs->text() + ")";  // face numbers are those of the mended surface
  }
  TetgenOptions tetgen;
  tetgen.order = options.order;
  tetgen.in_child = true;
  tetgen.max_edge_m = surface_edge_m(surface, options);
  SurfaceParts parts = check_closed_surface(surface, name);
  if (options.max_triangles > 0 && surface.triangles.rows() > options.max_triangles) {
    surface = decimated_surface(surface, options.max_triangles, notes.decimation.emplace());
    const SurfaceDecimation& made = *notes.decimation;
    char text[200];
    std::snprintf(text, sizeof text,
                  ": surface of %d triangles made coarser: %d, off by %.2g m at most, %.2g m rms, volume %+.2g %%",
                  made.n_faces_before, made.n_faces_after, made.max_distance_m, made.rms_distance_m,
                  100.0 * made.relative_volume_change);
    notes.say(path.string() + text);
    if (made.n_faces_after > options.max_triangles)
      notes.warn(path.string() + ": " + std::to_string(options.max_triangles) +
                 " triangles cannot be reached without cutting into the body");
    parts = check_closed_surface(surface, name);
  }
  notes.n_expected_elements = expected_elements(surface, parts.volume_m3, tetgen);
  if (*notes.n_expected_elements >= kManyElements)
    notes.warn(path.string() + ": the surface's " + std::to_string(surface.triangles.rows()) +
               " triangles will need about " + count_text(*notes.n_expected_elements) +
               " tetrahedra; fewer triangles (--max-triangles) or a longer --max-edge-m make it fewer");
  return mesh_surface(surface, tetgen, name, monitor);
}

}  // namespace

void LoadOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (max_triangles > 0 && max_triangles < 100)
    violations.push_back({"max_triangles", "is out of range", std::to_string(max_triangles), "0, or 100 to 2e7"});
  throw_violations("mesh options", std::move(violations));
}

TetMesh read_tet_mesh_bytes(std::string_view bytes, std::string_view extension, const std::string& name) {
  if (bytes.empty()) throw InputError(name, "the file is empty");
  const std::string kind = lower_case(extension);
  if (kind == ".msh") return checked_import(detail::read_gmsh(bytes, name), name);
  if (kind == ".vtu") return checked_import(detail::read_vtu(bytes, name), name);
  throw InputError(name, "unknown mesh format", kind, kKnown);
}

TetMesh read_tetgen_bytes(std::string_view node_bytes, std::string_view ele_bytes, const std::string& name) {
  return checked_import(detail::read_tetgen(node_bytes, ele_bytes, name), name);
}

TetMesh read_tet_mesh(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  if (extension == ".node" || extension == ".ele") {
    const auto sibling = [&path](const char* other) { return std::filesystem::path(path).replace_extension(other); };
    return read_tetgen_bytes(read_file(extension == ".node" ? path : sibling(".node")),
                             read_file(extension == ".ele" ? path : sibling(".ele")), path.string());
  }
  return read_tet_mesh_bytes(read_file(path), extension, path.string());
}

void write_tet_mesh(const std::filesystem::path& path, const TetMesh& mesh, MeshFormat format) {
  if (format == MeshFormat::kFromExtension) {
    const std::string extension = lower_case(path.extension().string());
    if (extension != ".vtu" && extension != ".msh")
      throw InputError(path.string(), "unknown mesh format to write", extension, ".vtu, .msh");
    format = extension == ".vtu" ? MeshFormat::kVtu : MeshFormat::kGmsh41;
  }
  write_file(path, format == MeshFormat::kVtu      ? detail::vtu_text(mesh)
                   : format == MeshFormat::kGmsh22 ? detail::gmsh22_text(mesh)
                                                   : detail::gmsh41_text(mesh));
}

void BodyNotes::say(const std::string& text) const {
  if (note) note(text);
}

void BodyNotes::warn(const std::string& text) const {
  if (warning) warning(text);
}

TetMesh load_body(const std::filesystem::path& path, const LoadOptions& options, BodyNotes* notes, Monitor& monitor) {
  options.validate();
  BodyNotes unheard;
  if (notes == nullptr) notes = &unheard;
  if (is_surface_file(path)) return mesh_of_surface_file(path, options, *notes, monitor);
  TetMesh mesh = read_tet_mesh(path);
  mesh.nodes_m *= options.unit_m;
  return options.order == 2 ? to_quadratic(mesh) : to_linear(mesh);
}

std::vector<std::string> body_warnings(const TetMesh& mesh, double unit_m, const std::string& option) {
  std::vector<std::string> warnings;
  if (mesh.n_nodes() == 0) return warnings;
  const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).maxCoeff();
  const auto warn_of_unit = [&](const std::string& problem, const char* other, double factor) {
    warnings.push_back(problem + rounded_text(size_m) + " m long: " +
                       (option.empty()
                            ? std::string("dimensions are read as metres")
                            : "is the file's unit " + std::string(other) + "? " + option + " " +
                                  to_text(unit_m * factor) + " would make it " + rounded_text(size_m * factor) + " m"));
  };
  if (size_m > kLongBody_m) warn_of_unit("the body is ", "smaller", 1e-3);
  if (size_m < kShortBody_m) warn_of_unit("the body is only ", "larger", 1e3);
  const int n_bodies = n_separate_bodies(mesh);
  if (n_bodies > 1)
    warnings.push_back("the mesh holds " + std::to_string(n_bodies) +
                       " bodies that do not hang together: each rings by itself (6 rigid modes each when free); a "
                       "scene moves them as one");
  return warnings;
}

}  // namespace klang::mesh
