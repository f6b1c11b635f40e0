#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/commands/liquid_run.hpp"
#include "apps/commands/scene_folder.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/folder_lock.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/events/event_log_file.hpp"
#include "core/sound/scene/scene_check.hpp"
#include "core/sound/scene/scene_draws.hpp"
#include "core/sound/scene/scene_floor.hpp"
#include "core/sound/scene/scene_frames.hpp"
#include "core/sound/scene/scene_roughness.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

struct RunOptions {
  std::string scene, output;
  std::optional<double> until_s, checkpoint_s;
  std::optional<std::string> stage;
  bool no_sound = false, no_frames = false, resume = false, no_page = false;
  std::optional<int> draws;
  SceneChanges changes;

  /// What decides about the results, beside the motion's end.
  nlohmann::json that_matter() const {
    const auto number = [](const std::optional<double>& v) { return v ? nlohmann::json(*v) : nlohmann::json(); };
    return {{"proxies_above_hz", number(changes.proxies_above_hz)},
            {"without_fracture_impulses", changes.without_fracture_impulses},
            {"draws", draws ? nlohmann::json(*draws) : nlohmann::json()}};
  }
};

/// The motion's results, from the folder where an earlier run left them.
struct Moved {
  scene::SceneDocument document;
  events::EventLog log;
};

/// What it is warned of stands in its document, and is said again where it is there already.
Moved moved(const RunOptions& options, const CommonOptions& common, const scene::Scene& scene,
            const SceneFolder& folder, Monitor& monitor) {
  const bool shows_shapes = scene.frames.wanted() && std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                                                 [](const auto& body) { return body.deforms(); });
  if (options.resume && folder.has("motion.json") && (!shows_shapes || folder.has("shapes.bin"))) {
    note(common, "the motion is there already");
    Moved kept{read_fields<scene::SceneDocument>(read_result_json(folder.file("motion.json")), "motion.json"),
               events::read_event_log(folder.file("events.h5"))};
    for (const std::string& warning : kept.document.header.warnings) warn(warning);
    return kept;
  }
  const Stopwatch watch;
  nlohmann::json used = options.that_matter();
  used["until_s"] = options.until_s ? nlohmann::json(*options.until_s) : nlohmann::json();
  used["no_sound"] = options.no_sound;
  used["no_frames"] = options.no_frames;
  std::vector<std::string> warnings;
  const scene::SceneMotion motion =
      scene::move(scene, options.until_s, common.seed, scene_notes(common, warnings), monitor);
  ResultHeader header = make_header("scene", "done", common, used, scene.inputs());
  header.wall_time_s["motion"] = watch.seconds();
  Moved result{scene_document(scene, motion, std::move(header)), motion.log};
  result.document.header.warnings.insert(result.document.header.warnings.begin(), warnings.begin(), warnings.end());
  if (!options.resume) folder.begin(scene_run_key(scene, options.that_matter(), common.seed), options.until_s);
  events::write_event_log(folder.file("events.h5"), motion.log);
  write_pieces(folder, motion.pieces);
  if (!motion.shapes.bodies.empty()) write_shapes(folder.file("shapes.bin"), motion.shapes);
  write_file(folder.file("ledger.csv"), csv_table(motion.ledger));
  if (motion.cracks) write_file(folder.file("crack_faces.csv"), crack_faces_csv(*motion.cracks));
  write_file(folder.file("motion.json"), json_text(json_of(result.document)));
  return result;
}

/// A scene on its way into a folder.
struct RunningScene {
  const scene::Scene& scene;
  const scene::SceneProxies& proxies;
  const SceneFolder& folder;
  const scene::SceneNotes& notes;
};

void add_sound(const RunOptions& options, const CommonOptions& common, const RunningScene& running, Moved& moved,
               Monitor& monitor) {
  const auto& [scene, proxies, folder, notes] = running;
  Stopwatch watch;
  std::vector<scene::HeardBody> heard = heard_bodies(scene, proxies, &folder, notes, monitor);
  for (scene::HeardBody& piece : heard_pieces(scene, proxies, moved.log, folder, notes, monitor))
    heard.push_back(std::move(piece));
  moved.document.header.wall_time_s["modes"] = watch.seconds();
  for (const scene::HeardBody& body : heard) {
    scene::BodyRecord& record = moved.document.bodies[static_cast<std::size_t>(body.body)];
    if (record.n_modes == 0) record.n_modes = static_cast<int>(body.model->modes.n_modes());
    record.proxy = body.model->proxy;
    const auto [modes, transfer] = model_files(scene, body);
    record.sound = {modes, transfer, std::string(body.damping.law->name()), body.damping.parameters};
  }
  const double tail_s =
      std::min(scene.sound.longest_tail_s,
               std::max(scene::ring_time_s(heard, scene.sound.radiation_damping), scene::floor_ring_time_s(scene)));
  const double duration_s = scene.duration_s ? moved.document.end_s : moved.document.end_s + tail_s;
  watch = Stopwatch();
  const stage::ImpactPulses pulses = heard_pulses(scene, moved.log, heard, &folder, monitor);
  moved.document.sound = write_scene_sound(
      folder.file("sound.wav"),
      heard_sound(scene, {moved.log, heard, pulses}, duration_s, &moved.document.floor, monitor), scene.sound, notes);
  moved.document.header.wall_time_s["sound"] = watch.seconds();
  if (!options.draws) return;
  watch = Stopwatch();
  const events::EventLog log = scene::with_roughness(scene, moved.log);
  moved.document.draws =
      scene::draw_sounds(scene, log, heard, scene::sound_of(log, heard, scene.sound, duration_s, monitor, &pulses),
                         {*options.draws, common.seed, &pulses}, monitor);
  moved.document.header.wall_time_s["draws"] = watch.seconds();
}

