#include <CLI/CLI.hpp>
#include <memory>

#include "apps/kit/command_group.hpp"
#include "apps/kit/number_options.hpp"
#include "apps/kit/strike_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "reports/report/report.hpp"
#include "validate/regression/regression.hpp"

namespace klang::apps {
namespace {

/// What make and check take: recordings, or modal models that are struck.
struct SoundOptions {
  std::vector<std::string> sounds;
  std::string band = "50:18000";
  double max_duration_s = validate::DescriptionOptions{}.max_duration_s;
  double min_snr_db = validate::DescriptionOptions{}.min_snr_db;
  DampingOptions damping;
  std::vector<std::string> strikes;
  double model_duration_s = 2.0;
  double model_rate_hz = 48000.0;

  validate::DescriptionOptions description() const {
    validate::DescriptionOptions options;
    options.band = parse_band("--band-hz", band);
    options.max_duration_s = max_duration_s;
    options.min_snr_db = min_snr_db;
    options.validate();
    return options;
  }
  nlohmann::json used() const {
    return {{"band_hz", band},
            {"max_duration_s", max_duration_s},
            {"min_snr_db", min_snr_db},
            {"rayleigh_stiffness_s", damping.rayleigh_stiffness_s},
            {"rayleigh_mass_per_s", damping.rayleigh_mass_per_s},
            {"loss_factor", damping.loss_factor},
            {"model_duration_s", model_duration_s},
            {"model_rate_hz", model_rate_hz}};
  }
};

audio::Signal sound_of_model(const std::string& path, const SoundOptions& options) {
  options.damping.validate();
  modal::SynthesisOptions synthesis;
  synthesis.duration_s = checked("command line", "--model-duration-s", options.model_duration_s, 0.1, 60.0);
  synthesis.sample_rate_hz = checked("command line", "--model-rate-hz", options.model_rate_hz, 1000.0, 768000.0);
  const modal::ModalModel model = modal::read_modal_model(path);
  const Eigen::VectorXd decays = decay_per_s(options.damping, model);
  if (!(decays.size() > 0 && decays.minCoeff() > 0.0)) {
    throw InputError(path, "a model needs damping to be held against a sound", "",
                     "--rayleigh-stiffness-s, --rayleigh-mass-per-s or --loss-factor");
  }
  audio::Signal sound =
      modal::synthesise(model, decays, read_strikes(options.strikes, options.model_duration_s, model), synthesis);
  const double peak = sound.samples.cwiseAbs().maxCoeff();
  if (!(peak > 0.0)) throw InputError(path, "the strikes excite no mode");
  sound.samples *= 0.5 / peak;
  sound.origin = path;
  return sound;
}

audio::Signal read_sound_or_model(const std::string& path, const SoundOptions& options) {
  if (std::filesystem::path(path).extension() == ".vtu") return sound_of_model(path, options);
  return audio::read_sound(path);
}

void add_sound_options(CLI::App& app, SoundOptions& options) {
  app.add_option("--band-hz", options.band, "LOW:HIGH in Hz in which partials are looked for")->capture_default_str();
  app.add_option("--max-duration-s", options.max_duration_s, "Levels are kept for so long after the onset")
      ->capture_default_str();
  app.add_option("--min-snr-db", options.min_snr_db, "A partial stands this far above the noise")
      ->capture_default_str();
  add_damping_options(app, options.damping);
  add_strike_option(app, options.strikes);
  app.add_option("--model-duration-s", options.model_duration_s, "Length of a model's sound")->capture_default_str();
  app.add_option("--model-rate-hz", options.model_rate_hz, "Sample rate of a model's sound")->capture_default_str();
}

struct MakeCommand {
  SoundOptions sound;
  std::string output;
};

int run_make(const MakeCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  const validate::DescriptionOptions description = command.sound.description();
  std::vector<validate::SoundDescription> takes;
  std::vector<std::filesystem::path> inputs;
  for (const std::string& path : command.sound.sounds) {
    takes.push_back(validate::describe(read_sound_or_model(path, command.sound), description, monitor));
    inputs.emplace_back(path);
    for (const std::string& warning : takes.back().warnings) warn(path + ": " + warning);
  }
  monitor.throw_if_stopped();
  const validate::ReferenceSpectrum reference = validate::make_reference(takes);
  nlohmann::json json = result_header("reference_spectrum", "done", common, command.sound.used(), inputs);
  json.update(validate::to_json(reference));
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

struct CheckCommand {
  std::string reference;
  SoundOptions sound;
  std::string output;
  bool no_levels = false;
  validate::RegressionOptions options;
};

int run_check(const CheckCommand& command, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  validate::RegressionOptions options = command.options;
  options.levels = !command.no_levels;
  options.validate();
  const validate::DescriptionOptions description = command.sound.description();
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
               {"catch_decay", options.catch_decay},
               {"floor_cents", options.floor_cents},
               {"floor_decay", options.floor_decay},
               {"floor_level_db", options.floor_level_db},
               {"floor_spectrum_db", options.floor_spectrum_db},
               {"range_db", options.range_db},
               {"levels", options.levels}});
  const bool judged = result.status == validate::RegressionStatus::kJudged;
  nlohmann::json json = result_header("regression",
                                      result.passed() ? "passed"
                                      : judged        ? "not_passed"
                                                      : "nothing_judged",
                                      common, used, {command.reference, path});
  json.update(validate::to_json(result));
  json["name"] = std::filesystem::path(path).filename().string() + " against " +
                 std::filesystem::path(command.reference).filename().string();
  json["reference_origin"] = reference.origin;
  json["reference_ring_10db_s"] = reference.ring_10db_s;
  json["reference_takes"] = reference.n_takes;
  json["warnings"] = described.warnings;
  if (out) {
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
  for (const validate::Claim& claim : result.claims) {
    if (!claim.not_judged.empty()) {
      say(common, "not judged  %-24s %s\n", claim.name.c_str(), claim.not_judged.c_str());
    } else {
      say(common, "%s  %-24s %s: %.4g, tolerance %.3g\n", claim.passed ? "passed    " : "FAILED    ",
          claim.name.c_str(), claim.words.c_str(), claim.measured, claim.tolerance);
    }
  }
  if (result.log_spectral_distance_db)
    say(common, "log-spectral distance %.2f dB, level %+.2f dB\n", *result.log_spectral_distance_db, result.gain_db);
  say(common, "%s: %d of %zu claims failed, %d not judged\n",
      result.passed() ? "passed"
      : judged        ? "NOT PASSED"
                      : "NOT PASSED (no partial could be judged)",
      result.n_failed(), result.claims.size(), result.n_not_judged());
  if (out) say(common, "report: %s\n", (std::filesystem::path(command.output) / "report.html").c_str());
  return result.passed() ? kDone : kCheckNotPassed;
}

Subcommand add_make(CLI::App& group, CommonOptions& common) {
  auto command = std::make_shared<MakeCommand>();
  CLI::App* app =
      group.add_subcommand("make", "A reference spectrum from recordings of one object, or from a modal model");
  app->add_option("sounds", command->sound.sounds, "WAV, FLAC, OGG or AIFF of one strike each, or a modal model (.vtu)")
      ->required();
  app->add_option("-o,--output", command->output, "Reference file (.json)")->required();
  add_sound_options(*app, command->sound);
  app->footer(
      "Several takes give tolerances by their scatter; one take gives those of its noise alone.\n"
      "Examples:\n"
      "  klang regress make tap1.wav tap2.wav tap3.wav -o bell.json\n"
      "  klang regress make bar.vtu --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 2 -o bar.json");
  return {app, [command, &common] { return run_make(*command, common); }};
}

Subcommand add_check(CLI::App& group, CommonOptions& common) {
  auto command = std::make_shared<CheckCommand>();
  CLI::App* app =
      group.add_subcommand("check", "Hold a recording or a modal model against a reference spectrum; page, JUnit XML");
  app->add_option("reference", command->reference, "File from klang regress make")->required();
  app->add_option("sound", command->sound.sounds, "WAV, FLAC, OGG or AIFF of a strike, or a modal model (.vtu)")
      ->required()
      ->expected(1);
  app->add_option("-o,--output", command->output, "Folder for regression.json, junit.xml and report.html");
  validate::RegressionOptions& options = command->options;
  app->add_option("--false-alarm-rate", options.false_alarm_rate, "Of a whole comparison")->capture_default_str();
  app->add_option("--catch-cents", options.catch_cents, "Not judged: partials too weak to show a shift of this much")
      ->capture_default_str();
  app->add_option("--catch-decay", options.catch_decay, "Not judged: decays too uncertain to show this relative change")
      ->capture_default_str();
  app->add_option("--floor-cents", options.floor_cents, "Least tolerance of a frequency")->capture_default_str();
  app->add_option("--floor-decay", options.floor_decay, "Least relative tolerance of a decay")->capture_default_str();
  app->add_option("--floor-level-db", options.floor_level_db, "Least tolerance of a third-octave level")
      ->capture_default_str();
  app->add_option("--floor-spectrum-db", options.floor_spectrum_db, "Least tolerance of the log-spectral distance")
      ->capture_default_str();
  app->add_option("--range-db", options.range_db, "Weaker partials may be missing or superfluous")
      ->capture_default_str();
  app->add_flag("--no-levels", command->no_levels, "Judge partials only: the strike was another one");
  add_sound_options(*app, command->sound);
  app->footer(
      "Examples:\n"
      "  klang regress check bell.json today.wav -o verdict\n"
      "  klang regress check bar.json bar-new.vtu --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 2 --json -\n"
      "  klang regress check bell.json hit-elsewhere.wav --no-levels\n"
      "Exit code 1: a claim failed, or no partial could be judged.");
  return {app, [command, &common] { return run_check(*command, common); }};
}

}  // namespace

Subcommand add_regress(CLI::App& program, CommonOptions& common) {
  return add_group(program, common, "regress", "Recordings and models against a reference spectrum",
                   {add_make, add_check});
}

}  // namespace klang::apps
