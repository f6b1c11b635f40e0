#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/modes_document.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/solid/support_doubt.hpp"

namespace klang::apps {
namespace {

struct ModesOptions {
  BodyOptions body;
  std::string material = "aluminium";
  std::string support = "free";
  int count = 0;
  std::string band = "0:20000";
  bool band_is_asked_for = false;
  std::string output;
  std::string method = "auto";
  bool lumped_mass = false, no_mesh_error = false;
};

// Of a body that nobody gave a count or a band for: more than these are of no use, and take long.
constexpr int kMostModes = 500;
constexpr double kErrorToWarnOf = 1e-3;
// From here on a mesh is too coarse for what it says of itself: 0.07 was seen where 0.24 was true (a disc of one layer, 1 mm).
constexpr double kErrorThatCanBeBounded = 0.03;

modal::ModesMethod parsed_method(const std::string& word) {
  return word == "polynomial"   ? modal::ModesMethod::kPolynomial
         : word == "harmonics"  ? modal::ModesMethod::kHarmonics
         : word == "tetrahedra" ? modal::ModesMethod::kTetrahedra
                                : modal::ModesMethod::kAuto;
}

/// How far the mesh's own error reaches, where that is more than the program promises.
std::string coarse_mesh_warning(const std::vector<modal::ModeRecord>& modes) {
  int n = 0;
  double worst = 0.0;
  for (const modal::ModeRecord& mode : modes) {
    if (!mode.mesh_relative_error || *mode.mesh_relative_error <= kErrorToWarnOf) continue;
    ++n;
    worst = std::max(worst, *mode.mesh_relative_error);
  }
  if (n == 0) return {};
  char text[200];
  std::snprintf(
      text, sizeof text,
      "%d of %zu frequencies are too high by more than 0.1 %% (up to %.2g %%) by the mesh's estimate; a finer "
      "mesh (--refine, --max-edge-m) brings them down",
      n, modes.size(), 100.0 * worst);
  if (worst <= kErrorThatCanBeBounded) return text;
  return std::string(text) + "; above 3 % the estimate is no bound";
}

void say_modes(const modal::ModesDocument& document, const mesh::TetMesh& mesh, const ModesOptions& options,
               const CommonOptions& common) {
  say(common, "%d nodes, %d %s elements%s; %d rigid modes; ", mesh.n_nodes(), mesh.n_elements(),
      mesh.order() == 2 ? "quadratic" : "linear",
      document.method == "harmonics"    ? ", frequencies by harmonics of the section"
      : document.method == "polynomial" ? ", frequencies by polynomials"
                                        : "",
      *document.n_rigid_modes);
  say(common, "%s\n",
      !document.none_missing   ? "completeness not checked"
      : *document.none_missing ? "none missing (proven)"
                               : "MODES ARE MISSING");
  if (const int n = document.n_below_band.value_or(0); n > 0)
    say(common, "%d mode%s below the band, not listed\n", n, n == 1 ? "" : "s");
  say(common, "%6s %14s %14s %10s %10s\n", "index", "frequency_hz", "period_s", "residual", "mesh_error");
  for (const modal::ModeRecord& mode : document.modes) {
    char error[16] = "-";
    if (mode.mesh_relative_error) std::snprintf(error, sizeof error, "%.1e", *mode.mesh_relative_error);
    say(common, "%6d %14.4f %14.6g %10.1e %10s\n", mode.index, mode.frequency_hz, 1.0 / mode.frequency_hz,
        *mode.relative_residual, error);
  }
  if (document.modes.empty()) say(common, "no mode in the band\n");
  if (const int n = document.n_left_out.value_or(0); n > 0)
    say(common, "the lowest %zu modes are listed, %d more lie below %s Hz (--count, --band-hz)\n",
        document.modes.size(), n, options.band.substr(options.band.find(':') + 1).c_str());
}

int run_modes(const ModesOptions& options, const CommonOptions& common) {
  const Stopwatch watch;
  TerminalMonitor monitor(common.quiet);
  const solid::Material material = parse_material(options.material);
  const solid::Support support = solid::parse_support(options.support);
  modal::ModesOptions how;
  how.method = parsed_method(options.method);
  how.mass = options.lumped_mass ? solid::MassKind::kLumped : solid::MassKind::kConsistent;
  how.mesh_is_wanted = options.body.max_edge_m != 0.0 || options.body.refinement != 0;
  modal::EigenOptions& eigen = how.eigen;
  eigen.count = options.count;
  eigen.band = parse_band("--band-hz", options.band);
  if (!options.band_is_asked_for) eigen.most = kMostModes;
  // The estimate is made for the consistent matrix.
  eigen.estimate_mesh_error = !options.lumped_mass && !options.no_mesh_error;
  eigen.validate();
  const modal::ModesBody body{options.body.shape_spec(), support, options.body.element == "p2" ? 2 : 1};
  if (how.method == modal::ModesMethod::kHarmonics && !modal::harmonics_apply(body, how.mass))
    throw InputError("--method", "needs a free body of revolution, p2 and no --lumped-mass", options.body.shape,
                     modal::harmonics_apply_to());
  if (how.method == modal::ModesMethod::kPolynomial && !modal::polynomials_apply(body, how.mass))
    throw InputError("--method", "polynomial needs one of a few bodies, p2 and no --lumped-mass", options.body.shape,
                     modal::polynomials_apply_to());
  const modal::ModesMethod method = modal::chosen_method(body, how);

  monitor.progress("mesh", 0.0);
  mesh::BodyNotes notes;
  std::vector<std::string> warnings;
  const mesh::TetMesh mesh = options.body.build_and_tell(common, notes, warnings, monitor);
  const double mesh_s = watch.seconds();
  monitor.throw_if_stopped();
  if (const std::string doubt = solid::support_doubt(support, mesh); !doubt.empty()) {
    warn(doubt);
    warnings.push_back(doubt);
  }
  const modal::EigenResult result = modal::modes_of(body, mesh, material, how, monitor);
  if (!result.usable()) throw NumericalError("modes: " + result.message);

  const nlohmann::json used = {{"material",
                                {{"lame_lambda_pa", material.lame_lambda_pa},
                                 {"lame_mu_pa", material.lame_mu_pa},
                                 {"density_kg_m3", material.density_kg_m3}}},
                               {"element", options.body.element},
                               {"support", options.support},
                               {"count", options.count},
                               {"band_hz", {eigen.band.low_hz, eigen.band.high_hz}},
                               {"method", modal::to_text(method)},
                               {"max_edge_m", options.body.max_edge_m},
                               {"refinement", options.body.refinement}};
  modal::ModesDocument document;
  document.header = make_header("modes", "converged", common, used, options.body.inputs(options.material));
  document.header.warnings = warnings;
  if (!result.message.empty()) document.header.warnings.push_back(result.message);
  document.repairs = notes.repairs;
  document.decimation = notes.decimation;
  document.n_below_band = result.n_below_band;
  document.n_left_out = result.n_left_out;
  document.n_nodes = mesh.n_nodes();
  document.n_elements = mesh.n_elements();
  document.element = mesh.order() == 2 ? "p2" : "p1";
  document.method = modal::to_text(method);
  document.n_rigid_modes = result.n_rigid_modes;
  document.none_missing = result.none_missing;
  const Eigen::VectorXd frequency_hz = result.model.frequency_hz();
  for (Eigen::Index i = 0; i < frequency_hz.size(); ++i) {
    document.modes.push_back({static_cast<int>(i), frequency_hz[i], result.relative_residual[i], {}, {}});
    if (!result.mesh_relative_error) continue;
    const double error = (*result.mesh_relative_error)[i];
    document.modes.back().mesh_relative_error = error;
    // The estimate for tetrahedra is 0.6 of the truth at least while it is small; the others are bounds already.
    if (method != modal::ModesMethod::kTetrahedra) {
      document.modes.back().relative_error_bound = error;
    } else if (std::abs(error) <= kErrorThatCanBeBounded) {
      document.modes.back().relative_error_bound = 2.0 * std::abs(error);
    }
  }
  if (const std::string warning = coarse_mesh_warning(document.modes); !warning.empty()) {
    document.header.warnings.push_back(warning);
    warn(warning);
  }
  if (!options.output.empty())
    modal::write_modal_model(options.output, result.model, json_of(document.header.provenance).dump());
  document.header.wall_time_s = result.wall_time_s;
  document.header.wall_time_s.emplace("mesh", mesh_s);
  document.header.wall_time_s.emplace("assembly", 0.0);
  document.header.wall_time_s["solve"] = result.wall_time_s.at("total");
  document.header.wall_time_s["total"] = watch.seconds();
  document.peak_memory_bytes = modal::peak_memory_bytes();
  write_json(common, json_of(document));

  say_modes(document, mesh, options, common);
  say(common, "%.2f s\n", watch.seconds());
  return result.none_missing.value_or(true) ? kDone : kNumericalFailure;
}

}  // namespace

Subcommand add_modes(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<ModesOptions>();
  CLI::App* app = program.add_subcommand("modes", "Eigenfrequencies and mode shapes of a body");
  options->body.add_to(*app, common);
  app->add_option("--material", options->material,
                  "Preset, fit.json of klang fit, or name=value list: lame_lambda_pa, lame_mu_pa (or "
                  "youngs_modulus_pa, poissons_ratio), "
                  "density_kg_m3")
      ->capture_default_str();
  app->add_option("--support", options->support,
                  "free, clamped:WHERE or pinned:WHERE, WHERE as x=min, y=max, x=0, z<0.01, box:..., set:NAME")
      ->capture_default_str();
  app->add_option("--count", options->count, "Elastic modes from the lowest up, 1 to 2000; default: all in the band")
      ->check(CLI::Range(1, 2000));
  CLI::Option* band = app->add_option("--band-hz", options->band,
                                      "LOW:HIGH in Hz; what lies below is counted, not listed. Without it and without "
                                      "--count: from the lowest mode up, 500 at most")
                          ->capture_default_str();
  app->add_option("--method", options->method,
                  "polynomial: a box, free or held at one face, by Legendre polynomials; harmonics: a free body of "
                  "revolution by Fourier in "
                  "the angle; shapes of both sampled to the mesh; tetrahedra: the mesh itself; auto: the first that "
                  "applies, and "
                  "tetrahedra where a mesh size is asked for")
      ->check(CLI::IsMember({"auto", "polynomial", "harmonics", "tetrahedra"}))
      ->capture_default_str();
  app->add_flag("--no-mesh-error", options->no_mesh_error,
                "Leave out each mode's estimated mesh error: a fifth of the time saved");
  app->add_flag("--lumped-mass", options->lumped_mass, "Diagonal mass matrix");
  app->add_option("-o,--output", options->output, "Write the modal model (.vtu, opens in ParaView)");
  app->footer(
      "Examples:\n"
      "  klang modes --shape tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 --material aluminium "
      "--count 12\n"
      "  klang modes --mesh bowl.msh --material youngs_modulus_pa=72e9,poissons_ratio=0.19,density_kg_m3=2700 -o "
      "bowl.vtu\n"
      "  klang modes --shape box --dims length_m=0.2,width_m=0.02,height_m=0.003 --material steel --support "
      "clamped:x=-0.1");
  return {app,
          [options, band, &common] {
            options->band_is_asked_for = band->count() > 0;
            return run_modes(*options, common);
          },
          {result_kind<modal::ModesDocument>("modes", "the result of `klang modes`")}};
}

}  // namespace klang::apps