/// What the log's rows look like: the scene's bodies, then pieces by their files.
std::vector<scene::FrameBody> drawn_bodies(const scene::Scene& scene, const events::EventLog& log,
                                           const SceneFolder& folder, Monitor& monitor) {
  std::vector<scene::FrameBody> bodies = scene::frame_bodies(scene, monitor);
  for (std::size_t row = bodies.size(); row < log.bodies.size(); ++row) {
    const scene::FrameBody& parent = bodies[static_cast<std::size_t>(log.bodies[row].parent)];
    scene::FrameBody piece{log.bodies[row].name, parent.material, {}, {}};
    if (parent.surface)  // else it is part of what deforms
      piece.surface = std::make_shared<const mesh::SurfaceMesh>(piece_surface(folder, static_cast<int>(row)));
    bodies.push_back(std::move(piece));
  }
  return bodies;
}

void add_frames(const scene::Scene& scene, const SceneFolder& folder, Moved& moved, Monitor& monitor) {
  if (!scene.frames.wanted()) return;
  const Stopwatch watch;
  scene::DeformedShapes shapes;
  if (folder.has("shapes.bin"))
    shapes = scene::read_shapes(folder.file("shapes.bin"), static_cast<int>(moved.log.bodies.size()));
  const scene::Frames frames(scene, moved.log, drawn_bodies(scene, moved.log, folder, monitor), moved.document.end_s,
                             std::move(shapes));
  const Eigen::Vector3d low = frames.low_m(), high = frames.high_m();
  scene::FramesRecord record;
  record.n_frames = static_cast<int>(frames.times_s().size());
  record.rate_hz = scene.frames.rate_hz;
  record.low_m = {low.x(), low.y(), low.z()};
  record.high_m = {high.x(), high.y(), high.z()};
  if (scene.frames.glb) {
    record.animation = "scene.glb";
    write_file(folder.file(*record.animation), frames.glb());
  }
  if (scene.frames.vtp) {
    std::filesystem::create_directories(folder.file("frames"));
    for (std::size_t i = 0; i < frames.times_s().size(); ++i) {
      monitor.throw_if_stopped();
      monitor.progress("frames", static_cast<double>(i) / static_cast<double>(frames.times_s().size()));
      write_file(folder.file(scene::Frames::vtp_name(i)), frames.vtp(i));
    }
    record.series = "frames.pvd";
    write_file(folder.file(*record.series), frames.pvd());
  }
  moved.document.frames = record;
  moved.document.header.wall_time_s["frames"] = watch.seconds();
}

