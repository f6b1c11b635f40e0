#pragma once
#include <map>

#include "core/physics/bubble/time_series.hpp"
#include "core/sound/liquid_scene/flow_stage.hpp"

namespace klang::liquid_scene {

/// How every bubble of bubbles.trk is heard: transfer.csv (bubble, time_s, frequency_hz, re, im; pressure in Pa per m at the listener).
void run_transfer(StageRun& run);

/// The rows of transfer.csv of each bubble.
std::map<std::int64_t, std::vector<bubble::TransferSeries::Row>> read_transfers(const std::filesystem::path& file);

}  // namespace klang::liquid_scene
