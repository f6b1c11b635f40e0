#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Refuses a mesh of which a corner lies on an edge or a face that it is no corner of: the neighbours there share no faces, the body is cracked in the
/// mesh already.
/// @throws InputError that names the node; a face that more than two elements share
void refuse_hanging_nodes(const TetMesh& mesh);

}  // namespace klang::mesh
