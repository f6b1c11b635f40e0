#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "apps/kit/thermal_option.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/bubble/bubble_document.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

namespace drops = fit::bubble;

struct FitOptions {
  std::string recording, output, rise, band = "200:20000", thermal = "leighton";
  std::optional<double> phi0_m;
  drops::BubbleSearchOptions search;
};

int run_fit(FitOptions options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  options.search.band = parse_band("--band-hz", options.band);
  options.search.theory = thermal_theory(options.thermal);
  options.search.validate();
  drops::PitchFitOptions pitch_options;
  if (options.phi0_m) pitch_options.phi0_m = checked("command line", "--phi0-m", *options.phi0_m, -1.0, -1e-5);
  const std::vector<drops::BubbleRise> rises =
      options.rise.empty() ? std::vector<drops::BubbleRise>{} : drops::read_rises(options.rise);
  const audio::Signal recording = audio::read_sound(options.recording);
  std::unique_ptr<OutputDirectory> out;
  if (!options.output.empty()) out = std::make_unique<OutputDirectory>(options.output);

  const drops::BubbleSearchResult found = drops::find_bubbles(recording, options.search, monitor);
  const drops::PitchFitResult pitch = drops::fit_pitch(found, rises, options.search, pitch_options, monitor);

  std::vector<std::filesystem::path> inputs = {options.recording};
  if (!options.rise.empty()) inputs.emplace_back(options.rise);
  const nlohmann::json used = {{"band_hz", {options.search.band.low_hz, options.search.band.high_hz}},
                               {"min_snr_db", options.search.min_snr_db},
                               {"max_bubbles", options.search.max_bubbles},
                               {"max_work", options.search.max_work},
                               {"amplitude_exponent", options.search.amplitude_exponent},
                               {"thermal", options.thermal},
                               {"phi0_m", json_number(pitch_options.phi0_m)}};
  drops::BubblesDocument document =
      drops::bubbles_document(make_header("bubbles", "", common, used, inputs), found, pitch, options.search);
  document.name = std::filesystem::path(options.recording).stem().string();
  document.duration_s = recording.duration_s();
  document.sample_rate_hz = recording.sample_rate_hz;
  document.n_channels = static_cast<int>(recording.n_channels());
  if (out) document.files = {"recording.wav", "resynthesis.wav"};
  const nlohmann::json json = json_of(document);
  if (out) {
    audio::Signal fitted = found.mono;
    fitted.samples = drops::render(found.found, found.mono.n_frames(), found.mono.sample_rate_hz);
    audio::write_sound(out->staging() / "recording.wav", found.mono);
    audio::write_sound(out->staging() / "resynthesis.wav", fitted);
    write_file(out->staging() / "bubbles.json", json_text(json));
    const auto report = reports::write_report(out->staging() / "bubbles.json", {}, monitor);
    for (const std::string& warning : report.warnings) warn(warning);
    out->commit();
  }
  write_json(common, json);

  say(common, "%s: %.2f s at %g Hz, %zu bubble(s), %zu other ring(s)\n", options.recording.c_str(),
      recording.duration_s(), recording.sample_rate_hz, document.bubbles.size(), document.rejected.size());
  say(common, "%9s %11s %11s %9s %11s %11s %9s %7s\n", "onset_s", "start_hz", "end_hz", "decay/s", "theory/s",
      "radius_mm", "std_um", "snr_db");
  std::size_t n_bubbles = 0, n_rejected = 0;  // in order of onset, whatever they are
  for (const drops::FoundBubble& b : found.found) {
    const drops::BubbleRecord& row = b.is_bubble() ? document.bubbles[n_bubbles++] : document.rejected[n_rejected++];
    say(common, "%9.4f %11.1f %11.1f %9.1f %11.1f %11.4f %9.2g %7.1f  %s\n", row.onset_s, row.frequency_start_hz,
        row.frequency_end_hz, row.decay_per_s, b.theory_decay_per_s, 1e3 * b.radius_m,
        1e6 * b.radius_std_m.value_or(0.0), b.snr_db,
        b.verdict == drops::BubbleVerdict::kBubble ? "" : row.verdict.c_str());
  }
  if (!pitch.message.empty()) say(common, "pitch: %s\n", pitch.message.c_str());
  for (const auto* list : {&pitch.parameters, &pitch.identifiable})
    for (const drops::PitchNumber& n : *list)
      if (n.determined)
        say(common, "  %s = %.5g +- %.2g (95 %%: %.5g to %.5g)\n", n.name.c_str(), *n.value, *n.standard_deviation,
            *n.low95, *n.high95);
  if (out) say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  for (const std::string& warning : document.header.warnings) warn(warning);
  if (document.header.status == "ok") return kDone;
  say(common, "REFUSED: no recording of bubbles: %s\n", document.header.message.value_or("").c_str());
  return kNumericalFailure;
}

}  // namespace

Subcommand add_bubble_fit(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* app =
      group.add_subcommand("fit", "Bubbles in a recording of water drops: radius, damping, onset, pitch constants");
  app->add_option("recording", options->recording, "WAV, FLAC, OGG, MP3 or AIFF")->required();
  add_band_option(*app, common, options->band);
  add_fields(*app, common, options->search, {{"min_snr_db"}, {"max_bubbles"}, {"max_work"}, {"amplitude_exponent"}});
  add_thermal_option(*app, options->thermal);
  app->add_option(
      "--rise", options->rise,
      "How the bubbles rose: CSV onset_s,phi_m,speed_m_s or onset_s,time_s,phi_m (phi negative in the liquid)");
  app->add_option("--phi0-m", options->phi0_m, "phi0 of the pitch model, where it is known: separates K_delta and eta");
  app->add_option("-o,--output", options->output, "Folder for report.html, resynthesis and bubbles.json");
  app->footer(
      "Examples:\n"
      "  klang bubble fit drops.wav --json d.json -o drops-report\n"
      "  klang bubble fit drops.wav --rise rise.csv --phi0-m -0.01\n"
      "Exit code 3: the recording as a whole is none of bubbles; the result says why and what was found all the same.");
  return {app,
          [options, &common] { return run_fit(*options, common); },
          {result_kind<fit::bubble::BubblesDocument>("bubbles", "bubbles.json of `klang bubble fit`")}};
}

}  // namespace klang::apps