void say_scene(const scene::SceneDocument& document, const CommonOptions& common) {
  say(common, "%-24s %10s %8s %9s %14s\n", "body", "mass_kg", "modes", "impacts", "hardest_n_s");
  constexpr std::size_t kMostLines = 40;
  for (std::size_t i = 0; i < std::min(kMostLines, document.bodies.size()); ++i) {
    const scene::BodyRecord& body = document.bodies[i];
    char hardest[24] = "-";
    if (body.hardest_impact_n_s) std::snprintf(hardest, sizeof hardest, "%.4g", *body.hardest_impact_n_s);
    say(common, "%-24s %10.4g %8d %9d %14s\n", body.name.c_str(), body.mass_kg, body.n_modes, body.n_impacts, hardest);
  }
  if (document.bodies.size() > kMostLines) say(common, "and %zu more\n", document.bodies.size() - kMostLines);
  for (const scene::SceneEventRecord& event : document.events) {
    if (event.kind == "split") continue;
    say(common, "%.6f s: %s broke into %d pieces: %.4g J of strain, %.4g J in %.4g cm2 of cracks, %.4g J of motion\n",
        event.time_s, event.body.c_str(), event.pieces, event.strain_energy_j.value_or(0.0),
        event.fracture_energy_j.value_or(0.0), 1e4 * event.crack_area_m2, event.kinetic_energy_j.value_or(0.0));
  }
  if (document.cracks)
    say(common, "cracks: %d splits, %d elements from %d, %.4g cm2; plastic flow took %.4g J\n",
        document.cracks->n_splits, document.cracks->n_elements_end, document.cracks->n_elements_start,
        1e4 * document.cracks->new_area_m2, document.plastic->dissipation_j);
  say(common, "%.4f s of motion in %d steps; energy accounted for to %.1e of %.4g J\n", document.end_s,
      document.n_steps, document.ledger.residual_relative, document.ledger.energy_scale_j);
  if (document.draws)
    say(common, "%d draws from the fit: 90 %% of them within %+.2f to %+.2f dB, peaks of %.4g to %.4g Pa\n",
        document.draws->n, document.draws->low_level_db, document.draws->high_level_db,
        document.draws->low_peak_pressure_pa, document.draws->high_peak_pressure_pa);
  if (document.sound)
    say(common, "%s: %.2f s, peak %.4g Pa at the listener\n", document.sound->file.c_str(), document.sound->duration_s,
        document.sound->peak_pressure_pa);
}

/// Whether an earlier run left all that is asked for now: one without sound or frames may be asked for them later.
bool is_made(const RunOptions& options, const scene::Scene& scene, const SceneFolder& folder) {
  if (!folder.has("scene.json") || !folder.has("motion.json") || !folder.has("events.h5") || !folder.has("ledger.csv"))
    return false;
  scene::SceneDocument document;
  try {
    document = read_fields<scene::SceneDocument>(read_result_json(folder.file("scene.json")), "scene.json");
  } catch (const InputError&) {
    return false;
  }
  if (!options.no_sound) {
    if (!document.sound || !folder.has(document.sound->file)) return false;
    for (const scene::BodyRecord& body : document.bodies)
      if (body.sound && (!folder.has(body.sound->modes) || !folder.has(body.sound->transfer))) return false;
  }
  if (!options.no_frames && (scene.frames.glb || scene.frames.vtp)) {
    if (!document.frames) return false;
    for (const auto& file : {document.frames->animation, document.frames->series})
      if (file && !folder.has(*file)) return false;
  }
  return !options.draws || document.draws.has_value();
}

int run_scene(const RunOptions& options, const CommonOptions& common) {
  const Stopwatch watch;
  TerminalMonitor monitor(common.quiet);
  if (options.until_s) checked_open("command line", "--until-s", *options.until_s, 0.0, 3600.0);
  if (options.checkpoint_s) checked("command line", "--checkpoint-s", *options.checkpoint_s, 0.0, 1e6);
  if (is_liquid_file(options.scene)) {
    for (const auto& [given, flag] :
         {std::pair(options.changes.proxies_above_hz.has_value(), "--proxies-above-hz"),
          std::pair(!options.changes.bank.empty(), "--bank"),
          std::pair(options.changes.without_fracture_impulses, "--without-fracture-impulses"),
          std::pair(options.draws.has_value(), "--draws"), std::pair(options.no_frames, "--no-frames")})
      if (given) throw InputError(flag, "belongs to scenes of solid bodies", options.scene, "a scene without [domain]");
    return run_liquid({options.scene,
                       options.output,
                       options.until_s,
                       options.checkpoint_s,
                       options.stage,
                       options.no_sound,
                       options.resume,
                       options.no_page,
                       {}},
                      common, monitor);
  }
  for (const auto& [given, flag] :
       {std::pair(options.stage.has_value(), "--stage"), std::pair(options.checkpoint_s.has_value(), "--checkpoint-s")})
    if (given) throw InputError(flag, "belongs to scenes of liquids", options.scene, "a scene with [domain]");
  scene::Scene scene = scene::read_scene(options.scene);
  apply(options.changes, scene);
  if (options.no_frames) scene.frames.glb = scene.frames.vtp = false;
  if (options.draws) {
    checked("command line", "--draws", *options.draws, 1, 1000);
    if (options.no_sound)
      throw InputError("--draws", "draws are sounds", std::to_string(*options.draws), "no --no-sound");
    if (!scene::has_spread(scene))
      throw InputError("--draws", "no material of the scene comes from a fit that says how sure it is",
                       std::to_string(*options.draws), "fit = FILE in a [[material]]");
  }
  const scene::SceneProxies proxies(scene);
  const SceneFolder folder(options.output);
  const std::string key = scene_run_key(scene, options.that_matter(), common.seed);
  if (options.resume) folder.require(key);
  const FolderLock lock(options.output);
  if (options.resume) {
    const bool cracks = std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const scene::SceneBody& body) {
      return body.model == scene::BodyModel::kCracking;
    });
    if (folder.go_on(key, options.until_s, !cracks))
      note(common, std::string(options.until_s ? "on to a later end" : "on to the scene's own end") +
                       ": the motion is computed again from its start, modes that are there stay");
    if (is_made(options, scene, folder)) {
      if (!folder.has("report.html"))
        for (const std::string& warning : reports::write_report(folder.file("scene.json"), {}, monitor).warnings)
          warn(warning);
      say(common, "%s is complete\n", options.output.c_str());
      return kDone;
    }
  }
  std::vector<std::string> warnings;
  const scene::SceneNotes notes = scene_notes(common, warnings);
  scene::warn_of_contradicted_fits(scene, notes);
  if (!options.until_s) scene::require_rest(scene);
  if (!options.no_sound) scene::require_modes(scene, monitor);
  Moved result = moved(options, common, scene, folder, monitor);
  if (!options.no_sound) add_sound(options, common, {scene, proxies, folder, notes}, result, monitor);
  add_frames(scene, folder, result, monitor);
  scene::SceneDocument& document = result.document;
  document.header.warnings.insert(document.header.warnings.end(), warnings.begin(), warnings.end());
  document.header.wall_time_s["total"] = watch.seconds();
  write_file(folder.file("scene.json"), json_text(json_of(document)));
  const auto report = reports::write_report(folder.file("scene.json"), {}, monitor);
  for (const std::string& warning : report.warnings) warn(warning);
  write_json(common, json_of(document));
  say_scene(document, common);
  say(common, "%.1f s; page: %s\n", watch.seconds(), report.page.c_str());
  if (document.ledger.residual_relative <= document.ledger.limit) return kDone;
  const bool makes_energy = std::any_of(scene.bodies.begin(), scene.bodies.end(), [](const scene::SceneBody& body) {
    return body.model == scene::BodyModel::kCracking && body.crack.integrator != fracture::Integrator::kLeapfrog;
  });
  warn("the energy ledger does not close: " + to_text(document.ledger.residual_relative) +
       " of the energy, more than " + to_text(document.ledger.limit) +
       (makes_energy ? "; steps of euler and taylor make energy in proportion to their size, those of leapfrog none"
                     : ""));
  return kCheckNotPassed;
}

}  // namespace

