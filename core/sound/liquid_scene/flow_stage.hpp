#pragma once
#include <functional>
#include <optional>
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "core/sound/liquid_scene/run_document.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::liquid_scene {

/// What every stage gets.
struct StageRun {
  const LiquidScene& scene;
  const RunFolder& folder;
  RunDocument& document;   ///< each stage fills its part and writes it where that helps someone who looks
  std::uint64_t seed = 1;  ///< of bubbles and later stages
  double until_s = 0.0;    ///< end of the run
  double checkpoint_s = 60.0;
  bool resume = false;  ///< the stage may go on where an earlier run left it
  Monitor& monitor;
  std::function<void(const std::string&)> warn;
};

/// How far a flow has come that is to be believed.
enum class FlowResult { kDone, kNotConverged, kVolumeLost };

/// Moves the liquid to until_s: frames, fields, flow.csv, a checkpoint every checkpoint_s of wall time and at the end.
/// @throws Interrupted with everything written; InputError for a full disk or a damaged checkpoint
FlowResult run_flow(StageRun& run);

/// Volume drift and pressure beyond which a flow is refused.
inline constexpr double kMostDrift = 0.01;

}  // namespace klang::liquid_scene
