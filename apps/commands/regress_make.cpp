#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/regress_sound.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "validate/regression/reference_document.hpp"
#include "validate/regression/regression.hpp"

namespace klang::apps {
namespace {

struct MakeCommand {
  RegressSoundOptions sound;
  std::string output;
};

int run_make(const MakeCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const validate::DescriptionOptions description = command.sound.checked_description();
  std::vector<validate::SoundDescription> takes;
  std::vector<std::filesystem::path> inputs;
  for (const std::string& path : command.sound.sounds) {
    takes.push_back(validate::describe(read_sound_or_model(path, command.sound), description, monitor));
    inputs.emplace_back(path);
    for (const std::string& warning : takes.back().warnings) warn(path + ": " + warning);
  }
  monitor.throw_if_stopped();
  const validate::ReferenceSpectrum reference = validate::make_reference(takes);
  const nlohmann::json json = json_of(validate::ReferenceDocument{
      make_header("reference_spectrum", "done", common, command.sound.used(), inputs), validate::record_of(reference)});
  write_file(command.output, json_text(json));
  write_json(common, json);
  say(common, "%s: %zu partials of %d take(s), %zu more in some takes only\n", command.output.c_str(),
      reference.partials.size(), reference.n_takes, reference.occasional_hz.size());
  say(common, "%14s %10s %12s %10s %8s\n", "frequency_hz", "std_cents", "decay_per_s", "std_%", "takes");
  for (const validate::ReferencePartial& p : reference.partials) {
    const double std_cents =
        cents(p.partial.frequency_hz + p.partial.frequency_std_hz.value_or(0.0), p.partial.frequency_hz);
    const double decay = p.partial.decay_per_s.value_or(0.0);
    say(common, "%14.4f %10.2g %12.4f %10.2g %8d\n", p.partial.frequency_hz, std_cents, decay,
        decay > 0.0 ? 100.0 * p.partial.decay_std_per_s.value_or(0.0) / decay : 0.0, p.n_takes);
  }
  return kDone;
}

}  // namespace

Subcommand add_regress_make(CLI::App& group, CommonOptions& common) {
  auto command = std::make_shared<MakeCommand>();
  CLI::App* app =
      group.add_subcommand("make", "A reference spectrum from recordings of one object, or from a modal model");
  app->add_option("sounds", command->sound.sounds, "WAV, FLAC, OGG or AIFF of one strike each, or a modal model (.vtu)")
      ->required();
  app->add_option("-o,--output", command->output, "Reference file (.json)")->required();
  command->sound.add_to(*app, common);
  app->footer(
      "Several takes give tolerances by their scatter; one take gives those of its noise alone.\n"
      "Examples:\n"
      "  klang regress make tap1.wav tap2.wav tap3.wav -o bell.json\n"
      "  klang regress make bar.vtu --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 2 -o bar.json");
  return {
      app,
      [command, &common] { return run_make(*command, common); },
      {result_kind<validate::ReferenceDocument>("reference_spectrum", "the file that `klang regress make` writes")}};
}

}  // namespace klang::apps
