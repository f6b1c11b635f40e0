#include <CLI/CLI.hpp>
#include <memory>

#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/physics/liquid_vdb/vdb_file.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::apps {
namespace {

struct ExportOptions {
  std::string folder, tracked, vdb;
};

std::size_t export_vdb(const liquid_scene::RunFolder& folder, const liquid_scene::RunDocument& run,
                       const std::filesystem::path& output, Monitor& monitor) {
  if (!liquid::has_vdb())
    throw InputError("--vdb", "this build has no OpenVDB", "", "a build where Debian's libopenvdb-dev is installed");
  if (run.n_frames < 1) throw InputError(folder.path().string(), "has no frames", "", "a run whose flow has begun");
  const auto n_frames = static_cast<std::size_t>(run.n_frames);
  const liquid_scene::LiquidScene scene = liquid_scene::read_liquid_scene(folder.file("scene.toml"));
  OutputDirectory out(output);
  for (std::size_t k = 0; k < n_frames; ++k) {
    monitor.throw_if_stopped();
    monitor.progress("export", static_cast<double>(k) / static_cast<double>(n_frames));
    const liquid_scene::FrameFields fields = liquid_scene::read_fields_file(folder.field_file(k));
    std::string number = std::to_string(k);
    number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
    liquid::write_vdb(out.staging() / ("f_" + number + ".vdb"), fields.shape, fields.phi_m, fields.u, scene.frame_s(k));
  }
  out.commit();
  return n_frames;
}

int run_scene_export(const ExportOptions& options, const CommonOptions& common) {
  const liquid_scene::RunFolder folder(options.folder);
  if (!folder.begun()) throw InputError(options.folder, "holds no run of a liquid", "", "a folder of klang scene run");
  const std::filesystem::path file = folder.file("bubbles.trk");
  const liquid_scene::RunDocument run = folder.read_document();
  if (options.tracked.empty() == options.vdb.empty())
    throw InputError("command line", "needs --tracked or --vdb, one of them");
  if (!options.vdb.empty()) {
    TerminalMonitor monitor(common.quiet);
    const std::size_t n_frames = export_vdb(folder, run, options.vdb, monitor);
    SceneExportDocument document;
    document.header = make_header("scene_export", "done", common, {{"vdb", options.vdb}}, {folder.file("scene.toml")});
    document.n_frames = static_cast<std::int64_t>(n_frames);
    write_json(common, json_of(document));
    say(common, "%s: f_0000.vdb and following, %zu frames\n", options.vdb.c_str(), n_frames);
    return kDone;
  }
  if (!folder.has("bubbles.trk"))
    throw InputError(options.folder, "has no bubbles yet", "", "a run whose stage bubbles is done");
  std::vector<entrainment::BubblePath> paths;
  if (run.n_bubbles > 0) paths = entrainment::read_tracked_bubbles(file).paths;
  entrainment::write_tracked_bubbles(options.tracked, paths);
  SceneExportDocument document;
  document.header = make_header("scene_export", "done", common, {{"tracked", options.tracked}}, {file});
  document.n_bubbles = static_cast<std::int64_t>(paths.size());
  write_json(common, json_of(document));
  say(common, "%s: %zu bubbles\n", options.tracked.c_str(), paths.size());
  return kDone;
}

}  // namespace

Subcommand add_scene_export(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* app = group.add_subcommand("export", "Frames or bubbles of a liquid's run for other programs");
  app->add_option("folder", options->folder, "Folder of klang scene run with a liquid")->required();
  app->add_option("--tracked", options->tracked, "Writes trackedBubInfo; a name that ends in .xz is compressed");
  app->add_option("--vdb", options->vdb, "Writes f_0000.vdb and following here: grid phi, to full depth, and velocity");
  app->footer(
      "Examples:\n  klang scene export pouring --tracked bubbles.txt.xz\n  klang scene export pouring --vdb "
      "frames_vdb");
  return {app,
          [options, &common] { return run_scene_export(*options, common); },
          {result_kind<SceneExportDocument>("scene_export", "the result of `klang scene export`")}};
}

}  // namespace klang::apps
