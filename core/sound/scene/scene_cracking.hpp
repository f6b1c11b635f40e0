#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/physics/fracture/dynamic/cracker.hpp"
#include "core/sound/scene/scene_bodies.hpp"
#include "core/sound/scene/scene_motion.hpp"

namespace klang::scene {

/// The cracking bodies of a scene: explicit solids that are stepped within each step of the rigid world, on whose bodies they press.
///
/// Nodes that are below the floor or inside a rigid body are pushed out by springs, whose stiffness follows from the step limit
/// (0.1 m/dt^2 of the node's mass), with Coulomb's friction; the rigid body gets the opposite impulse at the node. Cracking bodies
/// whose boxes may meet within a step of the world are stepped together (detail/body_meeting.hpp); with self_contact each feels itself and its own
/// pieces too.
class CrackingBodies {
 public:
  /// Takes the places of the bodies from the world and their rigid stand-ins out of it.
  /// @throws InputError: meshes, materials, holds that contradict each other
  CrackingBodies(const Scene& scene, rigid::RigidWorld& world, std::uint64_t seed, const SceneNotes& notes,
                 Monitor& monitor);
  ~CrackingBodies();
  bool any() const;
  /// After a step of the world. @throws NumericalError where an element inverts
  void after_step(rigid::RigidWorld& world);
  /// Rows of the bodies, and their meshes as they are now.
  std::vector<std::pair<int, const fracture::CrackMesh*>> meshes() const;
  /// Adds what they did to the motion of the rigid bodies: ledger, log, pieces, ends.
  void add_to(SceneMotion& motion) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::scene