Subcommand add_scene_run(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<RunOptions>();
  CLI::App* app =
      group.add_subcommand("run", "Moves the bodies or the liquid of a scene and makes sound, tables and page");
  app->add_option("scene", options->scene, "Scene (TOML, docs/scenes.md; with [domain] docs/liquid.md)")->required();
  app->add_option("-o,--output", options->output,
                  "Folder for scene.json, sound.wav, events.h5, ledger.csv, crack_faces.csv, modes/, frames.pvd, "
                  "scene.glb, report.html")
      ->required();
  app->add_option("--until-s", options->until_s, "Ends the motion earlier");
  app->add_option("--checkpoint-s", options->checkpoint_s, "Of a liquid: wall time between states to go on from (60)");
  app->add_option("--stage", options->stage,
                  "Of a liquid: does this stage and those after it again: flow, bubbles, transfer, sound");
  app->add_flag("--no-sound", options->no_sound, "Motion only");
  app->add_option("--draws", options->draws,
                  "The sound again for this many draws from the fits' covariance: how sure it is");
  app->add_flag("--no-frames", options->no_frames, "No pictures of the motion");
  app->add_option("--proxies-above-hz", options->changes.proxies_above_hz,
                  "Bodies whose lowest frequency is above this are heard by ellipsoids of the scene's bank; 0: all");
  app->add_option("--bank", options->changes.bank, "Soundbank of klang proxy build, instead of the scene's");
  app->add_flag("--without-fracture-impulses", options->changes.without_fracture_impulses,
                "Cracks push nothing: as fracture.impulses = false");
  app->add_flag("--no-page", options->no_page, "Of a liquid: no report.html");
  app->add_flag("--resume", options->resume,
                "Continues an interrupted run of the same scene, or one that ended earlier by --until-s: stages that "
                "are done stay");
  app->footer(
      "Examples:\n"
      "  klang scene run datasets-synthetic/scenes/s02/chimes.toml -o chimes\n"
      "  klang scene run scene.toml -o out --until-s 0.5 --no-sound\n"
      "  klang scene run datasets-synthetic/scenes/liquid/pouring.toml -o pouring --resume");
  return {app,
          [options, &common] { return run_scene(*options, common); },
          {result_kind<scene::SceneDocument>("scene", "scene.json of `klang scene run`"),
           result_kind<liquid_scene::RunDocument>("liquid_scene", "run.json of `klang scene run` with a liquid")}};
}

}  // namespace klang::apps
