#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <optional>

#include "apps/commands/scene_folder.hpp"
#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/events/event_log_file.hpp"
#include "core/sound/scene/scene_floor.hpp"

namespace klang::apps {
namespace {

struct SceneSoundOptions {
  std::string source, scene, output;
  std::string listener, facing;
  bool stereo = false, mono = false, radiation_damping = false;
  std::optional<double> duration_s, sample_rate_hz;
  SceneChanges changes;
};

/// The scene's bodies as a log of another program numbers them. @throws InputError where the log pushes a body that the scene lacks
std::vector<scene::HeardBody> renumbered(std::vector<scene::HeardBody> heard, const scene::Scene& scene,
                                         const events::EventLog& log, const std::string& source) {
  std::vector<scene::HeardBody> found;
  for (std::size_t row = 0; row < log.bodies.size(); ++row) {
    if (log.bodies[row].parent >= 0) continue;
    const auto body = std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const scene::SceneBody& candidate) {
      return candidate.name == log.bodies[row].name;
    });
    if (body == scene.bodies.end()) throw InputError(source, "has a body that the scene lacks", log.bodies[row].name);
    for (const scene::HeardBody& candidate : heard) {
      if (candidate.body != body - scene.bodies.begin()) continue;
      found.push_back(candidate);
      found.back().body = static_cast<int>(row);
    }
  }
  return found;
}

/// @throws InputError where a log of another program pushes a body at a place that is not of it, by more than 1 % of its size
void check_places(const events::EventLog& log, const std::vector<scene::HeardBody>& heard, const std::string& source) {
  constexpr double kOff = 0.01;
  for (const scene::HeardBody& body : heard) {
    if (body.model->proxy) continue;
    const auto& nodes_m = body.model->modes.mesh.nodes_m;
    const Eigen::Vector3d low = nodes_m.colwise().minCoeff(), high = nodes_m.colwise().maxCoeff();
    const double room_m = kOff * (high - low).norm();
    for (std::size_t row = 0; row < log.impulses.size(); ++row) {
      const events::Impulse& impulse = log.impulses[row];
      if (impulse.body != body.body) continue;
      const double off_m = std::max((low - impulse.point_m).maxCoeff(), (impulse.point_m - high).maxCoeff());
      if (!(off_m <= room_m))
        throw InputError(source, "impulses[" + std::to_string(row) + "] lies off the body",
                         log.bodies[static_cast<std::size_t>(body.body)].name + ", " + to_text(off_m) + " m outside",
                         "places in the body's own frame, within 1 % of its size");
    }
  }
}

double end_of(const events::EventLog& log) {
  double end_s = 0.0;
  for (const events::Impulse& impulse : log.impulses) end_s = std::max(end_s, impulse.time_s + impulse.duration_s);
  for (const events::Pose& pose : log.poses) end_s = std::max(end_s, pose.time_s);
  return end_s;
}

/// Whether the files that a scene names are those that the run in a folder read.
bool is_scene_of(const scene::Scene& scene, const scene::SceneDocument& run) {
  const std::vector<std::filesystem::path> files = scene.inputs();
  const std::vector<InputFile>& read = run.header.provenance.inputs;
  return files.size() == read.size() &&
         std::equal(files.begin(), files.end(), read.begin(),
                    [](const auto& a, const auto& b) { return input_file(a).sha256 == b.sha256; });
}

