#include <CLI/CLI.hpp>
#include <charconv>
#include <memory>

#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/geometry/shapes/profile_dimensions.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "core/physics/solid/support_doubt.hpp"
#include "core/sound/audio/note.hpp"
#include "fit/instrument/fitted_body.hpp"
#include "fit/tune/tune_document.hpp"

namespace klang::apps {
namespace {

struct TuneCommand {
  std::string shape, dims, profile, from, specimen, output;
  std::string material = "aluminium";
  std::string temperament = "equal";
  double a4_hz = audio::kConcertPitchHz;
  std::string support = "free";
  std::vector<std::string> vary;
  std::vector<std::string> targets;
  fit::TuneOptions tune;
};

/// "587.33" or "D5".
double parse_pitch(const std::string& text, const audio::Temperament& temperament, double a4_hz) {
  if (text.empty() || std::isdigit(static_cast<unsigned char>(text.front())) || text.front() == '.' ||
      text.front() == '-')
    return parse_assignments("--target", "hz=" + text).at("hz");
  try {
    return temperament.frequency_hz(audio::key_of_note(text), a4_hz);
  } catch (const InputError& error) {
    throw InputError("--target", error.what());
  }
}

/// "0=587.33", "bending 1=C4", "bending 2/bending 1=4", or "D5" for the mode that is heard first.
fit::TuneTarget parse_target(const std::string& text, const mesh::ShapeSpec& shape,
                             const audio::Temperament& temperament, double a4_hz) {
  const std::size_t equals = text.rfind('=');
  fit::TuneTarget target;
  if (equals == std::string::npos) {
    target.mode = mesh::find_shape(shape.kind).long_axis(shape) ? "bending 1" : "0";
    target.frequency_hz = parse_pitch(text, temperament, a4_hz);
    return target;
  }
  target.mode = text.substr(0, equals);
  const std::size_t slash = target.mode.find('/');
  if (slash == std::string::npos) {
    target.frequency_hz = parse_pitch(text.substr(equals + 1), temperament, a4_hz);
    return target;
  }
  target.over = target.mode.substr(slash + 1);
  target.mode.resize(slash);
  target.ratio = parse_assignments("--target", "ratio" + text.substr(equals)).at("ratio");
  return target;
}

struct Start {
  fit::Specimen specimen;
  solid::Material material;
};

/// The body to start from: of a fit, or by --shape, --dims and --material.
Start start_of(const TuneCommand& options) {
  Start start;
  if (options.from.empty()) {
    if (options.shape.empty() || (options.dims.empty() && options.profile.empty()))
      throw InputError("tune", "no body is given", "", "--from FIT, or --shape and --dims or --profile");
    start.specimen.name = options.shape;
    mesh::ShapeSpec shape{options.shape, {}, options.profile};
    if (!options.dims.empty()) shape.dims = parse_assignments("--dims", options.dims);
    start.specimen.shape = shape;
    mesh::validate(*start.specimen.shape);
    start.material = parse_material(options.material);
  } else {
    if (!options.shape.empty()) throw InputError("--from", "excludes --shape", options.from);
    const fit::FitDocument fit = fit::read_fit_document(options.from);
    const fit::SpecimenRecord& record = fit::specimen_of(fit, options.specimen, options.from);
    start.specimen.name = record.name;
    start.specimen.shape = fit::fitted_shape(fit, record, options.from);
    if (!options.dims.empty())
      for (const auto& [name, value] : parse_assignments("--dims", options.dims))
        start.specimen.shape->dims[name] = value;
    mesh::validate(*start.specimen.shape);
    const mesh::ShapeSpec struck = fit::fitted_shape(fit, record, options.from);
    start.material = fit::stock_material(fit, record, struck, options.from);
  }
  start.specimen.support = solid::parse_support(options.support);
  return start;
}

std::vector<std::filesystem::path> inputs_of(const TuneCommand& options) {
  std::vector<std::filesystem::path> files;
  for (const std::string& file : {options.from, options.profile, is_fit_file(options.material) ? options.material : ""})
    if (!file.empty()) files.emplace_back(file);
  return files;
}

int run_tune(const TuneCommand& options, const CommonOptions& common) {
  TerminalMonitor monitor(common.quiet);
  checked("command line", "--a4-hz", options.a4_hz, audio::kLowestA4Hz, audio::kHighestA4Hz);
  const audio::Temperament temperament = audio::Temperament::parse(options.temperament);
  if (options.from.empty() && !options.specimen.empty())
    throw InputError("--specimen", "belongs to --from", options.specimen);
  const auto [specimen, material] = start_of(options);
  if (specimen.support.kind != solid::SupportKind::kFree)
    if (const std::string doubt = solid::support_doubt(specimen.support, mesh::mesh_shape(*specimen.shape));
        !doubt.empty())
      warn(doubt);
  if (!options.output.empty() && specimen.shape->profile_csv.empty())
    throw InputError("--output", "is for the profile of a revolution", options.output);
  std::vector<std::string> warnings;
  mesh::ShapeMeshOptions coarse;
  coarse.order = 1;
  for (const std::string& warning : mesh::body_warnings(mesh::mesh_shape(*specimen.shape, coarse), 1.0, {})) {
    warnings.push_back((options.profile.empty() ? "--dims" : options.profile) + ": " + warning);
    warn(warnings.back());
  }
  fit::TuneOptions tune = options.tune;
  tune.dimensions = options.vary;
  for (const std::string& target : options.targets)
    tune.targets.push_back(parse_target(target, *specimen.shape, temperament, options.a4_hz));
  const fit::TuneResult result = fit::tune_dimensions(specimen, material, tune, monitor);

  const nlohmann::json used = {{"vary", options.vary},
                               {"targets", options.targets},
                               {"widest_change", tune.widest_change},
                               {"tolerance_cents", tune.tolerance_cents}};
  fit::TuneDocument document =
      fit::tune_document(result, make_provenance(common.command_line, common.seed, used, inputs_of(options)));
  document.header.warnings.insert(document.header.warnings.end(), warnings.begin(), warnings.end());
  write_json(common, json_of(document));
  if (!options.output.empty()) write_file(options.output, mesh::profile_csv(result.shape));
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
  app->add_option("--shape", options->shape, "Shape, as in klang modes");
  app->add_option("--from", options->from, "fit.json of klang fit: start from one of its specimens, with its material");
  app->add_option("--specimen", options->specimen, "Of --from, where it has several");
  app->add_option("--dims", options->dims,
                  "Its dimensions to start from: name_m=value,... (with --from: those that differ)");
  app->add_option("--profile", options->profile, "revolution: CSV file of the closed profile");
  app->add_option("--material", options->material, "As in klang modes")->capture_default_str();
  app->add_option("--support", options->support, "As in klang modes")->capture_default_str();
  app->add_option("-o,--output", options->output, "revolution: CSV file for the tuned profile");
  app->add_option("--vary", options->vary,
                  "Dimension that may change; may be repeated. Of a profile: size_m, and wall_N_m of its zone N")
      ->required();
  app->add_option(
         "--target", options->targets,
         "MODE=HZ or MODE=NOTE, MODE/MODE=RATIO, or a NOTE alone for the first bending (else lowest) mode; MODE is an "
         "index from 0, \"bending N\", of a body of revolution \"ring M,K\" (the K-th with M nodal diameters) or hum, "
         "prime, "
         "tierce, quint, nominal; may be repeated")
      ->required();
  app->add_option("--a4-hz", options->a4_hz, "Frequency of A4, 300 to 600")->capture_default_str();
  app->add_option("--temperament", options->temperament, "Of notes: equal, just (from C) or a Scala file (.scl)")
      ->capture_default_str();
  add_fields(*app, common, options->tune, {{"widest_change"}, {"tolerance_cents"}});
  app->footer(
      "Examples (a chime brought to D5; a fitted one; a marimba bar 1:4; a bell):\n"
      "  klang tune --shape tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 --material aluminium \\\n"
      "    --vary length_m --target \"bending 1=587.33\"\n"
      "  klang tune --from chimes/fit.json --specimen D5 --vary length_m --target E5\n"
      "  klang tune --shape undercut_bar --material youngs_modulus_pa=1.6e10,poissons_ratio=0.35,density_kg_m3=830 \\\n"
      "    --dims length_m=0.4,width_m=0.05,height_m=0.022,undercut_length_m=0.24,undercut_depth_m=0.012 \\\n"
      "    --vary undercut_depth_m --target \"bending 2/bending 1=4\"\n"
      "  klang tune --shape revolution --profile bell.csv --material bronze --vary size_m --vary wall_1_m --vary "
      "wall_2_m \\\n"
      "    --target nominal=A5 --target prime/hum=2 --target tierce/hum=2.4 -o tuned.csv");
  return {app,
          [options, &common] { return run_tune(*options, common); },
          {result_kind<fit::TuneDocument>("tune", "the result of `klang tune`")}};
}

}  // namespace klang::apps
