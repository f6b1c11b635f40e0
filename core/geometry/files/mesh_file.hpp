#pragma once
#include <filesystem>
#include <string>
#include <string_view>

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
  void validate() const;
};

/// Any body from a file: tetrahedra as they are, a closed surface (.stl, .obj, .ply, .off) through TetGen.
/// The default edge of a surface's tetrahedra is an eighth of its diagonal.
TetMesh load_body(const std::filesystem::path& path, const LoadOptions& options = {});

}  // namespace klang::mesh
