#pragma once
#include <CLI/App.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/kit/strike_options.hpp"
#include "core/sound/audio/signal.hpp"
#include "validate/regression/sound_description.hpp"

namespace klang::apps {

/// What make and check take: recordings, or modal models that are struck.
struct RegressSoundOptions {
  std::vector<std::string> sounds;
  std::string band = "50:18000";
  double max_duration_s = validate::DescriptionOptions{}.max_duration_s;
  double min_snr_db = validate::DescriptionOptions{}.min_snr_db;
  DampingOptions damping;
  std::vector<std::string> strikes;
  double model_duration_s = 2.0;
  double model_rate_hz = 48000.0;

  void add_to(CLI::App& app);
  validate::DescriptionOptions description() const;  ///< checked
  nlohmann::json used() const;
};

/// A recording, or a modal model (.vtu) that is struck.
audio::Signal read_sound_or_model(const std::string& path, const RegressSoundOptions& options);

}  // namespace klang::apps
