#include "core/geometry/files/mesh_file.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/detail/mesh_formats.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/import_check.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"

namespace klang::mesh {
namespace {

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

}  // namespace

void LoadOptions::validate() const {
  const std::string place = "mesh options";
  if (order != 1 && order != 2) throw InputError(place, "order", std::to_string(order), "1 or 2");
  checked_open(place, "unit_m", unit_m, 0.0, 1e6);
  checked(place, "max_edge_m", max_edge_m, 0.0, 1e6);
  checked(place, "wavelength_m", wavelength_m, 0.0, 1e6);
  checked(place, "elements_per_wavelength", elements_per_wavelength, 0.5, 1000.0);
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

TetMesh load_body(const std::filesystem::path& path, const LoadOptions& options) {
  options.validate();
  if (is_surface_file(path)) {
    SurfaceMesh surface = read_surface(path);
    surface.vertices_m *= options.unit_m;
    TetgenOptions tetgen;
    tetgen.order = options.order;
    tetgen.max_edge_m = surface_edge_m(surface, options);
    return mesh_surface(surface, tetgen, path.string());
  }
  TetMesh mesh = read_tet_mesh(path);
  mesh.nodes_m *= options.unit_m;
  return options.order == 2 ? to_quadratic(mesh) : to_linear(mesh);
}

}  // namespace klang::mesh
