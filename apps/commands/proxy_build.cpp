#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>

#include "apps/commands/proxy_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"

namespace klang::apps {
namespace {

struct ProxyBuildOptions {
  std::string output;
  double youngs_modulus_pa = 6.2e10, poissons_ratio = 0.2, density_kg_m3 = 2600.0;  // glass of SB Table 1
  soundbank::BuildOptions build;
};

nlohmann::json options_json(const ProxyBuildOptions& o) {
  return {{"youngs_modulus_pa", o.youngs_modulus_pa},
          {"poissons_ratio", o.poissons_ratio},
          {"density_kg_m3", o.density_kg_m3},
          {"air_density_kg_m3", o.build.medium.density_kg_m3},
          {"air_sound_speed_m_s", o.build.medium.sound_speed_m_s},
          {"tolerance", o.build.tolerance},
          {"thinnest", o.build.thinnest},
          {"modes", o.build.modes_per_cell},
          {"checked_modes", o.build.n_checked_modes},
          {"degree", o.build.degree},
          {"check_shapes", o.build.check_shapes},
          {"boundary_tolerance", o.build.boundary_tolerance},
          {"radiation", o.build.radiation}};
}

int run_proxy_build(ProxyBuildOptions o, const CommonOptions& common) {
  if (o.output.empty()) throw InputError("-o", "is missing", "", "a file for the bank");
  if (std::filesystem::is_directory(o.output)) throw InputError("-o", "is a folder", o.output, "a file for the bank");
  o.build.material = solid::from_youngs_modulus(o.youngs_modulus_pa, o.poissons_ratio, o.density_kg_m3);
  o.build.n_checked_modes = std::min(o.build.n_checked_modes, o.build.modes_per_cell);
  o.build.validate();
  const nlohmann::json used = options_json(o);
  // Of a stopped build: what it had finished, beside the output, good for the same options only.
  const std::filesystem::path partial = o.output + ".partial";
  const std::string key = nlohmann::json({{"options", used}, {"version", version()}}).dump();
  soundbank::BuildProgress known;
  if (std::filesystem::exists(partial)) {
    try {
      if (auto found = soundbank::read_build_progress(partial, key)) known = std::move(*found);
    } catch (const InputError&) {  // another program's file or a damaged one: start afresh, and say so
      warn(partial.string() + " cannot be read: starting afresh");
    }
    if (!known.frequencies.empty())
      say(common, "going on after %zu shapes and %zu cells (%s)\n", known.frequencies.size(), known.cells.size(),
          partial.c_str());
  }
  TerminalMonitor monitor(common.quiet);
  soundbank::BuildResult result = soundbank::build_soundbank(
      o.build, monitor, std::move(known),
      [&](const soundbank::BuildProgress& p) { soundbank::write_build_progress(partial, p, key); });
  if (result.status != soundbank::BuildStatus::kDone)
    throw NumericalError(result.message + ": reached " + to_text(result.bank.max_interpolation_error));
  ProxyBuildDocument document;
  document.header = make_header("proxy_build", "done", common, used, {});
  result.bank.provenance_json = json_of(document.header.provenance).dump();
  soundbank::write_soundbank(o.output, result.bank);
  std::error_code ignored;
  std::filesystem::remove(partial, ignored);
  document.n_cells = result.bank.cells.size();
  document.n_nodes = result.bank.nodes.size();
  document.max_interpolation_error = result.bank.max_interpolation_error;
  document.bytes = std::filesystem::file_size(o.output);
  write_json(common, json_of(document));
  say(common,
      "%s: %zu cells with sound, %zu shapes with frequencies; first %d frequencies within %.3g %% at %d unseen "
      "shapes\n",
      o.output.c_str(), result.bank.cells.size(), result.bank.nodes.size(), result.bank.n_checked_modes,
      100.0 * result.bank.max_interpolation_error, result.bank.n_check_shapes);
  return kDone;
}

}  // namespace

Subcommand add_proxy_build(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<ProxyBuildOptions>();
  CLI::App* app = group.add_subcommand("build", "Precompute modes and sound of ellipsoids of all shapes");
  app->add_option("-o,--output", options->output, "The bank")->required();
  app->add_option("--poissons-ratio", options->poissons_ratio, "Frequencies and shapes depend on it alone")
      ->capture_default_str();
  app->add_option("--youngs-modulus-pa", options->youngs_modulus_pa,
                  "With the density: the wave speed, on which the radiation depends")
      ->capture_default_str();
  app->add_option("--density-kg-m3", options->density_kg_m3, "Density of the solid")->capture_default_str();
  add_fields(*app, common, options->build,
             {{"medium.density_kg_m3", "--air-density-kg-m3"},
              {"medium.sound_speed_m_s", "--air-sound-speed-m-s", "Its sound speed"},
              {"tolerance"},
              {"thinnest"},
              {"modes_per_cell", "--modes"},
              {"n_checked_modes", "--checked-modes"},
              {"degree"},
              {"check_shapes"},
              {"boundary_tolerance"},
              {"radiation", "!--no-radiation", "Modes and frequencies only"}});
  app->footer(
      "Examples:\n"
      "  klang proxy build --poissons-ratio 0.2 --tolerance 0.01 -o glass.bank --json b.json\n"
      "  klang proxy build --no-radiation --thinnest 0.2 --tolerance 0.05 -o quick.bank\n"
      "A run that was stopped goes on where it stopped when it is started again with the same options.");
  return {app,
          [options, &common] { return run_proxy_build(*options, common); },
          {result_kind<ProxyBuildDocument>("proxy_build", "the result of `klang proxy build`")}};
}

}  // namespace klang::apps
