#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Each straight tetrahedron as eight of an eighth of its volume: four at its corners, and the octahedron between them along the shortest of its
/// diagonals. Middles of edges of the same two places are the same to the last bit. Node sets are left out.
/// @param mesh  of 4-node elements
TetMesh refined(const TetMesh& mesh);

}  // namespace klang::mesh
