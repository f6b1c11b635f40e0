#pragma once
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/support.hpp"
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

/// @throws InputError that names the joint: its place is farther from the body than a tenth of the body's size
void require_near(const SceneJoint& joint, double far_m, double size_m);

/// How the world keeps a modal body: by holds, and by joints to the world.
enum class KeptBy { kNothing, kStillPlaces, kMovingPlaces };
KeptBy kept_by(const Scene& scene, const SceneBody& body);

/// What keeps it still, as text: bodies of one text are kept at the same places.
std::string kept_key(const Scene& scene, const SceneBody& body);

/// The support that still holds and joints to the world are; the mesh gets a set of the nodes where no region says it. Free: they are none.
/// @throws InputError as held_nodes_of()
solid::Support still_support_of(const Scene& scene, const SceneBody& body, mesh::TetMesh& mesh);

}  // namespace klang::scene::detail
