#pragma once
#include <string>
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// The keys of [crack], which may stand in a [[body]] too, and of [[hold]]. @param table  lives as long as the program
std::vector<TomlField> crack_fields(const char* table);
std::vector<TomlField> hold_fields();
std::vector<TomlField> joint_fields();

/// @param own  of the body: goes before the scene's. @throws InputError
CrackSettings read_crack(const TomlTable& scene, const TomlTable& own, const SceneMaterial& material,
                         const std::string& place);

/// [modal] of the scene and of the body, which wins.
std::vector<TomlField> modal_fields(const char* table);
ModalSettings read_modal(const TomlTable& scene, const TomlTable& own);

/// @throws InputError, also where a file is missing or a body is neither cracking nor modal
std::vector<SceneHold> read_holds(const TomlTable& root, const Scene& scene, const std::filesystem::path& folder);
/// @throws InputError, also where a body is not modal or joined to itself
std::vector<SceneJoint> read_joints(const TomlTable& root, const Scene& scene);

}  // namespace klang::scene::detail
