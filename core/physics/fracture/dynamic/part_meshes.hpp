#pragma once
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/dynamic/crack_mesh.hpp"

namespace klang::fracture {

/// Rest shapes of the parts of a body, in the order of CrackMesh::fragments(): its own tetrahedra, straight, with slits where cracks end within a part.
/// @param lips_match  where a later cut has bisected an edge of one lip of a slit alone, the other lip's is bisected too, so that the lips
///                    have the same triangles (where both were cut, across one another's cuts, they may differ in a diagonal)
std::vector<mesh::TetMesh> part_meshes(CrackMesh mesh, bool lips_match);

}  // namespace klang::fracture
