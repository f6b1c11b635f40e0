#include "apps/commands/liquid_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/liquid_scene/bubbles_stage.hpp"
#include "core/sound/liquid_scene/flow_stage.hpp"
#include "core/sound/liquid_scene/run_tables.hpp"
#include "core/sound/liquid_scene/sound_stage.hpp"
#include "core/sound/liquid_scene/transfer_stage.hpp"
#include "reports/report/report.hpp"

namespace klang::apps {
namespace {

using liquid_scene::LiquidScene;
using liquid_scene::RunDocument;
using liquid_scene::RunFolder;
using liquid_scene::StageRecord;
using liquid_scene::StageRun;
using liquid_scene::StagesRecord;
using liquid_scene::StageStatus;

void flow(StageRun& run) {
  switch (liquid_scene::run_flow(run)) {
    case liquid_scene::FlowResult::kDone:
      return;
    case liquid_scene::FlowResult::kNotConverged:
      throw NumericalError("the pressure did not converge at " + to_text(run.document.end_s) + " s");
    case liquid_scene::FlowResult::kVolumeLost:
      throw NumericalError("the volume is off by " + to_text(100.0 * run.document.volume.max_drift_relative) +
                           " % at " + to_text(run.document.end_s) + " s, more than 1 %");
  }
}

/// The stages in their order: each reads what those before it left in the folder, and writes its part of run.json.
struct Stage {
  const char* name;
  std::optional<StageRecord> StagesRecord::*record;
  void (*run)(StageRun& run);
};
constexpr std::array<Stage, 4> kStages{{{"flow", &StagesRecord::flow, flow},
                                        {"bubbles", &StagesRecord::bubbles, liquid_scene::run_bubbles},
                                        {"transfer", &StagesRecord::transfer, liquid_scene::run_transfer},
                                        {"sound", &StagesRecord::sound, liquid_scene::run_sound}}};

/// A stage that did not come to its end (Ctrl-C, or what it threw): run.json says so.
void note_stopped(const Stage& stage, const RunFolder& folder, RunDocument& document) {
  std::optional<StageRecord>& record = document.stages.*stage.record;
  if (!record) record.emplace();
  record->status = StageStatus::kInterrupted;
  document.header.status = "interrupted";
  try {
    folder.write_document(document);
  } catch (const std::exception&) {  // on a full disk: why the stage stopped matters more
  }
}

bool is_done(const RunDocument& document, const Stage& stage) {
  const std::optional<StageRecord>& record = document.stages.*stage.record;
  return record && record->status == StageStatus::kDone;
}

/// The first stage that is to be run.
std::size_t first_stage(const LiquidRunOptions& options, const RunDocument& document, double until_s) {
  if (options.stage) {
    for (std::size_t s = 0; s < kStages.size(); ++s) {
      if (*options.stage != kStages[s].name) continue;
      for (std::size_t before = 0; before < s; ++before)
        if (!is_done(document, kStages[before]))
          throw InputError("--stage", std::string("the stage ") + kStages[before].name + " is not done",
                           options.output.string());
      return s;
    }
    std::string known;
    for (const Stage& stage : kStages) known += (known.empty() ? "" : ", ") + std::string(stage.name);
    throw InputError("--stage", "unknown stage", *options.stage, known);
  }
  if (!options.resume || document.end_s < until_s * (1.0 - 1e-9)) return 0;
  for (std::size_t s = 0; s < kStages.size(); ++s)
    if (!is_done(document, kStages[s])) return s;
  return kStages.size();
}

RunDocument begun_document(const LiquidRunOptions& options, const LiquidScene& scene, const RunFolder& folder) {
  RunDocument document;
  const std::string key = liquid_scene::run_key(scene);
  // A later stage may be done again with what only it depends on changed.
  const bool from_bubbles = options.stage == "bubbles", from_transfer = options.stage == "transfer";
  const std::string noted_key = from_bubbles    ? liquid_scene::flow_key(scene)
                                : from_transfer ? liquid_scene::bubbles_key(scene)
                                                : key;
  const char* const field = from_bubbles ? "flow_run" : from_transfer ? "bubbles_run" : "run";
  if (options.resume || options.stage) {
    const char* const flag = options.resume ? "--resume" : "--stage";
    if (!folder.begun()) throw InputError(flag, "there is no run in the folder", options.output.string());
    const nlohmann::json noted = parse_json(read_file(folder.file("run.json")), folder.file("run.json").string());
    if (!noted.is_object() || text_under(noted, field) != noted_key)
      throw InputError(flag, "the folder holds the run of another scene or version, or its files have changed",
                       options.output.string(), "the same scene and program, or another folder");
    document = folder.read_document();
  } else if (folder.begun() || folder.has("scene.json")) {
    throw InputError(options.output.string(), "holds a run already", "", "--resume, or another folder");
  }
  document.name = scene.name;
  document.run = key;
  document.flow_run = liquid_scene::flow_key(scene);
  document.bubbles_run = liquid_scene::bubbles_key(scene);
  return document;
}

/// What run.json had of stages that are done again.
void forget_results(std::size_t first, RunDocument& document) {
  document.sound.reset();
  if (kStages[first].run == liquid_scene::run_sound) return;
  document.transfer.reset();
  document.n_solves = 0;
}

/// Once a stage is done again, what later ones left in the folder is of other bubbles. Not before: it may be refused.
void remove_after(const Stage& done, const RunFolder& folder) {
  const bool sound = done.run == liquid_scene::run_sound, transfer = done.run == liquid_scene::run_transfer;
  std::error_code none;  // there may be no such file
  for (const char* const name : {"report.html", "radii.csv"}) std::filesystem::remove(folder.file(name), none);
  if (!sound) std::filesystem::remove(folder.file("sound.wav"), none);
  if (!sound && !transfer) std::filesystem::remove(folder.file("transfer.csv"), none);
}

/// What another program let in and out is not known.
std::string drift_words(const RunDocument& document) {
  if (document.imported) return {};
  char words[40];
  std::snprintf(words, sizeof words, " (drift %.1e)", document.volume.max_drift_relative);
  return words;
}

void say_run(const RunDocument& document, const CommonOptions& common) {
  if (document.n_frames == 0)
    say(common, "%s: bubbles of another program, %.4g s\n", document.name.c_str(), document.end_s);
  else
    say(common, "%s: %.4g s of flow, %lld frames, %lld particles, volume %.6g to %.6g m3%s\n", document.name.c_str(),
        document.end_s, static_cast<long long>(document.n_frames), static_cast<long long>(document.n_particles),
        document.volume.start_m3, document.volume.end_m3, drift_words(document).c_str());
  if (!document.imported && document.n_frames > 0)
    say(common, "pressure: %lld iterations, largest |div u| dt %.1e\n",
        static_cast<long long>(document.pressure.iterations), document.pressure.max_divergence);
  if (document.stages.bubbles)
    say(common, "%lld bubbles, %.4g births per second\n", static_cast<long long>(document.n_bubbles),
        document.births_per_s);
  if (document.sound)
    say(common, "%s: %.2f s, peak %.4g Pa at the listener\n", document.sound->file.c_str(), document.sound->duration_s,
        document.sound->peak_pressure_pa);
}

}  // namespace

bool is_liquid_file(const std::filesystem::path& scene) {
  return liquid_scene::is_liquid_scene(read_file(scene, std::size_t{64} << 20));
}

bool is_liquid_folder(const std::filesystem::path& folder) {
  const RunFolder run(folder);
  if (!run.begun()) return false;
  const nlohmann::json noted = parse_json(read_file(run.file("run.json")), run.file("run.json").string());
  return noted.is_object() && noted.value("kind", "") == "liquid_scene";
}

int run_liquid(const LiquidRunOptions& options, const CommonOptions& common, Monitor& monitor) {
  const LiquidScene scene = liquid_scene::read_liquid_scene(options.scene);
  const double until_s = std::min(options.until_s.value_or(scene.duration_s), scene.duration_s);
  const RunFolder folder(options.output);
  RunDocument document = begun_document(options, scene, folder);
  const std::size_t first = first_stage(options, document, until_s);
  // The flow has no seed: what stopped in it, or goes on to a later end, may go on with any.
  if (options.resume && !options.stage && first > 0 && document.bubbles_seed.value_or(common.seed) != common.seed)
    throw InputError("--resume", "the run's bubbles are of another seed", "--seed " + std::to_string(common.seed),
                     "--seed " + std::to_string(*document.bubbles_seed) + ", or --stage bubbles for other bubbles");
  if (first == kStages.size()) {
    say(common, "%s is complete\n", options.output.c_str());
    write_json(common, json_of(document));
    return kDone;
  }
  if (first == 0 && scene.imported)
    throw InputError(options.scene.string(), "its flow is another program's", "", "--stage bubbles, or a later one");
  if (first == 0 && !options.resume) {
    liquid_scene::require_room(scene, until_s, options.output);
    note(common, "the folder will take about " +
                     to_text(std::ceil(liquid_scene::estimated_bytes(scene, until_s) / 1e6)) + " MB");
  }
  document.header =
      make_header("liquid_scene", "running", common,
                  {{"until_s", options.until_s ? nlohmann::json(*options.until_s) : nlohmann::json()}}, scene.inputs());
  for (std::size_t s = first; s < kStages.size(); ++s)
    if (s > 0 || !options.resume) (document.stages.*kStages[s].record).reset();
  forget_results(first, document);
  std::filesystem::create_directories(options.output);
  std::error_code same;
  if (!std::filesystem::equivalent(options.scene, folder.file("scene.toml"), same))
    write_file(folder.file("scene.toml"), read_file(options.scene));
  folder.write_document(document);
  StageRun run{scene,
               folder,
               document,
               common.seed,
               until_s,
               options.checkpoint_s.value_or(60.0),
               options.resume,
               monitor,
               [&](const std::string& text) {
                 document.header.warnings.push_back(text);
                 warn(text);
               }};
  for (std::size_t s = first; s < kStages.size(); ++s) {
    if (options.no_sound && kStages[s].run == liquid_scene::run_sound) continue;
    if (kStages[s].run == liquid_scene::run_bubbles) document.bubbles_seed = common.seed;
    try {
      kStages[s].run(run);
    } catch (...) {
      note_stopped(kStages[s], folder, document);
      throw;
    }
    remove_after(kStages[s], folder);
    run.resume = false;
    if (options.last_stage == kStages[s].name) break;
  }
  document.header.status = "done";
  folder.write_document(document);
  std::string page;
  if (!options.no_sound && !options.last_stage) {
    liquid_scene::write_run_tables(run);
    folder.write_document(document);  // with its warnings
  }
  if (!options.no_page && !options.no_sound && !options.last_stage) {
    const auto report = reports::write_report(folder.file("run.json"), {}, monitor);
    for (const std::string& warning : report.warnings) warn(warning);
    page = report.page.string();
  }
  write_json(common, json_of(document));
  say_run(document, common);
  if (!page.empty()) say(common, "page: %s\n", page.c_str());
  return kDone;
}

int check_liquid(const std::filesystem::path& file, const CommonOptions& common) {
  const LiquidScene scene = liquid_scene::read_liquid_scene(file);
  std::optional<liquid::Liquid> start;
  if (!scene.imported) start.emplace(scene.setup);
  LiquidCheckDocument document;
  document.header = make_header("liquid_scene_check", "ok", common, nlohmann::json::object(), scene.inputs());
  document.name = scene.name;
  document.cell_m = scene.setup.shape.cell_m;
  document.duration_s = scene.duration_s;
  document.volume_m3 = start ? start->volume_m3() : 0.0;
  document.estimated_bytes = liquid_scene::estimated_bytes(scene, scene.duration_s);
  document.n_cells = static_cast<std::int64_t>(scene.setup.shape.n_cells());
  document.n_particles = start ? static_cast<std::int64_t>(start->particles().size()) : 0;
  document.n_frames = static_cast<std::int64_t>(scene.n_frames());
  document.n_solids = static_cast<std::int64_t>(scene.setup.solids.size());
  document.n_inlets = static_cast<std::int64_t>(scene.setup.inlets.size());
  write_json(common, json_of(document));
  const liquid::GridShape& shape = scene.setup.shape;
  say(common, "%s: %d x %d x %d cells of %g m, %lld particles, %.6g m3 of liquid\n", scene.name.c_str(), shape.nx,
      shape.ny, shape.nz, shape.cell_m, static_cast<long long>(document.n_particles), document.volume_m3);
  say(common, "%g s, %lld frames, about %.0f MB\n", scene.duration_s, static_cast<long long>(document.n_frames),
      document.estimated_bytes / 1e6);
  return kDone;
}

int show_liquid(const std::filesystem::path& folder, const CommonOptions& common) {
  const RunDocument document = RunFolder(folder).read_document();
  write_json(common, json_of(document));
  say_run(document, common);
  return kDone;
}

}  // namespace klang::apps
