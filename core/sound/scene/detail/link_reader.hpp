#pragma once
#include <functional>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/physics/rigid/rigid_world.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// The bodies that may be named, for messages.
std::vector<std::string> body_names(const Scene& scene);

/// The keys of [[cord]] and [[hinge]].
std::vector<TomlField> link_fields();

/// @throws InputError, also where a body is unknown, deforms, or is tied to itself, or where nothing tied can move
std::vector<SceneLink> read_links(const TomlTable& root, const Scene& scene);

/// Links by the bodies' numbers in the scene, where bodies stand so and are so large; lengths are not checked.
std::vector<rigid::Link> rigid_links(const std::vector<SceneLink>& links,
                                     const std::function<events::Pose(int body)>& pose_of,
                                     const std::function<double(int body)>& size_m);

/// Ties the bodies of a world that stand as the scene says. @throws InputError where a cord is too short for its ends
void add_links(const std::vector<SceneLink>& links, rigid::RigidWorld& world);

}  // namespace klang::scene::detail
