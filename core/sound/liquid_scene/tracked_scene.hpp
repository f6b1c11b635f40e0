#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>

#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::liquid_scene {

/// A folder as a run would have left it after its stage bubbles, of bubbles that another program has tracked: scene.toml (a box around them, method
/// half_space: there are no frames), run.json, bubbles.csv, bubbles.trk. `klang scene run DIR/scene.toml -o DIR --stage transfer` sounds.
/// @param listener_m  in our axes, z up and above 0; none: half a metre beside and above the bubbles' middle
/// @throws InputError: a folder that holds a run, a listener that is not in the air
RunDocument import_tracked(const entrainment::TrackedBubbles& tracked, const std::string& name,
                           const std::optional<Eigen::Vector3d>& listener_m, const ResultHeader& header,
                           const RunFolder& folder);

}  // namespace klang::liquid_scene
