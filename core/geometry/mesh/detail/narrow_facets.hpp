#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::detail {

/// How many elements along its edges a surface needs for its narrow parts alone: elements are as small as the part is narrow, so a
/// triangle with an edge of length L, where the surface bends, and a height h over it needs about L / h of them. Narrow triangles within a flat face
/// (a fan) do not count: a mesher joins them.
double elements_along_narrow_facets(const SurfaceMesh& surface);

}  // namespace klang::mesh::detail
