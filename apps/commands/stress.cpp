#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>

#include "apps/kit/body_options.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/fracture/dynamic/strain_history.hpp"
#include "core/physics/fracture/quasistatic/stress_document.hpp"
#include "core/physics/fracture/quasistatic/stress_file.hpp"

namespace klang::apps {
namespace {

struct StressOptions {
  BodyOptions body;
  std::string material = "aluminium";
  std::vector<std::string> forces;
  std::optional<double> tensile_strength_pa;
  std::string literature = "right";
  bool lumped_mass = false;
  std::string output;
  std::string history;
  std::optional<double> gamma1, gamma2, yield_stress_pa, plastic_strain_limit;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"tensile_strength_pa", "Say whether it would break: largest principal stress at least this (Rankine)",
           above(0.0)},
          self.tensile_strength_pa);
    visit({"gamma1", "With --history: D02's threshold of flow, norm of the deviator of the doubled strain",
           at_least(0.0)},
          self.gamma1);
    visit({"gamma2", "With --history: D02's limit of plastic strain, doubled; below 1.2247", at_least(0.0)},
          self.gamma2);
    visit({"yield_stress_pa", "With --history: instead of gamma1, von Mises' yield stress", at_least(0.0)},
          self.yield_stress_pa);
    visit({"plastic_strain_limit", "With --history: instead of gamma2, norm of Green's plastic strain, below 0.6123",
           at_least(0.0)},
          self.plastic_strain_limit);
  }
};

constexpr double kLargestForceN = 1e15;

fracture::PointForce parse_force(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || text.find(':', colon + 1) != std::string::npos)
    throw InputError("--force", "is not PLACE:FORCE", text, "x,y,z:fx,fy,fz in m and N, for example 0,0,0.01:0,0,-20");
  fracture::PointForce force;
  force.place_m = parse_vector("--force", text.substr(0, colon));
  force.force_n = parse_vector("--force", text.substr(colon + 1));
  if (!(force.force_n.norm() <= kLargestForceN))
    throw InputError("--force", "is too large", text, "up to " + to_text(kLargestForceN) + " N");
  return force;
}

void say_triple(const CommonOptions& common, const char* name, const fracture::Triple& v) {
  say(common, "%-28s %.6g, %.6g, %.6g\n", name, v[0], v[1], v[2]);
}

void say_extreme(const CommonOptions& common, const char* name, double stress_pa, const fracture::Triple& place) {
  say(common, "%-28s %.6g Pa at %.6g, %.6g, %.6g m\n", name, stress_pa, place[0], place[1], place[2]);
}

void say_stress(const fracture::StressDocument& d, const CommonOptions& common) {
  say(common, "%d nodes, %d %s elements\n", *d.n_nodes, *d.n_elements, d.element == "p2" ? "quadratic" : "linear");
  say(common, "%-28s %.6g J\n", "strain energy", d.strain_energy_j);
  say_extreme(common, "largest principal stress", d.max_principal_stress_pa, d.place_m);
  if (d.max_is_at_a_load && d.away_from_loads)
    say_extreme(common, "  away from the forces", d.away_from_loads->stress_pa, d.away_from_loads->place_m);
  say_extreme(common, "smallest principal stress", d.min_principal_stress->stress_pa, d.min_principal_stress->place_m);
  say_extreme(common, "largest von Mises stress", d.max_von_mises_stress->stress_pa, d.max_von_mises_stress->place_m);
  say_triple(common, "net force [N]", d.net_force_n);
  say_triple(common, "net moment [N m]", d.net_moment_n_m);
  if (d.acceleration_m_s2) say_triple(common, "acceleration [m/s^2]", *d.acceleration_m_s2);
  if (d.angular_acceleration_rad_s2) say_triple(common, "spin's change [rad/s^2]", *d.angular_acceleration_rad_s2);
  say(common, "%-28s %.3g m\n", "largest displacement", d.max_displacement_m);
  say(common, "%-28s %.2g %% of the energy (estimate)\n", "mesh error", 100.0 * d.energy_share_missing);
  say(common, "%-28s %.1e\n", "residual", d.relative_residual);
  if (d.would_break)
    say(common, "at a strength of %.6g Pa it %s\n", *d.tensile_strength_pa,
        *d.would_break != *d.would_break_away_from_loads ? "would break under the force only, where the mesh decides"
        : *d.would_break                                 ? "WOULD BREAK"
                                                         : "would hold");
}

