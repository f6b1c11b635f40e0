#pragma once
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Puts an imported mesh in order: nodes that no element uses are dropped (node sets follow), elements that
/// run the other way round are turned. Elements need not hang together.
/// @throws InputError naming the first bad element or node (0-based, in the file's order): no elements, index
/// out of range, node not finite, repeated node, no volume, a face shared by three elements or by two on
/// the same side of it (an element that is there twice), mid-nodes of one
/// edge that differ, a curved element folded over
TetMesh checked_import(TetMesh mesh, const std::string& name);

}  // namespace klang::mesh
