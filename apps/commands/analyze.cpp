#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/analyze_responses.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/frf/response_set.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct AnalyzeOptions {
  std::string recording;
  std::string band = "20:20000";
  fit::RingdownOptions ringdown;  ///< but for its band
  std::string output;
  std::string csv;
  double a4_hz = audio::kConcertPitchHz;
  bool bell = false;
  std::string modes;
  bool band_given = false;
};

/// What stands behind a row: "  weak  beats 1.32 Hz".
std::string remarks_on(const fit::Partial& partial) {
  std::string words;
  if (!partial.decay_per_s) words += "  too short to tell";
  if (partial.kind == fit::PartialKind::kWeak) words += "  weak";
  if (!partial.stage.empty()) words += "  " + partial.stage + " of two stages";
  if (partial.beat_hz) {
    char text[40];
    std::snprintf(text, sizeof text, "  beats %.3g Hz", *partial.beat_hz);
    words += text;
  }
  return words;
}

void print_partials(const fit::AnalysisDocument& document, const CommonOptions& common) {
  say(common, "%14s %10s %12s %10s %11s %9s  %s\n", "frequency_hz", "std_hz", "decay_per_s", "std_per_s",
      "amplitude_db", "t60_s", "note cents");
  for (const fit::Partial& p : document.partials) {
    const double level_db = 20.0 * std::log10(p.amplitude.value_or(0.0));
    if (!p.decay_per_s) {
      say(common, "%14.4f %10.2g %12s %10s %11.1f %9s  %-4s %+5.1f%s\n", p.frequency_hz,
          p.frequency_std_hz.value_or(0.0), "-", "-", level_db, "-", p.note.c_str(), p.cents.value_or(0.0),
          remarks_on(p).c_str());
      continue;
    }
    say(common, "%14.4f %10.2g %12.4f %10.2g %11.1f %9.3f  %-4s %+5.1f%s\n", p.frequency_hz,
        p.frequency_std_hz.value_or(0.0), *p.decay_per_s, p.decay_std_per_s.value_or(0.0), level_db,
        std::log(1000.0) / *p.decay_per_s, p.note.c_str(), p.cents.value_or(0.0), remarks_on(p).c_str());
  }
}

void print_bell(const fit::Bell& bell, double a4_hz, const CommonOptions& common) {
  const auto print = [&](const char* name, const std::optional<double>& frequency_hz) {
    if (!frequency_hz) return say(common, "%-12s %12s\n", name, "not found");
    const audio::NearestNote note = audio::nearest_note(*frequency_hz, a4_hz);
    say(common, "%-12s %12.3f Hz  %-4s %+5.1f cents\n", name, *frequency_hz, note.name.c_str(), note.cents);
  };
  print("hum", bell.hum_hz);
  print("prime", bell.prime_hz);
  print("tierce", bell.tierce_hz);
  print("quint", bell.quint_hz);
  print("nominal", bell.nominal_hz);
  print("strike note", bell.strike_note_hz);
}

