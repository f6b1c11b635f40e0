#pragma once
#include <array>
#include <optional>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::detail {

/// The lexicographically first pair of triangles (3 corners) that meet anywhere but in the vertices or the
/// edge they share. Signs are exact for the coordinates given, except for pairs in one plane.
std::optional<std::array<int, 2>> first_self_intersection(const SurfaceMesh& surface);

}  // namespace klang::mesh::detail
