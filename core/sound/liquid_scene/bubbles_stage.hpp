#pragma once
#include "core/sound/liquid_scene/flow_stage.hpp"

namespace klang::liquid_scene {

/// The bubbles that the flow's frames make and the scripted ones, with their paths: bubbles.csv, and bubbles.trk (trackedBubInfo) for the
/// stages after this. The only stage that draws by chance.
void run_bubbles(StageRun& run);

}  // namespace klang::liquid_scene