nlohmann::json used_material(const solid::Material& material) {
  return {{"lame_lambda_pa", material.lame_lambda_pa},
          {"lame_mu_pa", material.lame_mu_pa},
          {"density_kg_m3", material.density_kg_m3}};
}

/// One element through the deformations of a file.
int run_history(const StressOptions& options, const CommonOptions& common) {
  const Stopwatch watch;
  if (!options.forces.empty() || !options.body.shape.empty() || !options.body.mesh_file.empty() ||
      !options.output.empty() || options.tensile_strength_pa)
    throw InputError("--history", "drives one element and takes no body, force, strength or --output", options.history);
  const solid::Material material = parse_material(options.material);
  const fracture::Plasticity plasticity =
      fracture::read_plasticity({options.gamma1, options.gamma2, options.yield_stress_pa, options.plastic_strain_limit},
                                material, {"--gamma1", "--gamma2", "--yield-stress-pa", "--plastic-strain-limit"});
  fracture::HistoryDocument document =
      fracture::strain_history(fracture::read_gradients(options.history), material, plasticity);
  const nlohmann::json used = {
      {"material", used_material(material)}, {"gamma1", plasticity.gamma1}, {"gamma2", plasticity.gamma2}};
  document.header = make_header("history", "done", common, used, {options.history});
  if (plasticity.gamma2 > fracture::kDoubtfulGamma2) {
    document.header.warnings.push_back("gamma2 = " + to_text(plasticity.gamma2) +
                                       ": traceless plastic strain keeps volume to first order only, the rest shape "
                                       "shrinks by about " +
                                       to_text(25.0 * plasticity.gamma2 * plasticity.gamma2) + " % (erratum 68)");
    warn(document.header.warnings.back());
  }
  document.header.wall_time_s = {{"total", watch.seconds()}};
  write_json(common, json_of(document));
  const fracture::HistoryState& last = document.states.back();
  say(common, "%zu states; at the end %.6g J/m3 elastic, %.6g J/m3 dissipated; largest plastic strain %.4g\n",
      document.states.size(), last.elastic_energy_j_m3, last.dissipated_j_m3, document.max_plastic_strain);
  return kDone;
}

