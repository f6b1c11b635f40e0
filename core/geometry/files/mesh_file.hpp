#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "core/geometry/mesh/surface_repair.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Reads 4- or 10-node tetrahedra, in the file's unit:
///   .msh         Gmsh 2.2 and 4.1, ASCII and binary; named physical groups become node sets (but not one
///   that
///                is the whole body)
///   .vtu         VTK XML, every encoding and compression; point arrays "node_set:NAME" become node sets
///   .node, .ele  TetGen, either name: the other file lies beside it; node markers become node sets
///   "boundary_MARKER"
/// Points, lines and surface elements only name nodes; other solid elements (hexahedra, wedges) are refused.
/// Nodes that no tetrahedron uses are dropped, elements that run the wrong way round are turned; parts may be
/// separate bodies.
/// @throws InputError naming the line, byte, node or element (0-based): see detail/import_check.hpp for the
/// checks
TetMesh read_tet_mesh(const std::filesystem::path& path);

/// As read_tet_mesh on bytes in memory; extension ".msh" or ".vtu", name for messages.
TetMesh read_tet_mesh_bytes(std::string_view bytes, std::string_view extension, const std::string& name);

/// The two TetGen files in memory.
TetMesh read_tetgen_bytes(std::string_view node_bytes, std::string_view ele_bytes, const std::string& name);

enum class MeshFormat {
  kFromExtension,  ///< .vtu, or .msh in version 4.1
  kVtu,            ///< base64, exact to the last bit
  kGmsh22,         ///< ASCII, 17 digits: exact too
  kGmsh41,
};
/// Writes the mesh with its node sets (Gmsh: as named physical groups of points).
void write_tet_mesh(const std::filesystem::path& path, const TetMesh& mesh,
                    MeshFormat format = MeshFormat::kFromExtension);

struct LoadOptions {
  int order = 2;                         ///< 1 or 2: linear files get mid-nodes, quadratic ones lose them
  double unit_m = 1.0;                   ///< length of the file's unit [m], e.g. 0.001 for millimetres
  double max_edge_m = 0.0;               ///< surfaces only: longest edge [m]; 0: from the wavelength, or the default
  double wavelength_m = 0.0;             ///< surfaces only: shortest structural wavelength to resolve [m]
  double elements_per_wavelength = 4.0;  ///< of quadratic elements (linear ones get twice as many)
  int max_triangles = 0;                 ///< surfaces only: decimate above this many; 0: as they are
  void validate() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"order", "Order of the elements", between(1.0, 2.0)}, self.order);
    visit({"unit_m", "Length of the file's unit", inside(0.0, 1e6)}, self.unit_m);
    visit({"max_edge_m", "Longest edge of a surface's tetrahedra; 0: from the wavelength, or the default",
           between(0.0, 1e6)},
          self.max_edge_m);
    visit({"wavelength_m", "Shortest structural wavelength to resolve; 0: none", between(0.0, 1e6)}, self.wavelength_m);
    visit({"elements_per_wavelength", "Quadratic elements per structural wavelength", between(0.5, 1000.0)},
          self.elements_per_wavelength);
    visit({"max_triangles", "A surface of more triangles is decimated, 100 to 2e7; 0: never", between(0.0, 2e7)},
          self.max_triangles);
  }
};

/// What a user should hear of a body from a file. Both functions may be empty; they are called as soon as it is known, a
/// large count before the mesher starts on it.
struct BodyNotes {
  std::function<void(const std::string&)> note, warning;
  std::optional<SurfaceRepairs> repairs;        ///< of a surface
  std::optional<SurfaceDecimation> decimation;  ///< where it was made coarser
  std::optional<double> n_expected_elements;    ///< of a surface: expected_elements()
  void say(const std::string& text) const;
  void warn(const std::string& text) const;
};

/// From this many expected tetrahedra on load_body() warns before it meshes.
inline constexpr double kManyElements = 3e5;

/// Any body from a file: tetrahedra as they are, a closed surface (.stl, .obj, .ply, .off), mended
/// (surface_repair.hpp), through TetGen. The default edge of a surface's tetrahedra is an eighth of its diagonal.
/// @param notes  where given: what was mended, coarsened or will take long
/// @param monitor  heeded by the mesher
/// Not inside parallel jobs: the mesher runs in a child process.
TetMesh load_body(const std::filesystem::path& path, const LoadOptions& options = {}, BodyNotes* notes = nullptr,
                  Monitor& monitor = silent_monitor());

/// What is suspicious about a body whose lengths were read in units of unit_m: longer than 5 m or shorter than 1 mm (the
/// unit is probably another one; option: what the caller calls it, "--unit-m"; empty for dimensions in metres), several
/// bodies that do not hang together. One sentence each, without the file's name.
std::vector<std::string> body_warnings(const TetMesh& mesh, double unit_m, const std::string& option);

}  // namespace klang::mesh
