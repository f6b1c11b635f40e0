#include <CLI/CLI.hpp>
#include <charconv>
#include <memory>

#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "fit/tune/tune_document.hpp"

namespace klang::apps {
namespace {

struct TuneCommand {
  std::string shape, dims, profile;
  std::string material = "aluminium";
  std::string support = "free";
  std::vector<std::string> vary;
  std::vector<std::string> targets;
  fit::TuneOptions tune;
};

/// "0=587.33" or "bending 1=587.33".
fit::TuneTarget parse_target(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos)
    throw InputError("--target", "is not MODE=HZ", text, "for example 0=587.33 or \"bending 1=587.33\"");
  const auto values = parse_assignments("--target", "hz" + text.substr(equals));
  return {text.substr(0, equals), values.at("hz")};
}

int run_tune(const TuneCommand& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  fit::Specimen specimen;
  specimen.name = options.shape;
  specimen.shape = mesh::ShapeSpec{options.shape, parse_assignments("--dims", options.dims), options.profile};
  mesh::validate(*specimen.shape);
  specimen.support = solid::parse_support(options.support);
  const solid::Material material = parse_material(options.material);
  fit::TuneOptions tune = options.tune;
  tune.dimensions = options.vary;
  for (const std::string& target : options.targets) tune.targets.push_back(parse_target(target));
  const fit::TuneResult result = fit::tune_dimensions(specimen, material, tune, monitor);

  const nlohmann::json used = {{"vary", options.vary},
                               {"targets", options.targets},
                               {"widest_change", tune.widest_change},
                               {"tolerance_cents", tune.tolerance_cents}};
  write_json(common, json_of(fit::tune_document(result, make_provenance(common.command_line, common.seed, used, {}))));
  for (const fit::TunedDimension& d : result.dimensions) {
    say(common, "%-18s %.6f m -> %.6f m (%+.3f mm)%s\n", d.name.c_str(), d.start_m, d.value_m,
        1e3 * (d.value_m - d.start_m), d.at_bound ? "  at its bound" : "");
  }
  for (const fit::TunedTarget& t : result.targets) {
    say(common, "mode %-13s wanted %.3f Hz, was %.3f Hz, now %.3f Hz (%+.3f cents)", t.mode.c_str(), t.wanted_hz,
        t.start_hz, t.reached_hz, t.residual_cents);
    for (std::size_t i = 0; i < t.hz_per_mm.size(); ++i) {
      say(common, "; %s: %+.3f Hz/mm, %+.2f cents per 0.1 mm", result.dimensions[i].name.c_str(), t.hz_per_mm[i],
          t.cents_per_tenth_mm[i]);
    }
    say(common, "\n");
  }
  if (!result.usable()) {
    warn(result.message);
    return kCheckNotPassed;
  }
  return kDone;
}

}  // namespace

Subcommand add_tune(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<TuneCommand>();
  CLI::App* app = program.add_subcommand("tune", "Dimensions that bring given modes to given frequencies");
  app->add_option("--shape", options->shape, "Shape, as in klang modes")->required();
  app->add_option("--dims", options->dims, "Its dimensions to start from: name_m=value,...")->required();
  app->add_option("--profile", options->profile, "revolution: CSV file of the closed profile");
  app->add_option("--material", options->material, "As in klang modes")->capture_default_str();
  app->add_option("--support", options->support, "As in klang modes")->capture_default_str();
  app->add_option("--vary", options->vary, "Dimension that may change; may be repeated")->required();
  app->add_option("--target", options->targets, "MODE=HZ; MODE is an index from 0 or \"bending N\"; may be repeated")
      ->required();
  add_fields(*app, common, options->tune, {{"widest_change"}, {"tolerance_cents"}});
  app->footer(
      "Example (a chime brought to D5):\n"
      "  klang tune --shape tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 --material aluminium \\\n"
      "    --vary length_m --target \"bending 1=587.33\"");
  return {app,
          [options, &common] { return run_tune(*options, common); },
          {result_kind<fit::TuneDocument>("tune", "the result of `klang tune`")}};
}

}  // namespace klang::apps
