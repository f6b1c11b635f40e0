#pragma once
#include <functional>
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene {

/// What a user should hear while bodies are built: repairs of meshes, bodies of odd size.
struct SceneNotes {
  std::function<void(const std::string&)> note, warning;
};

/// The mesh of a body for its modes, quadratic. @throws InputError that names the body
mesh::TetMesh mesh_of(const SceneBody& body, const SceneNotes& notes = {}, Monitor& monitor = silent_monitor());

/// A body as the rigid world takes it: mass, centre and inertia of its material, convex parts or a ball, its skin, place and speed.
/// @throws InputError that names the body
rigid::RigidBodySpec rigid_body_of(const Scene& scene, const SceneBody& body, const SceneNotes& notes = {},
                                   Monitor& monitor = silent_monitor());

/// The world of a scene with all its bodies, in the scene's order.
/// @throws InputError also where two bodies overlap by more than 1e-4 of the smaller one's size, or a body and the floor
rigid::RigidWorld world_of(const Scene& scene, const SceneNotes& notes = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::scene
