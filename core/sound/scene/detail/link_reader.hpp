#pragma once
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

/// Ties the bodies of a world that stand as the scene says. @throws InputError where a cord is too short for its ends
void add_links(const std::vector<SceneLink>& links, rigid::RigidWorld& world);

}  // namespace klang::scene::detail
