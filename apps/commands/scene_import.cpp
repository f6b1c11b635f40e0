#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/kit/command.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"
#include "core/sound/liquid_scene/tracked_scene.hpp"

namespace klang::apps {
namespace {

struct ImportOptions {
  std::string file, kind, output, listener, low, high, up = "z";
  liquid_scene::ForeignOptions frames;
};

std::optional<Eigen::Vector3d> optional_vector(const std::string& option, const std::string& text) {
  if (text.empty()) return std::nullopt;
  return parse_vector(option, text);
}

int import_foreign(const ImportOptions& options, const CommonOptions& common, Monitor& monitor) {
  liquid_scene::ForeignOptions asked = options.frames;
  asked.frames = options.file;
  if (options.file.find('#') == std::string::npos && !std::filesystem::exists(options.file))
    throw InputError(
        options.file, "no such file or folder", {},
        options.kind == "openfoam" ? "the folder of a case" : "frames with # for their number: f_####." + options.kind);
  asked.low_m = optional_vector("--low", options.low);
  asked.high_m = optional_vector("--high", options.high);
  if (options.up != "y" && options.up != "z") throw InputError("command line", "--up", options.up, "y or z");
  asked.y_up = options.up == "y";
  asked.validate();
  const std::unique_ptr<liquid_scene::ForeignFrames> frames = options.kind == "vdb"   ? vdb_frames(asked, monitor)
                                                              : options.kind == "vtp" ? surface_frames(asked, monitor)
                                                                                      : openfoam_frames(asked, monitor);
  const nlohmann::json asked_json = {
      {"kind", options.kind}, {"frame_step_s", asked.frame_step_s}, {"unit_m", asked.unit_m}, {"up", options.up}};
  const ResultHeader header = make_header("liquid_scene", "done", common, asked_json, frames->files());
  std::string name = std::filesystem::path(options.file).stem().string();
  name.erase(std::remove(name.begin(), name.end(), '#'), name.end());
  while (!name.empty() && (name.back() == '_' || name.back() == '.' || name.back() == '-')) name.pop_back();
  if (name.empty() || name == "." || name == "..") name = options.kind;
  const liquid_scene::RunDocument document =
      import_frames(*frames, {options.kind, name, optional_vector("--listener", options.listener)}, header,
                    liquid_scene::RunFolder(options.output), monitor);
  for (const std::string& warning : document.header.warnings) warn(warning);
  write_json(common, json_of(document));
  const liquid::GridShape& shape = frames->shape();
  say(common, "%s: %lld frames of %d x %d x %d cells of %g m, %g s; low corner at %g, %g, %g m of the files\n",
      options.output.c_str(), static_cast<long long>(document.n_frames), shape.nx, shape.ny, shape.nz, shape.cell_m,
      document.end_s, frames->low_m().x(), frames->low_m().y(), frames->low_m().z());
  return kDone;
}

int run_scene_import(const ImportOptions& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  if (options.kind == "vdb" || options.kind == "vtp" || options.kind == "openfoam")
    return import_foreign(options, common, monitor);
  if (options.kind != "tracked")
    throw InputError("command line", "--kind", options.kind, "vdb, vtp, openfoam or tracked");
  const std::optional<Eigen::Vector3d> listener = optional_vector("--listener", options.listener);
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
  if (tracked.n_outside > 0)
    note_left_out(std::to_string(tracked.n_outside) +
                  " bubble(s) have samples before Start: or after End:; they begin and end with these");
  const liquid_scene::RunDocument document = liquid_scene::import_tracked(
      tracked, path.stem().string(), listener, header, liquid_scene::RunFolder(options.output));
  write_json(common, json_of(document));
  say(common, "%s: %lld bubbles\n", options.output.c_str(), static_cast<long long>(document.n_bubbles));
  return kDone;
}

}  // namespace

Subcommand add_scene_import(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* app =
      group.add_subcommand("import", "A scene of what other programs have computed: liquids, or tracked bubbles");
  app->add_option("file", options->file,
                  "Series f_####.vdb, f_####.vtp (.vtu, .obj) or f.pvd; folder of an OpenFOAM case; trackedBubInfo, as "
                  "text or .xz")
      ->required();
  app->add_option("-o,--output", options->output, "New folder")->required();
  app->add_option("--kind", options->kind,
                  "vdb: level sets, grid phi; vtp: closed surfaces (.vtp, .vtu, .obj); openfoam: a case; tracked: "
                  "bubbles with paths and pitches (trackedBubInfo)")
      ->required();
  app->add_option("--frame-step-s", options->frames.frame_step_s, "Seconds between numbered files");
  app->add_option("--unit-m", options->frames.unit_m, "Metres per unit of the files (default 1)");
  app->add_option("--up", options->up, "Axis of the files that points up: z (default) or y");
  app->add_option("--low", options->low, "Low corner x,y,z [m] of the vessel's inner walls, z up");
  app->add_option("--high", options->high, "Its high corner");
  app->add_option("--cell-m", options->frames.cell_m,
                  "Cell of the distances (vtp: about an edge; openfoam: about a cell)");
  app->add_option("--field", options->frames.field, "openfoam: share of liquid (default: the first alpha.*)");
  app->add_option(
      "--listener", options->listener,
      "Head's centre x,y,z [m] in the files' place, z up (tracked: above 0; the file's x, y, z are our x, z, -y)");
  app->footer(
      "Examples:\n"
      "  klang scene import splash_####.vdb --kind vdb --frame-step-s 0.04 -o DIR\n"
      "  klang scene run DIR/scene.toml -o DIR --stage bubbles\n"
      "  klang scene import bubbles.txt.xz --kind tracked --listener 0,-1,0.5 -o DIR\n"
      "  klang scene run DIR/scene.toml -o DIR --stage transfer");
  return {app, [options, &common] { return run_scene_import(*options, common); }};
}

}  // namespace klang::apps
