#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "apps/commands/liquid_run.hpp"
#include "apps/commands/scene_folder.hpp"
#include "apps/kit/command.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/events/event_log_file.hpp"
#include "core/physics/events/world_impulses.hpp"

namespace klang::apps {
namespace {

int run_scene_info(const std::string& source, const std::string& csv, const CommonOptions& common) {
  const SceneFolder folder(source);
  if (!folder.has("scene.json") && is_liquid_folder(source)) {
    if (!csv.empty()) throw InputError("--impulses-csv", "a liquid has no impulses", source);
    return show_liquid(source, common);
  }
  const std::filesystem::path path = folder.file("scene.json");
  const nlohmann::json json = read_result_json(path);
  if (text_under(json, "kind") != "scene") throw InputError(path.string(), "is no result of klang scene run");
  const auto document = read_fields<scene::SceneDocument>(json, path.string());
  if (!csv.empty())
    write_file(csv, csv_table(events::world_impulses(events::read_event_log(folder.file(document.files.events)))));
  write_json(common, json);
  say(common, "%s: %.4f s of motion, %d steps at %g per second\n", document.name.c_str(), document.end_s,
      document.n_steps, document.rate_hz);
  std::vector<scene::BodyRecord> bodies = document.bodies;
  std::stable_sort(bodies.begin(), bodies.end(), [](const auto& a, const auto& b) {
    return a.hardest_impact_n_s.value_or(0.0) > b.hardest_impact_n_s.value_or(0.0);
  });
  say(common, "%-24s %10s %8s %9s %14s  %s\n", "body, hardest hit first", "mass_kg", "modes", "impacts", "hardest_n_s",
      "ends at x_m, y_m, z_m");
  for (const scene::BodyRecord& body : bodies)
    say(common, "%-24s %10.4g %8d %9d %14.4g  %.4f, %.4f, %.4f\n", body.name.c_str(), body.mass_kg, body.n_modes,
        body.n_impacts, body.hardest_impact_n_s.value_or(0.0), body.final.position_m[0], body.final.position_m[1],
        body.final.position_m[2]);
  const scene::ImpulsesRecord& impulses = document.impulses_summary;
  say(common,
      "%d impacts, %d steps of lasting contacts; ledger: residual %.1e of %.4g J, %.4g J lost in contacts, %.4g J "
      "by friction\n",
      impulses.n_impacts, impulses.n_lasting, document.ledger.residual_relative, document.ledger.energy_scale_j,
      document.ledger.contact_j, document.ledger.friction_j);
  if (const scene::LedgerRecord& ledger = document.ledger;
      ledger.most_strain_j > 0.0 || ledger.viscous_j > 0.0 || ledger.plastic_j > 0.0)
    say(common,
        "%.4g J put in by what is held, %.4g J of strain at most, %.4g J lost to viscosity, %.4g J to plastic flow\n",
        ledger.work_j, ledger.most_strain_j, ledger.viscous_j, ledger.plastic_j);
  for (const scene::SceneEventRecord& event : document.events)
    say(common, "%.6f s: %s of %s into %d pieces\n", event.time_s, event.kind.c_str(), event.body.c_str(),
        event.pieces);
  if (document.sound)
    say(common, "%s: %.2f s, peak %.4g Pa\n", document.sound->file.c_str(), document.sound->duration_s,
        document.sound->peak_pressure_pa);
  return kDone;
}

}  // namespace

Subcommand add_scene_info(CLI::App& group, CommonOptions& common) {
  auto source = std::make_shared<std::string>(), csv = std::make_shared<std::string>();
  CLI::App* app = group.add_subcommand("info", "Bodies, events and energies of a scene that was run");
  app->add_option("folder", *source, "Folder of klang scene run")->required();
  app->add_option("--impulses-csv", *csv,
                  "Writes every impulse as a table: places in the body's frame, impulses in the world's axes");
  app->footer(
      "Examples:\n"
      "  klang scene info chimes\n"
      "  klang scene info chimes --impulses-csv impulses.csv");
  return {app, [source, csv, &common] { return run_scene_info(*source, *csv, common); }};
}

}  // namespace klang::apps
