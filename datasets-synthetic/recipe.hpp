#pragma once
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::datasets {

/// One made recording with its truth.
struct SyntheticRecording {
  std::string name;
  audio::Signal signal;
  std::vector<double> frequency_hz, decay_per_s, amplitude,
      phase_rad;  ///< true partials, at the first strike
  std::vector<double> strikes_s;
};

struct Dataset {
  std::vector<SyntheticRecording> recordings;
  std::string truth_json;     ///< material, dimensions, damping, partials, noise level, seed, version
  std::string specimen_toml;  ///< ready for klang fit, with the paths of the recordings as written; empty for drops
  std::vector<std::pair<std::string, std::string>>
      files;  ///< more text files, name and content: of drops, how each bubble rose
};

/// Makes the recordings of a recipe (docs/recipes.md). Same recipe and seed: same bits, on any number of
/// threads.
Dataset make_dataset(const std::filesystem::path& recipe_toml, std::uint64_t seed, Monitor& monitor = silent_monitor());
Dataset make_dataset_from_text(std::string_view toml, const std::string& name, std::uint64_t seed,
                               Monitor& monitor = silent_monitor());

}  // namespace klang::datasets
