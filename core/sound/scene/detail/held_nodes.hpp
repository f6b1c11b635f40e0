#pragma once
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// Nodes of a body's mesh that a hold of the scene moves.
struct HeldNodes {
  const SceneHold* hold = nullptr;
  std::vector<int> nodes;
};

/// The holds of a body in the scene's order.
/// @throws InputError that names the hold: no node there, a place away from the body, a node that two holds have
std::vector<HeldNodes> held_nodes_of(const Scene& scene, int row, const mesh::TetMesh& mesh);

}  // namespace klang::scene::detail
