#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/result_header.hpp"
#include "core/sound/scene/scene_bodies.hpp"

namespace klang::scene {

struct CheckedBody {
  std::string name, material, sound;
  double mass_kg = 0.0, volume_m3 = 0.0, size_m = 0.0;
  int n_parts = 0;
  bool fixed = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "as in the scene"}, self.name);
    visit({"material", "as in the scene"}, self.material);
    visit({"sound", "modes, proxy, modes or proxy (by its lowest frequency), or none"}, self.sound);
    visit({"mass_kg", "its mass"}, self.mass_kg);
    visit({"volume_m3", "mass over density"}, self.volume_m3);
    visit({"size_m", "largest distance of a point from the centre of mass, doubled"}, self.size_m);
    visit({"n_parts", "convex parts that collide; 0: a ball"}, self.n_parts);
    visit({"fixed", "it does not move"}, self.fixed);
  }
};

/// What `klang scene check` finds.
struct SceneCheckDocument {
  ResultHeader header;
  std::string name;
  std::vector<CheckedBody> bodies;
  std::optional<int> n_steps;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the scene"}, self.name);
    visit({"bodies", "in the scene's order"}, self.bodies);
    visit({"n_steps", "that a run makes; null: until all rests"}, self.n_steps);
  }
};

/// @throws InputError where a scene without a duration falls for ever: gravity, no floor, and nothing that is fixed, held or tied
void require_rest(const Scene& scene);

/// Builds all bodies, those that deform with their meshes and holds, and looks for whatever can be seen without moving them: overlaps,
/// bodies that are faster than the steps allow (header.warnings: those that gravity makes so before they reach the floor).
/// @param seed  of the meshes of cracking bodies
/// @throws InputError
SceneCheckDocument check_scene(const Scene& scene, std::uint64_t seed = 1, const SceneNotes& notes = {},
                               Monitor& monitor = silent_monitor());

}  // namespace klang::scene
