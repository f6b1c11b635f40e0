#pragma once
#include <CLI/App.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "apps/kit/command.hpp"
#include "apps/kit/strike_options.hpp"
#include "core/sound/audio/signal.hpp"
#include "validate/regression/sound_description.hpp"

namespace klang::apps {

/// What make and check take: recordings, or modal models that are struck.
struct RegressSoundOptions {
  std::vector<std::string> sounds;
  std::string band = "50:18000";
  validate::DescriptionOptions description;  ///< but for its band
  DampingOptions damping;
  std::vector<std::string> strikes;
  double model_duration_s = 2.0;
  double model_rate_hz = 48000.0;

  void add_to(CLI::App& app, CommonOptions& common);
  validate::DescriptionOptions checked_description() const;
  nlohmann::json used() const;
};

/// A recording, or a modal model (.vtu) that is struck.
audio::Signal read_sound_or_model(const std::string& path, const RegressSoundOptions& options);

}  // namespace klang::apps
