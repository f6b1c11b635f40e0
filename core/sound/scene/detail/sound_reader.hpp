#pragma once
#include <vector>

#include "core/foundation/config/toml_table.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene::detail {

/// The keys of [sound] and [frames], and those of a floor's sound.
std::vector<TomlField> sound_fields();
std::vector<TomlField> floor_sound_fields();

/// @param folder  that files are relative to
/// @throws InputError
void read_sound(const TomlTable& table, const std::filesystem::path& folder, SceneSoundOptions& sound);
FloorSound read_floor_sound(const TomlTable& table);
SceneFrames read_frames(const TomlTable& table);

}  // namespace klang::scene::detail
