#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>

#include "apps/commands/synth_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "core/sound/stage/bubble_scene.hpp"

namespace klang::apps {
namespace {

struct SynthOptions {
  std::string scene, output;
  bool unit_transfer = false, constant_pitch = false;
};

constexpr std::size_t kMostListed = 100'000;  // of the bubbles, in the JSON: a million take a gigabyte there

int run_bubble_synth(const SynthOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  stage::BubbleScene scene = stage::read_bubble_scene(options.scene, common.seed);
  if (options.unit_transfer) scene.transfer = stage::SceneTransfer::kUnit;
  if (options.constant_pitch) scene.pitch.kind = bubble::PitchKind::kConstant;
  const auto n_of_no_pitch = std::count_if(scene.bubbles.begin(), scene.bubbles.end(), [](const stage::SceneBubble& b) {
    return b.transfer && !b.transfer->has_frequency();
  });
  if (n_of_no_pitch > 0 && scene.transfer != stage::SceneTransfer::kUnit)
    warn("the transfer_file of " + std::to_string(n_of_no_pitch) +
         " bubble(s) has no frequency_hz: it is taken as it stands at every pitch, though pressure goes with its "
         "square");
  stage::BubbleSound result = stage::synthesise_bubbles(scene, monitor);
  if (result.n_too_high > 0) {
    warn(std::to_string(result.n_too_high) + " bubble(s) are left out: their pitch reaches half of the sample rate");
  }
  if (result.status != stage::BubbleSoundStatus::kDone)
    throw NumericalError("bubble synth: no bubble is heard in this scene");
  const double peak = result.sound.samples.cwiseAbs().maxCoeff();
  const bool unit = scene.transfer == stage::SceneTransfer::kUnit;  // metres, not pascals
  const double gain = unit ? std::pow(10.0, scene.peak_db_re_full_scale / 20.0) / peak
                           : audio::file_gain(peak, scene.peak_db_re_full_scale);
  std::vector<std::string> warnings;
  if (!unit && audio::is_inaudible(peak)) warnings.push_back(audio::inaudible_note(peak));
  for (const std::string& warning : warnings) warn(warning);
  result.sound.samples *= gain;
  audio::write_sound(options.output, result.sound);

  const nlohmann::json used = {{"unit_transfer", unit},
                               {"constant_pitch", scene.pitch.kind == bubble::PitchKind::kConstant}};
  BubbleSynthDocument document;
  document.header = make_header("bubble_synth", "done", common, used, {options.scene});
  document.header.wall_time_s = {{"synthesis", result.wall_time_s}};
  document.header.warnings = warnings;
  document.n_bubbles = static_cast<std::int64_t>(scene.bubbles.size());
  document.n_bubbles_listed = static_cast<std::int64_t>(std::min(scene.bubbles.size(), kMostListed));
  document.n_too_high = static_cast<int>(result.n_too_high);
  document.n_channels = static_cast<int>(result.sound.n_channels());
  document.duration_s = result.sound.duration_s();
  document.sample_rate_hz = result.sound.sample_rate_hz;
  document.gain = gain;
  (unit ? document.peak_displacement_m : document.peak_pressure_pa) = peak;
  if (!unit) document.peak_level_db_re_20upa = 20.0 * std::log10(peak / (std::sqrt(2.0) * kReferencePressurePa));
  for (std::size_t i = 0; i < std::min(scene.bubbles.size(), kMostListed); ++i) {
    const stage::SoundedBubble& b = result.bubbles[i];
    HeardBubbleRecord& bubble = document.bubbles.emplace_back();
    bubble = {scene.bubbles[i].radius_m,
              scene.bubbles[i].birth_s,
              b.frequency_start_hz,
              b.frequency_end_hz,
              b.decay_start_per_s,
              b.amplitude_m,
              std::nullopt,
              std::nullopt};
    (unit ? bubble.peak_displacement_m : bubble.peak_pressure_pa) = b.peak;
  }
  write_json(common, json_of(document));
  say(common, "%s: %.2f s, %zu bubbles, made in %.2f s\n", options.output.c_str(), result.sound.duration_s(),
      scene.bubbles.size(), result.wall_time_s);
  return kDone;
}

}  // namespace

Subcommand add_bubble_synth(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<SynthOptions>();
  CLI::App* app = group.add_subcommand("synth", "Sound of a scene of bubbles, in mono or at two ears");
  app->add_option("scene", options->scene, "Scene (TOML, docs/bubbles.md)")->required();
  app->add_option("-o,--output", options->output, "Sound file (.wav or .flac)")->required();
  app->add_flag("--unit-transfer", options->unit_transfer, "For comparison: |P| = 1 for every bubble");
  app->add_flag("--constant-pitch", options->constant_pitch, "For comparison: no bubble changes its pitch");
  app->footer(
      "Examples:\n"
      "  klang bubble synth datasets-synthetic/scenes/pouring.toml -o pouring.wav --seed 7\n"
      "  klang bubble synth scene.toml -o flat.wav --constant-pitch");
  return {app,
          [options, &common] { return run_bubble_synth(*options, common); },
          {result_kind<BubbleSynthDocument>("bubble_synth", "the result of `klang bubble synth`")}};
}

}  // namespace klang::apps
