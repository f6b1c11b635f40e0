#include "apps/commands/scene_match.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "apps/commands/liquid_run.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "core/sound/liquid_scene/bubbles_stage.hpp"
#include "core/sound/liquid_scene/from_recording.hpp"
#include "core/sound/liquid_scene/matched_scene.hpp"
#include "fit/bubble/bubble_document.hpp"

namespace klang::apps {
namespace {

namespace drops = fit::bubble;

constexpr int kMostRounds = 8;
constexpr double kFirstRate = 1e5, kFewBubbles = 20, kWithin_db = 40.0, kSmear = 0.35;

constexpr const char* kNextDrops = "drops.next.json";

/// What was found in the recording, beside the drops.json of a match before until the new one is known to work.
class NextDrops {
 public:
  NextDrops(const liquid_scene::RunFolder& folder, const std::string& text) : folder_(folder) {
    write_file(folder.file(kNextDrops), text);
  }
  NextDrops(const NextDrops&) = delete;
  NextDrops& operator=(const NextDrops&) = delete;
  ~NextDrops() {
    std::error_code gone;
    std::filesystem::remove(folder_.file(kNextDrops), gone);
  }
  void take() const { std::filesystem::rename(folder_.file(kNextDrops), folder_.file("drops.json")); }

 private:
  const liquid_scene::RunFolder& folder_;
};

struct MatchOptions {
  std::string scene, recording, output, rise, band = "200:20000";
  bool no_sound = false;
  drops::BubbleSearchOptions search;
};

MatchedBubbles summary(std::vector<double> radii, double duration_s) {
  MatchedBubbles result;
  result.n_bubbles = static_cast<std::int64_t>(radii.size());
  result.duration_s = duration_s;
  result.births_per_s = duration_s > 0.0 ? static_cast<double>(radii.size()) / duration_s : 0.0;
  if (radii.empty()) return result;
  std::sort(radii.begin(), radii.end());
  result.radius_mean_m = std::accumulate(radii.begin(), radii.end(), 0.0) / static_cast<double>(radii.size());
  result.radius_median_m = radii[radii.size() / 2];
  return result;
}

std::vector<MatchedQuantile> quantiles(std::vector<double> recorded, std::vector<double> made) {
  std::vector<MatchedQuantile> rows;
  if (recorded.empty() || made.empty()) return rows;
  std::sort(recorded.begin(), recorded.end());
  std::sort(made.begin(), made.end());
  const auto at = [](const std::vector<double>& sorted, double share) {
    return sorted[std::min(sorted.size() - 1, static_cast<std::size_t>(share * static_cast<double>(sorted.size())))];
  };
  for (const double share : {0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95})
    rows.push_back({share, at(recorded, share), at(made, share)});
  return rows;
}

/// Third octaves of both, each re its own sum.
void compare_spectra(const audio::Signal& recorded, const audio::Signal& made, const Band& searched,
                     MatchDocument& document) {
  const double highest = 0.45 * std::min(recorded.sample_rate_hz, made.sample_rate_hz);
  const auto bands = audio::third_octaves({searched.low_hz, std::min(searched.high_hz, highest)});
  const audio::EnergySpectrum theirs(recorded), ours(made);
  double sum_theirs = 0.0, sum_ours = 0.0, loudest = 0.0;
  for (const audio::ThirdOctave& band : bands) {
    sum_theirs += theirs.within(band);
    sum_ours += ours.within(band);
    loudest = std::max(loudest, theirs.within(band));
  }
  double squares = 0.0;
  int count = 0;
  for (const audio::ThirdOctave& band : bands) {
    MatchedBand row{band.centre_hz(), std::nullopt, std::nullopt};
    const double a = theirs.within(band), b = ours.within(band);
    if (a > 0.0) row.recorded_db = 10.0 * std::log10(a / sum_theirs);
    if (b > 0.0) row.made_db = 10.0 * std::log10(b / sum_ours);
    if (row.recorded_db && row.made_db && a > loudest * std::pow(10.0, -0.1 * kWithin_db)) {
      squares += std::pow(*row.recorded_db - *row.made_db, 2);
      ++count;
    }
    document.third_octaves.push_back(row);
  }
  if (count > 0) document.spectrum_difference_db = std::sqrt(squares / count);
}

/// The rate at which the flow entrains about as many bubbles as asked for; births go with the rate.
struct Rate {
  double attempts_per_m2_s = 0.0;
  int n_rounds = 0;
  double missed_by = 0.0;   ///< of the number of bubbles, relative
  bool is_matched = false;  ///< within one bubble or 5 %
};
Rate find_rate(const liquid_scene::LiquidScene& scene, const liquid_scene::RunFolder& folder, std::size_t n_frames,
               double wanted, std::uint64_t seed, Monitor& monitor) {
  Rate best;
  double rate = scene.entrainment.attempts_per_m2_s > 0.0 ? scene.entrainment.attempts_per_m2_s : kFirstRate;
  double least = HUGE_VAL;
  for (int round = 1; round <= kMostRounds; ++round) {
    monitor.throw_if_stopped();
    const auto born = static_cast<double>(count_births(scene, folder, n_frames, seed, rate, monitor));
    best.n_rounds = round;
    if (std::abs(born - wanted) < least) {
      least = std::abs(born - wanted);
      best.attempts_per_m2_s = rate;
    }
    if (least <= std::max(0.5, 0.02 * wanted)) break;
    rate = std::min(rate * (born > 0.0 ? std::clamp(wanted / born, 0.01, 100.0) : 100.0), 1e12);
  }
  best.missed_by = least / wanted;
  best.is_matched = least <= std::max(1.0, 0.05 * wanted);
  if (!(least < wanted))
    throw NumericalError("the flow has no place where it entrains bubbles: no rate of attempts makes the recording's " +
                         to_text(std::round(10.0 * wanted) / 10.0) +
                         " of them ([entrainment] threshold_m_s, or [[entrainment.patch]])");
  return best;
}

/// Radii of the bubbles that the flow entrained: those of [[bubble]] are no match.
std::vector<double> entrained_radii(const liquid_scene::LiquidScene& scene, const liquid_scene::RunFolder& folder,
                                    MatchDocument& document) {
  std::vector<double> radii;
  std::int64_t n_scripted = 0;
  if (folder.read_document().n_bubbles > 0)
    for (const entrainment::BubblePath& path : entrainment::read_tracked_bubbles(folder.file("bubbles.trk")).paths) {
      const bool scripted = std::any_of(scene.bubbles.begin(), scene.bubbles.end(), [&](const auto& b) {
        return std::abs(b.radius_m - path.radius_m) <= 1e-12 && std::abs(b.birth_s - path.birth_s()) <= 1e-9;
      });
      if (scripted) {
        ++n_scripted;
      } else {
        radii.push_back(path.radius_m);
      }
    }
  if (n_scripted > 0)
    document.header.warnings.push_back(std::to_string(n_scripted) +
                                       " bubble(s) of [[bubble]] come on top of those that are matched");
  return radii;
}

void say_what_is_what(const drops::BubblesDocument& found, const Rate& rate, bool with_pitch,
                      const audio::Signal& recording, MatchDocument& document) {
  document.matched = {"radii of the bubbles"};
  if (rate.is_matched) {
    document.matched.insert(document.matched.begin(), "births per second");
  } else {
    document.unknown.emplace_back("births per second: no rate of attempts makes the recording's number");
    document.header.warnings.push_back("the number of bubbles is missed by " +
                                       to_text(std::round(1000 * rate.missed_by) / 10) +
                                       " %: more attempts do not make more of them where there is no room");
  }
  if (with_pitch) document.matched.emplace_back("the law of pitch: K e^eta and eta / |phi0|");
  document.predicted = {"where and when bubbles are born", "their depths and paths", "their transfer to the listener",
                        "the spectrum"};
  if (!with_pitch) document.predicted.emplace_back("how their pitch rises");
  document.unknown.emplace_back("the level: recordings are not calibrated");
  document.unknown.emplace_back(
      "bubbles below the recording's noise: rate and radii are those of the ones that are heard");
  if (found.bubbles.size() < kFewBubbles)
    document.header.warnings.push_back("few bubbles: " + std::to_string(found.bubbles.size()) +
                                       " of them say little of a rate and of radii");
  if (static_cast<double>(document.made.n_bubbles) < kFewBubbles)
    document.header.warnings.push_back("few bubbles: " + std::to_string(document.made.n_bubbles) +
                                       " are made, whose number and radii are much by chance");
  double last = 0.0, first = recording.duration_s();
  for (const drops::BubbleRecord& b : found.bubbles) {
    first = std::min(first, b.onset_s);
    last = std::max(last, b.onset_s);
  }
  if (last - first < 0.5 * recording.duration_s())
    document.header.warnings.push_back("the recording's bubbles come within " + to_text(last - first) + " s of its " +
                                       to_text(recording.duration_s()) + " s: cut it to what the scene shows");
}

void say_match(const MatchDocument& document, const std::string& recording, const CommonOptions& common) {
  say(common, "%s: %lld bubbles in %.3g s (%.4g per second), median radius %.3g mm\n", recording.c_str(),
      static_cast<long long>(document.recorded.n_bubbles), document.recorded.duration_s, document.recorded.births_per_s,
      1e3 * document.recorded.radius_median_m);
  say(common, "%s: %lld bubbles in %.3g s (%.4g per second), median radius %.3g mm; %.4g attempts per m2 s\n",
      document.name.c_str(), static_cast<long long>(document.made.n_bubbles), document.made.duration_s,
      document.made.births_per_s, 1e3 * document.made.radius_median_m, document.attempts_per_m2_s);
  const auto list = [&](const char* head, const std::vector<std::string>& items) {
    for (const std::string& item : items) say(common, "%s: %s\n", head, item.c_str());
  };
  list("matched", document.matched);
  list("predicted", document.predicted);
  list("not known", document.unknown);
  if (document.spectrum_difference_db)
    say(common, "third octaves differ by %.1f dB rms\n", *document.spectrum_difference_db);
}

int run_match(MatchOptions options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  options.search.band = parse_band("--band-hz", options.band);
  options.search.validate();
  if (!is_liquid_file(options.scene))
    throw InputError(options.scene, "is no scene of a liquid", "", "one with [domain]");
  const liquid_scene::LiquidScene scene = liquid_scene::read_liquid_scene(options.scene);
  const std::string toml = read_file(options.scene);
  const std::vector<drops::BubbleRise> rises =
      options.rise.empty() ? std::vector<drops::BubbleRise>{} : drops::read_rises(options.rise);
  const audio::Signal recording = audio::read_sound(options.recording);
  const liquid_scene::RunFolder folder(options.output);
  if (folder.begun() && folder.read_document().flow_run != liquid_scene::flow_key(scene))
    throw InputError(options.output, "holds the run of another flow", "", "a run of this scene, or a new folder");

  const drops::BubbleSearchResult heard = drops::find_bubbles(recording, options.search, monitor);
  const drops::PitchFitResult pitch = drops::fit_pitch(heard, rises, options.search, {}, monitor);
  std::vector<std::filesystem::path> inputs = {options.scene, options.recording};
  if (!options.rise.empty()) inputs.emplace_back(options.rise);
  drops::BubblesDocument found = drops::bubbles_document(
      make_header("bubbles", "", common, {{"band_hz", {options.search.band.low_hz, options.search.band.high_hz}}},
                  inputs),
      heard, pitch, options.search);
  found.name = std::filesystem::path(options.recording).stem().string();
  found.duration_s = recording.duration_s();
  found.sample_rate_hz = recording.sample_rate_hz;
  found.n_channels = static_cast<int>(recording.n_channels());
  if (found.header.status != "ok" || found.bubbles.empty())
    throw NumericalError("the recording is none of bubbles: " + found.header.message.value_or("none was found"));
  std::vector<double> radii;
  for (const drops::BubbleRecord& b : found.bubbles) radii.push_back(b.radius_m);

  CommonOptions quiet = common;
  quiet.json.clear();
  quiet.quiet = true;
  LiquidRunOptions run;
  run.scene = options.scene;
  run.output = options.output;
  run.no_sound = options.no_sound;
  if (!folder.begun()) {
    run.last_stage = "flow";
    run_liquid(run, quiet, monitor);
  }
  const liquid_scene::RunDocument flow = folder.read_document();
  if (!flow.stages.flow || flow.stages.flow->status != liquid_scene::StageStatus::kDone || !(flow.end_s > 0.0))
    throw InputError(options.output, "its stage flow is not done", "", "klang scene run SCENE -o DIR --resume first");

  liquid_scene::SceneMatch match;
  match.recorded = kNextDrops;
  match.smallest_m = std::max(1e-5, *std::min_element(radii.begin(), radii.end()) * (1.0 - kSmear));
  match.largest_m = std::min(0.05, *std::max_element(radii.begin(), radii.end()) * (1.0 + kSmear));
  const bool has_law = scene.sound.pitch.kind == bubble::PitchKind::kHarmonicFluids ||
                       scene.sound.pitch.kind == bubble::PitchKind::kHarmonicFluidsFrozen;
  match.with_pitch = has_law && pitch.status == drops::PitchStatus::kFitted;
  const double wanted = static_cast<double>(radii.size()) / recording.duration_s() * flow.end_s;
  if (wanted <= 0.5)
    throw NumericalError("the scene's " + to_text(flow.end_s) + " s hold " +
                         to_text(std::round(100.0 * wanted) / 100.0) + " bubbles at the recording's rate (" +
                         std::to_string(radii.size()) + " in " +
                         to_text(std::round(1000.0 * recording.duration_s()) / 1000.0) +
                         " s): make the scene longer, or cut the recording to where its bubbles are");
  const NextDrops next(folder, json_text(json_of(found)));
  // Radii decide which attempts are rejected: the rate is sought with the recording's.
  const auto scene_with = [&](double rate) {
    match.attempts_per_m2_s = rate;
    return liquid_scene::matched_scene_text(toml, std::filesystem::path(options.scene).parent_path(), match);
  };
  const liquid_scene::LiquidScene probe = liquid_scene::parse_liquid_scene(
      scene_with(scene.entrainment.given ? scene.entrainment.attempts_per_m2_s : kFirstRate), "scene.toml",
      folder.path());
  const Rate rate = find_rate(probe, folder, static_cast<std::size_t>(flow.n_frames), wanted, common.seed, monitor);
  next.take();
  match.recorded = "drops.json";
  write_file(folder.file("scene.toml"), scene_with(rate.attempts_per_m2_s));
  run.scene = folder.file("scene.toml");
  run.last_stage = options.no_sound ? std::optional<std::string>("bubbles") : std::nullopt;
  run.stage = "bubbles";
  run_liquid(run, quiet, monitor);

  MatchDocument document;
  document.header = make_header(
      "scene_match", "done", common,
      {{"band_hz", {options.search.band.low_hz, options.search.band.high_hz}}, {"no_sound", options.no_sound}}, inputs);
  document.name = scene.name;
  document.attempts_per_m2_s = rate.attempts_per_m2_s;
  document.n_rounds = rate.n_rounds;
  document.recorded = summary(radii, recording.duration_s());
  const std::vector<double> made = entrained_radii(scene, folder, document);
  document.made = summary(made, flow.end_s);
  document.radii = quantiles(radii, made);
  say_what_is_what(found, rate, match.with_pitch, recording, document);
  if (!options.no_sound)
    compare_spectra(heard.mono, audio::read_sound(folder.file("sound.wav")), options.search.band, document);
  write_file(folder.file("match.json"), json_text(json_of(document)));
  write_json(common, json_of(document));
  for (const std::string& warning : document.header.warnings) warn(warning);
  say_match(document, options.recording, common);
  return kDone;
}

}  // namespace

Subcommand add_scene_match(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<MatchOptions>();
  CLI::App* app =
      group.add_subcommand("match", "Sets a liquid's rate and radii of bubbles from a recording of drops or pouring");
  app->add_option("scene", options->scene, "Scene with [domain] (docs/liquid.md)")->required();
  app->add_option("--recording", options->recording, "WAV, FLAC, OGG, MP3 or AIFF")->required();
  app->add_option("-o,--output", options->output, "New folder, or that of a run of this scene, whose flow is taken")
      ->required();
  add_band_option(*app, common, options->band);
  add_fields(*app, common, options->search, {{"min_snr_db"}, {"max_bubbles"}, {"max_work"}});
  app->add_option("--rise", options->rise,
                  "How the recorded bubbles rose (as of klang bubble fit): sets the law of pitch, too");
  app->add_flag("--no-sound", options->no_sound, "Rate, radii and bubbles only");
  app->footer(
      "Writes match.json, drops.json, scene.toml with what was found, and the run.\n"
      "Examples:\n  klang scene match pouring.toml --recording pouring.wav -o matched\n"
      "Exit code 3: the recording is none of bubbles, or the flow entrains none.");
  return {app,
          [options, &common] { return run_match(*options, common); },
          {result_kind<MatchDocument>("scene_match", "match.json of `klang scene match`")}};
}

}  // namespace klang::apps
