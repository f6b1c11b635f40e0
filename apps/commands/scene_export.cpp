#include <CLI/CLI.hpp>
#include <memory>

#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::apps {
namespace {

struct ExportOptions {
  std::string folder, tracked;
};

int run_scene_export(const ExportOptions& options, const CommonOptions& common) {
  const liquid_scene::RunFolder folder(options.folder);
  if (!folder.begun()) throw InputError(options.folder, "holds no run of a liquid", "", "a folder of klang scene run");
  const std::filesystem::path file = folder.file("bubbles.trk");
  const liquid_scene::RunDocument run = folder.read_document();
  if (!folder.has("bubbles.trk"))
    throw InputError(options.folder, "has no bubbles yet", "", "a run whose stage bubbles is done");
  std::vector<entrainment::BubblePath> paths;
  if (run.n_bubbles > 0) paths = entrainment::read_tracked_bubbles(file).paths;
  entrainment::write_tracked_bubbles(options.tracked, paths);
  nlohmann::json json = result_header("scene_export", "done", common, {{"tracked", options.tracked}}, {file});
  json["n_bubbles"] = paths.size();
  write_json(common, json);
  say(common, "%s: %zu bubbles\n", options.tracked.c_str(), paths.size());
  return kDone;
}

}  // namespace

Subcommand add_scene_export(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* app = group.add_subcommand("export", "Bubbles of a liquid's run for other programs");
  app->add_option("folder", options->folder, "Folder of klang scene run with a liquid")->required();
  app->add_option("--tracked", options->tracked, "Writes trackedBubInfo; a name that ends in .xz is compressed")
      ->required();
  app->footer("Examples:\n  klang scene export pouring --tracked bubbles.txt.xz");
  return {app, [options, &common] { return run_scene_export(*options, common); }};
}

}  // namespace klang::apps