int run_stress(const StressOptions& options, const CommonOptions& common) {
  const Stopwatch watch;
  TerminalMonitor monitor(common.quiet);
  validate_fields("command line", options);
  if (!options.history.empty()) return run_history(options, common);
  if (options.forces.empty()) throw InputError("--force", "is required", "", "at least one, or --history");
  if (options.gamma1 || options.gamma2 || options.yield_stress_pa || options.plastic_strain_limit)
    throw InputError("--history", "is missing: only a history flows", "", "a CSV file of deformation gradients");
  const solid::Material material = parse_material(options.material);
  std::vector<fracture::PointForce> forces;
  for (const std::string& text : options.forces) forces.push_back(parse_force(text));
  const bool paper = options.literature == "paper";
  if (paper && options.lumped_mass)
    throw InputError("--lumped-mass", "has no effect with --literature paper, whose projection knows no mass");
  const fracture::Relief relief = paper                 ? fracture::Relief::kEuclidean
                                  : options.lumped_mass ? fracture::Relief::kLumpedMass
                                                        : fracture::Relief::kConsistentMass;

  monitor.progress("mesh", 0.0);
  mesh::BodyNotes notes;
  std::vector<std::string> warnings;
  mesh::TetMesh mesh = options.body.build_and_tell(common, notes, warnings, monitor);
  const double mesh_s = watch.seconds();
  monitor.throw_if_stopped();
  monitor.progress("stiffness", 0.3);
  fracture::FreeBodySolver solver(std::move(mesh), material, relief);
  const double factor_s = watch.seconds();
  monitor.throw_if_stopped();
  monitor.progress("stress", 0.8);
  const fracture::BodyStress stress = fracture::body_stress(solver, material, forces);
  if (!stress.usable()) throw NumericalError("stress: " + stress.message);

  const nlohmann::json used = {{"material", used_material(material)},
                               {"element", options.body.element},
                               {"forces", options.forces},
                               {"literature", options.literature},
                               {"lumped_mass", options.lumped_mass},
                               {"max_edge_m", options.body.max_edge_m},
                               {"refinement", options.body.refinement}};
  fracture::StressDocument document =
      fracture::stress_document(solver, relief, forces, stress, options.tensile_strength_pa);
  std::vector<std::string> judged = stress.warnings;
  judged.insert(judged.end(), document.header.warnings.begin(), document.header.warnings.end());
  document.header = make_header("stress", "solved", common, used, options.body.inputs(options.material));
  document.header.warnings = warnings;
  document.repairs = notes.repairs;
  document.decimation = notes.decimation;
  for (const std::string& warning : judged) {
    document.header.warnings.push_back(warning);
    warn(warning);
  }
  if (!options.output.empty())
    fracture::write_stress_file(options.output, solver.mesh(), stress, json_of(document.header.provenance).dump());
  document.header.wall_time_s = {{"mesh", mesh_s},
                                 {"factor", factor_s - mesh_s},
                                 {"solve", watch.seconds() - factor_s},
                                 {"total", watch.seconds()}};
  write_json(common, json_of(document));
  say_stress(document, common);
  return kDone;
}

}  // namespace

Subcommand add_stress(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<StressOptions>();
  CLI::App* app = program.add_subcommand("stress", "Quasistatic stress of a free body under forces");
  options->body.add_to(*app, common);
  app->add_option("--material", options->material, "As in klang modes")->capture_default_str();
  app->add_option(
      "--force", options->forces,
      "x,y,z:fx,fy,fz in m and N, may be repeated: a force at the nearest point of the surface, at most 1 % of the "
      "body's diagonal away");
  add_fields(*app, common, *options, {{"tensile_strength_pa"}});
  app->add_flag("--lumped-mass", options->lumped_mass, "Balance the load by the diagonal mass matrix");
  app->add_option("--literature", options->literature,
                  "right: inertia relief; paper: the projection as SB prints it (docs/errata.md item 47)")
      ->check(CLI::IsMember({"right", "paper"}))
      ->capture_default_str();
  app->add_option("-o,--output", options->output,
                  "Write displacement, stress and energy density (.vtu, opens in ParaView)");
  app->add_option("--history", options->history,
                  "CSV with columns f11,f12,f13,f21,...,f33: drives one element through these deformation gradients "
                  "instead of a body under forces");
  add_fields(*app, common, *options, {{"gamma1"}, {"gamma2"}, {"yield_stress_pa"}, {"plastic_strain_limit"}});
  app->footer(
      "Examples:\n"
      "  klang stress --shape box --dims length_m=0.2,width_m=0.02,height_m=0.01 --material soda_lime_glass --force "
      "0,0,0.005:0,0,-100 --tensile-strength-pa 45e6\n"
      "  klang stress --mesh bowl.msh --material youngs_modulus_pa=72e9,poissons_ratio=0.19,density_kg_m3=2700 --force "
      "0.06,0,0.04:-200,0,0 --force -0.06,0,0.04:200,0,0 -o bowl-stress.vtu --json s.json\n"
      "  klang stress --history h.csv --material lame_lambda_pa=6e8,lame_mu_pa=4e8,density_kg_m3=1000 --gamma1 0.02 "
      "--gamma2 0.15 --json o.json");
  return {app,
          [options, &common] { return run_stress(*options, common); },
          {result_kind<fracture::StressDocument>("stress", "the result of `klang stress`"),
           result_kind<fracture::HistoryDocument>("history", "the result of `klang stress --history`")}};
}

}  // namespace klang::apps
