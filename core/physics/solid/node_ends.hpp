#pragma once
#include "core/foundation/la/block_ordering.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::solid {

/// Of each free node, the free nodes between which it lies: itself twice for a corner, its edge's ends for a mid-node.
la::NodeEnds node_ends(const mesh::TetMesh& mesh, const AssembledSolid& assembled);

}  // namespace klang::solid
