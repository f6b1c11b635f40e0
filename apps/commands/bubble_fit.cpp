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
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/bubble/pitch_fit.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

namespace drops = fit::bubble;

struct FitOptions {
  std::string recording, output, rise, band = "200:20000", thermal = "leighton";
  std::optional<double> phi0_m;
  drops::BubbleSearchOptions search;
};

nlohmann::json bubble_json(const drops::FoundBubble& b) {
  const double f = std::exp(b.chirp.log_frequency), beta = std::exp(b.chirp.log_decay);
  const double life_s = b.end_s - b.chirp.onset_s;
  std::vector<double> times;
  for (int i = 0; i <= 24; ++i) times.push_back(life_s * i / 24.0);
  nlohmann::json track_s = nlohmann::json::array(), track_hz = nlohmann::json::array();
  double end_hz = f;
  for (const drops::ChirpPoint& point : drops::chirp_track(b.law, b.chirp, times)) {
    track_s.push_back(b.chirp.onset_s + point.time_s);
    track_hz.push_back(point.frequency_hz);
    end_hz = point.frequency_hz;
  }
  const auto spread = [&](int i, double unit = 1.0) {
    return b.covariance ? std::optional(unit * std::sqrt((*b.covariance)(i, i))) : std::nullopt;
  };
  return {{"onset_s", b.chirp.onset_s},
          {"onset_std_s", json_number(spread(2))},
          {"end_s", b.end_s},
          {"rest_s", b.law.rest_s ? json_number(b.chirp.onset_s + *b.law.rest_s) : nlohmann::json(nullptr)},
          {"frequency_start_hz", f},
          {"frequency_start_std_hz", json_number(spread(3, f))},
          {"frequency_end_hz", end_hz},
          {"chirp_rate_per_s", b.chirp.pitch[0]},
          {"chirp_rate_std_per_s", json_number(spread(0))},
          {"chirp_growth_per_s", b.chirp.pitch[1]},
          {"chirp_growth_std_per_s", json_number(spread(1))},
          {"decay_per_s", beta},
          {"decay_std_per_s", json_number(spread(4, beta))},
          {"theory_decay_per_s", b.theory_decay_per_s},
          {"radius_m", b.radius_m},
          {"radius_std_m", json_number(b.radius_std_m)},
          {"amplitude", std::hypot(b.chirp.cosine, b.chirp.sine)},
          {"snr_db", json_number(b.snr_db)},
          {"attack", b.law.soft_attack() ? "soft" : "quick"},
          {"verdict", drops::words(b.verdict)},
          {"track", {{"time_s", track_s}, {"frequency_hz", track_hz}}}};
}

nlohmann::json number_json(const drops::PitchNumber& n, const char* key) {
  nlohmann::json json = {{key, n.name},
                         {"value", json_number(n.value)},
                         {"std", json_number(n.standard_deviation)},
                         {"identifiable", n.determined}};
  json["ci95"] = n.low95 ? nlohmann::json{*n.low95, *n.high95} : nlohmann::json(nullptr);
  return json;
}