int run_analyze(const AnalyzeOptions& options, const CommonOptions& given) {
  CommonOptions common = given;
  common.table_on_stdout = options.csv == "-";
  if (common.table_on_stdout && common.json == "-")
    throw InputError("--csv", "and --json both want standard output", "-", "a file for one of them");
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  if (fit::is_response_file(options.recording)) {
    if (options.bell) throw InputError("--bell", "goes with recordings, not with responses", options.recording);
    return run_analyze_responses({options.recording, options.output, options.csv, options.modes, !options.band_given,
                                  parse_band("--band-hz", options.band), options.a4_hz},
                                 common);
  }
  if (!options.modes.empty())
    throw InputError("--modes", "goes with responses at several places", options.recording,
                     ".uff, .unv, .uf58 or .mat");
  TerminalMonitor monitor(common.quiet);
  fit::RingdownOptions ringdown = options.ringdown;
  ringdown.band = parse_band("--band-hz", options.band);
  ringdown.validate();
  std::unique_ptr<OutputDirectory> out;
  const audio::Signal recording = audio::read_sound(options.recording);
  if (!options.output.empty()) out = std::make_unique<OutputDirectory>(options.output);

  const fit::RingdownResult result = fit::identify_ringdown(recording, ringdown, monitor);
  if (!result.usable())
    throw NumericalError(
        options.recording + ": " + result.message +
        (result.status == fit::RingdownStatus::kUnexplained ? " (--accept-unexplained takes them all the same)" : ""));

  const nlohmann::json used = {{"band_hz", {ringdown.band.low_hz, ringdown.band.high_hz}},
                               {"max_partials", ringdown.max_partials},
                               {"min_snr_db", ringdown.min_snr_db},
                               {"accept_unexplained", ringdown.accept_unexplained},
                               {"a4_hz", options.a4_hz},
                               {"bell", options.bell}};
  fit::AnalysisDocument document =
      fit::analysis_document(make_header("analysis", "ok", common, used, {options.recording}), result, options.a4_hz);
  if (options.bell) {
    document.bell = fit::name_bell(fit::without_shapes(document.partials), options.a4_hz);
    if (!document.bell->found())
      document.header.warnings.emplace_back("--bell: the partials do not stand as a bell's do; none of them is named");
  }
  document.name = std::filesystem::path(options.recording).stem().string();
  document.duration_s = recording.duration_s();
  document.n_channels = static_cast<int>(recording.n_channels());
  if (out) document.files = {"recording.wav", "resynthesis.wav"};
  const nlohmann::json json = json_of(document);
  if (out) {
    audio::write_sound(out->staging() / "recording.wav", recording);
    audio::write_sound(out->staging() / "resynthesis.wav", fit::resynthesise(result, recording.n_frames()));
    write_file(out->staging() / "analysis.json", json_text(json));
    const auto report = reports::write_report(out->staging() / "analysis.json", {}, monitor);
    for (const std::string& warning : report.warnings) warn(warning);
    out->commit();
  }
  if (!options.csv.empty())
    write_table(options.csv, fit::partial_csv({fit::without_shapes(document.partials), options.recording}));
  write_json(common, json);

  for (const std::string& warning : document.header.warnings) warn(warning);
  say(common, "%s: %.2f s at %g Hz, %zu strike(s), %zu partials", options.recording.c_str(), recording.duration_s(),
      recording.sample_rate_hz, result.strikes_s.size(), result.partials.partials.size());
  if (result.explained_energy) say(common, ", %.1f %% of the energy explained", 100.0 * *result.explained_energy);
  say(common, "\n");
  print_partials(document, common);
  if (document.bell && document.bell->found()) print_bell(*document.bell, options.a4_hz, common);
  if (out) say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_analyze(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<AnalyzeOptions>();
  CLI::App* app = program.add_subcommand("analyze", "Partials of a recording with their standard deviations");
  app->add_option("recording", options->recording,
                  "WAV, FLAC, OGG, MP3 or AIFF; FRFs and free decays at several places: .uff, .unv (dataset 58), .mat")
      ->required();
  add_band_option(*app, common, options->band);
  add_fields(*app, common, options->ringdown, {{"max_partials"}, {"min_snr_db"}, {"accept_unexplained"}});
  app->add_option("-o,--output", options->output, "Folder for report.html, resynthesis and pictures");
  app->add_option("--csv", options->csv, "Write the partials as CSV, which klang fit reads (- for standard output)");
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, by which the partials have their notes, 300 to 600")
      ->capture_default_str();
  app->add_option("--modes", options->modes,
                  "Of responses: modal model (.vtu) whose shapes the measured ones are held against (MAC)");
  app->add_flag("--bell", options->bell, "Name a bell's partials: hum, prime, tierce, quint, nominal, strike note");
  app->footer(
      "Examples:\n"
      "  klang analyze tap.wav --json tap.json\n"
      "  klang analyze bell.flac --bell --a4-hz 443 --band-hz 100:8000 -o bell-report\n"
      "  klang analyze tap.wav --csv - | head -3\n"
      "  klang analyze hammer.uff --modes modes.vtu -o modal-test");
  return {app,
          [options, app, &common] {
            options->band_given = app->count("--band-hz") > 0;
            return run_analyze(*options, common);
          },
          {result_kind<fit::AnalysisDocument>("analysis", "analysis.json of `klang analyze`")}};
}

}  // namespace klang::apps
