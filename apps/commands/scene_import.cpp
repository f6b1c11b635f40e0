#include <CLI/CLI.hpp>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/liquid_scene/tracked_scene.hpp"

namespace klang::apps {
namespace {

struct ImportOptions {
  std::string file, kind, output, listener;
};

int run_scene_import(const ImportOptions& options, const CommonOptions& common) {
  if (options.kind != "tracked") throw InputError("command line", "--kind", options.kind, "tracked");
  std::optional<Eigen::Vector3d> listener;
  if (!options.listener.empty()) listener = parse_vector("--listener", options.listener);
  const std::filesystem::path path(options.file);
  const entrainment::TrackedBubbles tracked = entrainment::read_tracked_bubbles(path);
  ResultHeader header = make_header("liquid_scene", "done", common, {{"kind", options.kind}}, {path});
  const auto note_left_out = [&](const std::string& text) {
    header.warnings.push_back(text);
    warn(text);
  };
  if (tracked.n_without_frequency > 0)
    note_left_out(std::to_string(tracked.n_without_frequency) + " sample(s) without a frequency are left out");
  if (tracked.n_left_out > 0)
    note_left_out(std::to_string(tracked.n_left_out) + " bubble(s) without any frequency are left out");
  const liquid_scene::RunDocument document = liquid_scene::import_tracked(
      tracked, path.stem().string(), listener, header, liquid_scene::RunFolder(options.output));
  write_json(common, json_of(document));
  say(common, "%s: %lld bubbles\n", options.output.c_str(), static_cast<long long>(document.n_bubbles));
  return kDone;
}

}  // namespace

Subcommand add_scene_import(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* app = group.add_subcommand("import", "A scene of what other programs have computed: tracked bubbles");
  app->add_option("file", options->file, "trackedBubInfo, as text or .xz")->required();
  app->add_option("-o,--output", options->output, "New folder")->required();
  app->add_option("--kind", options->kind, "tracked: bubbles with paths and pitches (trackedBubInfo)")->required();
  app->add_option("--listener", options->listener,
                  "Head's centre x,y,z [m], z up and above 0 (the file's x, y, z are our x, z, -y)");
  app->footer(
      "Examples:\n"
      "  klang scene import bubbles.txt.xz --kind tracked --listener 0,-1,0.5 -o DIR\n"
      "  klang scene run DIR/scene.toml -o DIR --stage transfer");
  return {app, [options, &common] { return run_scene_import(*options, common); }};
}

}  // namespace klang::apps