/// Damping of bubbles by pitch: what every measured decay is held against.
nlohmann::json theory_json(const drops::BubbleSearchOptions& search) {
  nlohmann::json hz = nlohmann::json::array(), decay = nlohmann::json::array();
  for (double radius_m = 2e-4; radius_m < 0.016; radius_m *= 1.12) {
    const auto at = bubble::bubble_oscillation(radius_m, search.medium, search.theory);
    hz.push_back(at.damped_frequency_hz);
    decay.push_back(at.decay_per_s);
  }
  return {{"frequency_hz", hz}, {"decay_per_s", decay}};
}

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
  const drops::PitchFitResult pitch = drops::fit_pitch(found, rises, options.search, pitch_options);

  std::vector<std::filesystem::path> inputs = {options.recording};
  if (!options.rise.empty()) inputs.emplace_back(options.rise);
  const nlohmann::json used = {{"band_hz", {options.search.band.low_hz, options.search.band.high_hz}},
                               {"min_snr_db", options.search.min_snr_db},
                               {"max_bubbles", options.search.max_bubbles},
                               {"amplitude_exponent", options.search.amplitude_exponent},
                               {"thermal", options.thermal},
                               {"phi0_m", json_number(pitch_options.phi0_m)}};
  nlohmann::json bubbles = nlohmann::json::array(), rejected = nlohmann::json::array();
  for (const drops::FoundBubble& b : found.found) (b.is_bubble() ? bubbles : rejected).push_back(bubble_json(b));
  nlohmann::json json = result_header("bubbles", bubbles.empty() ? "nothing_found" : "ok", common, used, inputs);
  json["name"] = std::filesystem::path(options.recording).stem().string();
  json["duration_s"] = recording.duration_s();
  json["sample_rate_hz"] = recording.sample_rate_hz;
  json["n_channels"] = recording.n_channels();
  json["explained_energy"] = json_number(found.explained_energy);
  json["bubbles"] = bubbles;
  json["rejected"] = rejected;
  json["theory"] = theory_json(options.search);
  json["pitch"] = {{"status", pitch.status == drops::PitchStatus::kFitted      ? "fitted"
                              : pitch.status == drops::PitchStatus::kSoundOnly ? "sound_only"
                                                                               : "failed"},
                   {"message", pitch.message},
                   {"n_bubbles", pitch.n_bubbles},
                   {"parameters", nlohmann::json::array()},
                   {"identifiable", nlohmann::json::array()},
                   {"chi_square_per_datum", pitch.chi_square_per_datum}};
  for (const drops::PitchNumber& n : pitch.parameters) json["pitch"]["parameters"].push_back(number_json(n, "name"));
  for (const drops::PitchNumber& n : pitch.identifiable)
    json["pitch"]["identifiable"].push_back(number_json(n, "combination"));
  if (out) {
    json["files"] = {{"recording", "recording.wav"}, {"resynthesis", "resynthesis.wav"}};
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
      recording.duration_s(), recording.sample_rate_hz, bubbles.size(), rejected.size());
  say(common, "%9s %11s %11s %9s %11s %11s %9s %7s\n", "onset_s", "start_hz", "end_hz", "decay/s", "theory/s",
      "radius_mm", "std_um", "snr_db");
  for (const drops::FoundBubble& b : found.found) {
    const nlohmann::json row = bubble_json(b);
    say(common, "%9.4f %11.1f %11.1f %9.1f %11.1f %11.4f %9.2g %7.1f  %s\n", b.chirp.onset_s,
        row["frequency_start_hz"].get<double>(), row["frequency_end_hz"].get<double>(),
        row["decay_per_s"].get<double>(), b.theory_decay_per_s, 1e3 * b.radius_m, 1e6 * b.radius_std_m.value_or(0.0),
        b.snr_db, b.verdict == drops::BubbleVerdict::kBubble ? "" : drops::words(b.verdict));
  }
  if (!pitch.message.empty()) say(common, "pitch: %s\n", pitch.message.c_str());
  for (const auto* list : {&pitch.parameters, &pitch.identifiable})
    for (const drops::PitchNumber& n : *list)
      if (n.determined)
        say(common, "  %s = %.5g +- %.2g (95 %%: %.5g to %.5g)\n", n.name.c_str(), *n.value, *n.standard_deviation,
            *n.low95, *n.high95);
  if (out) say(common, "report: %s\n", (std::filesystem::path(options.output) / "report.html").c_str());
  return kDone;
}

}  // namespace

Subcommand add_bubble_fit(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* app =
      group.add_subcommand("fit", "Bubbles in a recording of water drops: radius, damping, onset, pitch constants");
  app->add_option("recording", options->recording, "WAV, FLAC, OGG or AIFF")->required();
  add_band_option(*app, common, options->band);
  add_fields(*app, common, options->search, {{"min_snr_db"}, {"max_bubbles"}, {"amplitude_exponent"}});
  add_thermal_option(*app, options->thermal);
  app->add_option(
      "--rise", options->rise,
      "How the bubbles rose: CSV onset_s,phi_m,speed_m_s or onset_s,time_s,phi_m (phi negative in the liquid)");
  app->add_option("--phi0-m", options->phi0_m, "phi0 of the pitch model, where it is known: separates K_delta and eta");
  app->add_option("-o,--output", options->output, "Folder for report.html, resynthesis and bubbles.json");
  app->footer(
      "Examples:\n"
      "  klang bubble fit drops.wav --json d.json -o drops-report\n"
      "  klang bubble fit drops.wav --rise rise.csv --phi0-m -0.01");
  return {app, [options, &common] { return run_fit(*options, common); }};
}

}  // namespace klang::apps
