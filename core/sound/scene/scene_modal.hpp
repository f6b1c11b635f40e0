#pragma once
#include <cstdint>
#include <memory>

#include "core/sound/scene/scene_bodies.hpp"
#include "core/sound/scene/scene_motion.hpp"

namespace klang::scene {

class CrackingBodies;

/// The modal bodies of a scene (H03): a rigid frame and elastic modes, which the same forces drive.
///
/// Within each step of the rigid world they make smaller ones, twenty per period of the highest mode kept: frame and modes go on freely
/// (modes exactly), then corners of the surface that are below the floor get impulses that end the approach, with the material's restitution where they
/// touch anew: a linear complementarity problem, or with friction Coulomb's cone, over all of them at once. What impulses take is booked. Held places get the
/// impulses that bring them to their path at the end of the next small step. Gravity and the frame's acceleration do not drive modes (W^T M R = 0); centrifugal forces on
/// modes are left out. Modal bodies feel the floor and holds, no other bodies.
class ModalBodies {
 public:
  /// Takes the rigid stand-ins out of the world. @throws InputError; NumericalError where modes are not found
  ModalBodies(const Scene& scene, rigid::RigidWorld& world, const SceneNotes& notes, Monitor& monitor);
  ~ModalBodies();
  bool any() const;
  void after_step(rigid::RigidWorld& world);
  /// @throws NumericalError that names a modal and a cracking body that meet: they do not feel one another
  void refuse_meeting(const CrackingBodies& cracking) const;
  void add_to(SceneMotion& motion) const;

 private:
  void warn_of_gain() const;
  void warn_of_short_touches() const;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace klang::scene
