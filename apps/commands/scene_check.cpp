#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "apps/commands/liquid_run.hpp"
#include "apps/commands/scene_folder.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/scene/scene_check.hpp"

namespace klang::apps {
namespace {

int run_scene_check(const std::string& file, const CommonOptions& common) {
  if (is_liquid_file(file)) return check_liquid(file, common);
  TerminalMonitor monitor(common.quiet);
  const scene::Scene scene = scene::read_scene(file);
  std::vector<std::string> warnings;
  scene::SceneCheckDocument document = scene::check_scene(scene, common.seed, scene_notes(common, warnings), monitor);
  for (const std::string& warning : document.header.warnings) warn(warning);
  warnings.insert(warnings.end(), document.header.warnings.begin(), document.header.warnings.end());
  document.header = make_header("scene_check", "ok", common, nlohmann::json::object(), scene.inputs());
  document.header.warnings = warnings;
  write_json(common, json_of(document));
  say(common, "%-24s %12s %12s %10s %7s %s\n", "body", "mass_kg", "size_m", "material", "parts", "sound");
  for (const scene::CheckedBody& body : document.bodies)
    say(common, "%-24s %12.6g %12.4g %10s %7d %s%s\n", body.name.c_str(), body.mass_kg, body.size_m,
        body.material.c_str(), body.n_parts, body.sound.c_str(), body.fixed ? ", fixed" : "");
  if (document.n_steps)
    say(common, "%d steps of %g s\n", *document.n_steps, 1.0 / scene.solver.rate_hz);
  else
    say(common, "steps of %g s until all rests\n", 1.0 / scene.solver.rate_hz);
  return kDone;
}

}  // namespace

Subcommand add_scene_check(CLI::App& group, CommonOptions& common) {
  auto file = std::make_shared<std::string>();
  CLI::App* app =
      group.add_subcommand("check", "Whether a scene can be run: bodies, masses, overlaps, steps; moves nothing");
  app->add_option("scene", *file, "Scene (TOML, docs/scenes.md; with [domain] docs/liquid.md)")->required();
  app->footer(
      "Examples:\n"
      "  klang scene check datasets-synthetic/scenes/s02/chimes.toml\n"
      "  klang scene check scene.toml --json c.json");
  return {app,
          [file, &common] { return run_scene_check(*file, common); },
          {result_kind<scene::SceneCheckDocument>("scene_check", "--json of `klang scene check`"),
           result_kind<LiquidCheckDocument>("liquid_scene_check", "--json of `klang scene check` with a liquid")}};
}

}  // namespace klang::apps
