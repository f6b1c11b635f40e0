#pragma once
#include "core/sound/liquid_scene/flow_stage.hpp"

namespace klang::liquid_scene {

/// sound.wav of the bubbles that the folder holds; silence where there are none.
void run_sound(StageRun& run);

}  // namespace klang::liquid_scene
