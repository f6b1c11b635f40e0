#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/commands/regress_sound.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "reports/report/report.hpp"
#include "validate/regression/regression_document.hpp"

namespace klang::apps {
namespace {

struct CheckCommand {
  std::string reference;
  RegressSoundOptions sound;
  std::string output;
  validate::RegressionOptions options;
};

/// What the page plays: the sound, and the reference's partials at its onset and level.
void write_sounds(const std::filesystem::path& folder, const audio::Signal& sound,
                  const validate::SoundDescription& described, const validate::ReferenceSpectrum& reference,
                  const validate::RegressionResult& result) {
  audio::write_sound(folder / "sound.wav", sound);
  audio::write_sound(folder / "reference.wav",
                     validate::rung(reference.table(), std::pow(10.0, result.gain_db / 20.0), described.onset_s,
                                    sound.n_frames(), sound.sample_rate_hz));
}

/// One line per claim; where many fail for one reason, that reason in their place.
void say_claims(const CommonOptions& common, const validate::RegressionResult& result) {
  for (const validate::Claim& claim : result.claims) {
    if (!claim.not_judged.empty()) {
      if (result.reason.empty()) say(common, "not judged  %-24s %s\n", claim.name.c_str(), claim.not_judged.c_str());
    } else if (result.reason.empty() || claim.passed) {
      say(common, "%s  %-24s %s: %.4g, tolerance %.3g\n", claim.passed ? "passed    " : "FAILED    ",
          claim.name.c_str(), claim.words.c_str(), claim.measured, claim.tolerance);
    }
  }
  if (!result.reason.empty()) say(common, "FAILED      %s\n", result.reason.c_str());
  if (result.log_spectral_distance_db)
    say(common, "log-spectral distance %.2f dB, level %+.2f dB\n", *result.log_spectral_distance_db, result.gain_db);
  const bool judged = result.status == validate::RegressionStatus::kJudged;
  say(common, "%s: %d of %zu claims failed, %d not judged\n",
      result.passed() ? "passed"
      : judged        ? "NOT PASSED"
                      : "NOT PASSED (no partial could be judged)",
      result.n_failed(), result.claims.size(), result.n_not_judged());
}

int run_check(const CheckCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const validate::RegressionOptions& options = command.options;
  options.validate();
  const validate::DescriptionOptions description = command.sound.checked_description();
  const std::string& path = command.sound.sounds.front();
  const validate::ReferenceSpectrum reference =
      validate::parse_reference(read_file(command.reference, std::size_t{256} << 20), command.reference);
  const audio::Signal sound = read_sound_or_model(path, command.sound);
  std::unique_ptr<OutputDirectory> out;
  if (!command.output.empty()) out = std::make_unique<OutputDirectory>(command.output);
  const validate::SoundDescription described = validate::describe(sound, description, monitor);
  const validate::RegressionResult result = validate::compare(reference, described, options);

  nlohmann::json used = command.sound.used();
  used.update({{"false_alarm_rate", options.false_alarm_rate},
               {"catch_cents", options.catch_cents},
               {"shift_false_alarm_rate", options.shift_false_alarm_rate},
               {"catch_shift_cents", options.catch_shift_cents},
               {"catch_decay", options.catch_decay},
               {"floor_cents", options.floor_cents},
               {"floor_decay", options.floor_decay},
               {"floor_level_db", options.floor_level_db},
               {"floor_spectrum_db", options.floor_spectrum_db},
               {"range_db", options.range_db},
               {"levels", options.levels}});
  validate::RegressionDocument document = validate::regression_document(
      make_header("regression", "", common, used, {command.reference, path}), result, reference);
  document.name = std::filesystem::path(path).filename().string() + " against " +
                  std::filesystem::path(command.reference).filename().string();
  document.header.warnings = described.warnings;
  if (out) document.files = {"sound.wav", "reference.wav"};
  const nlohmann::json json = json_of(document);
  if (out) {
    write_sounds(out->staging(), sound, described, reference, result);
    write_file(out->staging() / "regression.json", json_text(json));
    write_file(out->staging() / "junit.xml",
               validate::junit_xml("klang regress " + std::filesystem::path(path).filename().string(), result.claims));
    const auto report = reports::write_report(out->staging() / "regression.json", {}, monitor);
    for (const std::string& warning : report.warnings) warn(warning);
    monitor.throw_if_stopped();
    out->commit();
  }
  write_json(common, json);

  for (const std::string& warning : described.warnings) warn(path + ": " + warning);
  say_claims(common, result);
  if (out) say(common, "report: %s\n", (std::filesystem::path(command.output) / "report.html").c_str());
  return result.passed() ? kDone : kCheckNotPassed;
}

}  // namespace

Subcommand add_regress_check(CLI::App& group, CommonOptions& common) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App* app =
      group.add_subcommand("check", "Hold a recording or a modal model against a reference spectrum; page, JUnit XML");
  app->add_option("reference", command->reference, "File from klang regress make")->required();
  app->add_option("sound", command->sound.sounds, "WAV, FLAC, OGG or AIFF of a strike, or a modal model (.vtu)")
      ->required()
      ->expected(1);
  app->add_option("-o,--output", command->output, "Folder for regression.json, junit.xml, the sounds and report.html");
  add_fields(*app, common, command->options,
             {{"false_alarm_rate"},
              {"catch_cents"},
              {"shift_false_alarm_rate"},
              {"catch_shift_cents"},
              {"catch_decay"},
              {"floor_cents"},
              {"floor_decay"},
              {"floor_level_db"},
              {"floor_spectrum_db"},
              {"range_db"},
              {"levels", "!--no-levels", "Judge partials only: the strike was another one"}});
  command->sound.add_to(*app, common);
  app->footer(
      "Examples:\n"
      "  klang regress check bell.json today.wav -o verdict\n"
      "  klang regress check bar.json bar-new.vtu --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 2 --json -\n"
      "  klang regress check bell.json hit-elsewhere.wav --no-levels\n"
      "Exit code 1: a claim failed, or no partial could be judged.");
  return {app,
          [command, &common] { return run_check(*command, common); },
          {result_kind<validate::RegressionDocument>("regression", "regression.json of `klang regress check`")}};
}

}  // namespace klang::apps