int run_scene_sound(const SceneSoundOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  if (!std::filesystem::exists(options.source)) throw InputError(options.source, "is no file and no folder");
  const bool is_folder = std::filesystem::is_directory(options.source);
  if (is_folder && std::filesystem::weakly_canonical(options.output) ==
                       std::filesystem::weakly_canonical(std::filesystem::path(options.source) / "sound.wav"))
    throw InputError("--output", "is the sound of the run itself, which its scene.json describes", options.output,
                     "another file");
  std::string scene_file = options.scene;
  scene::SceneDocument run;
  if (is_folder)
    run = read_fields<scene::SceneDocument>(read_result_json(std::filesystem::path(options.source) / "scene.json"),
                                            "scene.json");
  if (scene_file.empty()) {
    if (!is_folder)
      throw InputError("--scene", "is needed for a log: the scene that describes its bodies", options.source);
    if (run.header.provenance.inputs.empty()) throw InputError(options.source, "scene.json names no scene");
    scene_file = run.header.provenance.inputs.front().path;
  }
  scene::Scene scene = scene::read_scene(scene_file);
  apply(options.changes, scene);
  if (!options.listener.empty()) {
    scene.sound.listener.position_m = parse_place("--listener", options.listener);
    scene.sound.listener.path.clear();
  }
  if (!options.facing.empty()) {
    scene.sound.listener.facing = parse_place("--facing", options.facing);
    for (scene::ListenerKey& key : scene.sound.listener.path) key.facing = scene.sound.listener.facing;
  }
  if (options.stereo || options.mono) scene.sound.listener.stereo = options.stereo;
  scene.sound.radiation_damping |= options.radiation_damping;
  scene.sound.sample_rate_hz = options.sample_rate_hz.value_or(scene.sound.sample_rate_hz);

  const SceneFolder folder(options.source);
  // Modes of the folder are those of the scene that was run; another scene, named on purpose, has its own.
  const bool is_same = is_folder && is_scene_of(scene, run);
  if (is_folder && !is_same && options.scene.empty())
    throw InputError(scene_file, "has changed since the run in " + options.source, "", "--scene FILE, or a new run");
  events::EventLog log =
      events::read_event_log(is_folder ? folder.file("events.h5") : std::filesystem::path(options.source));
  if (options.changes.without_fracture_impulses)
    std::erase_if(log.impulses, [](const auto& impulse) { return impulse.kind == events::ImpulseKind::kFracture; });
  const scene::SceneProxies proxies(scene);
  std::vector<std::string> warnings;
  const scene::SceneNotes notes = scene_notes(common, warnings);
  std::vector<scene::HeardBody> heard =
      renumbered(heard_bodies(scene, proxies, is_same ? &folder : nullptr, notes, monitor), scene, log, options.source);
  if (is_same)
    for (scene::HeardBody& piece : heard_pieces(scene, proxies, log, folder, notes, monitor))
      heard.push_back(std::move(piece));
  if (!is_folder) check_places(log, heard, options.source);
  const double tail_s =
      std::min(scene.sound.longest_tail_s,
               std::max(scene::ring_time_s(heard, scene.sound.radiation_damping), scene::floor_ring_time_s(scene)));
  const double duration_s = options.duration_s.value_or(scene.duration_s.value_or(end_of(log) + tail_s));
  const stage::ImpactPulses pulses = heard_pulses(scene, log, heard, is_same ? &folder : nullptr, monitor);
  const scene::HeardRecord record = write_scene_sound(
      options.output, heard_sound(scene, {log, heard, pulses}, duration_s, nullptr, monitor), scene.sound, notes);

  std::vector<std::filesystem::path> inputs = scene.inputs();
  inputs.push_back(is_folder ? folder.file("events.h5") : std::filesystem::path(options.source));
  SceneSoundDocument document;
  document.header = make_header("scene_sound", "done", common, {{"duration_s", duration_s}}, inputs);
  document.sound = record;
  document.header.warnings = warnings;
  write_json(common, json_of(document));
  say(common, "%s: %.2f s, %zu bodies, peak %.4g Pa at the listener\n", options.output.c_str(), record.duration_s,
      heard.size(), record.peak_pressure_pa);
  return kDone;
}

}  // namespace

Subcommand add_scene_sound(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<SceneSoundOptions>();
  CLI::App* app = group.add_subcommand("sound", "Sound of a scene's impulses again: another listener, other damping");
  app->add_option("source", options->source,
                  "Folder of klang scene run, or an event log (.h5, docs/event-log.md) whose bodies --scene describes")
      ->required();
  app->add_option("-o,--output", options->output, "Sound file (.wav or .flac)")->required();
  app->add_option("--scene", options->scene, "Scene (TOML); default: that of the folder");
  app->add_option("--listener", options->listener, "x,y,z of the head in metres; default: the scene's");
  app->add_option("--facing", options->facing, "x,y,z: direction of the nose");
  auto* stereo = app->add_flag("--stereo", options->stereo, "Two ears of a spherical head");
  app->add_flag("--mono", options->mono, "One ear")->excludes(stereo);
  app->add_flag("--radiation-damping", options->radiation_damping, "Add the decay by radiation to each mode's damping");
  app->add_option("--duration-s", options->duration_s, "Length; default: the scene's, or until it has rung out")
      ->check(CLI::Range(0.001, 3600.0));
  app->add_option("--rate-hz", options->sample_rate_hz, "Sample rate; default: the scene's")
      ->check(CLI::Range(4000.0, 768000.0));
  app->add_option("--proxies-above-hz", options->changes.proxies_above_hz,
                  "Bodies whose lowest frequency is above this are heard by ellipsoids of the scene's bank; 0: all");
  app->add_option("--bank", options->changes.bank, "Soundbank of klang proxy build, instead of the scene's");
  app->add_flag("--without-fracture-impulses", options->changes.without_fracture_impulses,
                "Impulses of cracks are not heard");
  app->footer(
      "Examples:\n"
      "  klang scene sound chimes -o near.wav --listener 0,-0.3,0.3 --stereo\n"
      "  klang scene sound engine.h5 --scene scene.toml -o engine.wav");
  return {app,
          [options, &common] { return run_scene_sound(*options, common); },
          {result_kind<SceneSoundDocument>("scene_sound", "the result of `klang scene sound`")}};
}

}  // namespace klang::apps
