#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace klang::liquid_scene {

/// What a recording says of a scene.
struct SceneMatch {
  double attempts_per_m2_s = 0.0;
  std::string recorded;  ///< result of `klang bubble fit`, as the scene is to name it: [entrainment] radii
  double smallest_m = 0.0, largest_m = 0.0;  ///< limits that leave all of its radii in
  bool with_pitch = false;                   ///< [pitch] from the same result
};

/// The scene with these put in and the files that it names made absolute; comments are lost.
std::string matched_scene_text(std::string_view toml, const std::filesystem::path& base_folder,
                               const SceneMatch& match);

}  // namespace klang::liquid_scene
