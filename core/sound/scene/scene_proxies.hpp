#pragma once
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "core/sound/scene/scene_sound.hpp"

namespace klang::scene {

/// Ellipsoids of the scene's soundbank that are heard in place of bodies (SB section 5): the shape from the body's inertia, the
/// size from its lowest frequency. Their displacements stand at the nodes of the body's own mesh, each at the place of the ellipsoid that
/// soundbank::point_of_place says, so that a proxy is a model of the body like any other.
class SceneProxies {
 public:
  /// Reads the bank where the scene names one. The scene must outlive it.
  /// @throws InputError where a body that it may stand for has another Poisson's ratio than the bank
  explicit SceneProxies(const Scene& scene);
  ~SceneProxies();

  /// Whether a body of the scene, or a piece of it, may be heard by a proxy.
  bool may_stand_for(const SceneBody& body) const;

  /// What is asked for.
  struct Body {
    const SceneBody* of = nullptr;               ///< itself, or what it broke off
    std::string name;                            ///< for notes
    const mesh::SurfaceMesh* surface = nullptr;  ///< of a piece; null: the body itself
    mesh::TetMesh mesh;
  };
  /// The proxy's modes within the scene's band and their radiation; none where the body is heard by its own; a model without modes
  /// for a piece whose lowest frequency is above the band. An ellipsoid of more than twice or less than half the body's size stands
  /// for nothing (a plate thinner than the bank's thinnest, a hollow body): its own modes are heard.
  /// The lowest frequency is that of the body's own modes; of convex shapes and their pieces that of polynomials (modal::lowest_frequency_hz).
  /// @throws InputError; NumericalError; Interrupted
  std::optional<SoundModel> stand_in(const Body& body, const SceneNotes& notes = {},
                                     Monitor& monitor = silent_monitor()) const;

 private:
  struct Bank;
  const Scene& scene_;
  std::unique_ptr<const Bank> bank_;
  mutable std::set<int> warned_speed_;  ///< materials of which a warning says so
};

}  // namespace klang::scene
