#pragma once
#include <string>
#include <string_view>

#include "core/geometry/mesh/tet_mesh.hpp"

/// One function a format; none of them checks geometry (see import_check.hpp).
namespace klang::mesh::detail {

TetMesh read_gmsh(std::string_view bytes, const std::string& name);
std::string gmsh22_text(const TetMesh& mesh);
std::string gmsh41_text(const TetMesh& mesh);

TetMesh read_tetgen(std::string_view node_bytes, std::string_view ele_bytes, const std::string& name);

TetMesh read_vtu(std::string_view bytes, const std::string& name);
std::string vtu_text(const TetMesh& mesh);

}  // namespace klang::mesh::detail
