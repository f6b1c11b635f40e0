#pragma once
#include "core/physics/entrainment/radii.hpp"
#include "core/sound/liquid_scene/flow_stage.hpp"

namespace klang::liquid_scene {

/// The bubbles that the flow's frames make and the scripted ones, with their paths: bubbles.csv, and bubbles.trk (trackedBubInfo) for the
/// stages after this. The only stage that draws by chance.
void run_bubbles(StageRun& run);

/// How large new bubbles are, as [entrainment] says. @throws InputError for a recording that cannot be read
entrainment::RadiusDistribution radii_of(const EntrainmentTable& table);

/// How many bubbles a flow that is done would entrain at a rate of attempts, all else as the scene has it.
std::size_t count_births(const LiquidScene& scene, const RunFolder& folder, std::size_t n_frames, std::uint64_t seed,
                         double attempts_per_m2_s, Monitor& monitor);

}  // namespace klang::liquid_scene
