#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>

#include "apps/commands/transfer_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/device_option.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_table.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/transfer/radiate.hpp"
#include "core/sound/transfer/radiate_progress.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::apps {
namespace {

using acoustics::BemOptions;
using acoustics::BemResult;
using Complex = std::complex<double>;

struct TransferOptions {
  std::string model, output, sphere, surface, velocity_csv, points_csv;
  double radius_m = 0.1;
  double ka = 0.0;
  int elements = 2000;
  double frequency_hz = 0.0;
  double unit_m = 1.0;
  acoustics::RadiateOptions radiate;
  DeviceOption device;
};

nlohmann::json options_json(const TransferOptions& options) {
  nlohmann::json json{{"density_kg_m3", options.radiate.medium.density_kg_m3},
                      {"sound_speed_m_s", options.radiate.medium.sound_speed_m_s},
                      {"allow_coarse", options.radiate.allow_coarse}};
  if (options.radiate.device.used)
    json.update({{"device", *options.device.device}, {"precision", options.device.precision}});
  return json;
}

BemOptions bem_options(const TransferOptions& options) {
  BemOptions bem;
  bem.medium = options.radiate.medium;
  bem.allow_coarse = options.radiate.allow_coarse;
  bem.device = options.radiate.device;
  return bem;
}

SolutionRecord solution_of(const BemResult& bem) {
  return {bem.frequency_hz, bem.n_elements, bem.n_unknowns, bem.relative_residual, bem.elements_per_wavelength,
          bem.device};
}

void warn_device(const std::string& message) {
  if (!message.empty()) warn(message);
}

void warn_coarse(const BemResult& bem, const BemOptions& options) {
  if (bem.elements_per_wavelength < options.min_elements_per_wavelength)
    warn("only " + to_text(bem.elements_per_wavelength) + " elements per wavelength: the result is not to be trusted");
}

int run_sphere(const TransferOptions& options, const CommonOptions& common) {
  const auto pattern = enum_from_text<acoustics::SpherePattern>(options.sphere);
  if (!pattern)
    throw InputError("--sphere", "is no pattern", options.sphere, "pulsating, dipole, quadrupole, octupole");
  checked("command line", "--ka", options.ka, 1e-3, 100.0);
  if (options.elements < 20 || options.elements > 40000)
    throw InputError("command line", "--elements", std::to_string(options.elements), "20 to 40000");
  const acoustics::SphereCase sphere{static_cast<int>(*pattern), options.radius_m, options.ka,
                                     acoustics::sphere_divisions(options.elements)};
  const BemOptions bem = bem_options(options);
  TerminalMonitor monitor(common.quiet);
  const acoustics::SphereResult result = acoustics::solve_sphere(sphere, bem, monitor);
  if (!result.bem.usable()) throw NumericalError("transfer: " + result.bem.message);
  warn_coarse(result.bem, bem);
  warn_device(result.bem.device_message);

  nlohmann::json used = options_json(options);
  used.update(
      {{"sphere", options.sphere}, {"radius_m", options.radius_m}, {"ka", options.ka}, {"elements", options.elements}});
  SphereTransferDocument document;
  document.header = make_header("transfer-sphere", "done", common, used, {});
  document.solution = solution_of(result.bem);
  document.surface_pressure_relative_error = result.surface_pressure_relative_error;
  document.element_size_m = result.element_size_m;
  document.radiated_power_w = acoustics::radiated_power_w(result.multipole, options.radiate.medium);
  document.exact_radiated_power_w = acoustics::sphere_radiated_power_w(sphere, options.radiate.medium);
  const Complex exact = acoustics::sphere_coefficient_pa(sphere, options.radiate.medium);
  document.exact_multipole = {sphere.degree, 0, exact.real(), exact.imag()};
  for (int n = 0; n <= result.multipole.order; ++n)
    for (int m = -n; m <= n; ++m) {
      const Complex value = result.multipole.coefficients_pa[n * (n + 1) + m];
      document.multipoles.push_back({n, m, value.real(), value.imag()});
    }
  write_json(common, json_of(document));
  say(common, "%s sphere, ka %g: %d elements, surface pressure within %.3g %% of the exact one\n",
      options.sphere.c_str(), options.ka, result.bem.n_elements, 100.0 * result.surface_pressure_relative_error);
  return kDone;
}

Eigen::VectorXcd read_velocity(const TransferOptions& options, const mesh::SurfaceMesh& surface) {
  const Eigen::MatrixXd table = read_number_table(options.velocity_csv, 2, "re,im");
  if (table.rows() != surface.triangles.rows() && table.rows() != surface.vertices_m.rows())
    throw InputError(options.velocity_csv, "has the wrong number of rows", std::to_string(table.rows()),
                     std::to_string(surface.triangles.rows()) + " (triangles) or " +
                         std::to_string(surface.vertices_m.rows()) + " (vertices) of " + options.surface);
  Eigen::VectorXcd velocity(table.rows());
  for (Eigen::Index i = 0; i < table.rows(); ++i) velocity[i] = Complex(table(i, 0), table(i, 1));
  return velocity;
}

int run_surface(const TransferOptions& options, const CommonOptions& common) {
  checked("command line", "--frequency-hz", options.frequency_hz, 1e-3, 1e7);
  checked_open("command line", "--unit-m", options.unit_m, 0.0, 1e6);
  const BemOptions bem = bem_options(options);
  bem.validate();
  mesh::SurfaceMesh surface = mesh::read_surface(options.surface);
  surface.vertices_m *= options.unit_m;
  mesh::check_closed_surface(surface, options.surface);
  const acoustics::OuterSurface outer = acoustics::outer_surface(surface);
  const Eigen::VectorXcd velocity = acoustics::corner_values(surface, outer, read_velocity(options, surface));
  const Eigen::Matrix3Xd points = read_number_table(options.points_csv, 3, "x_m,y_m,z_m").transpose();
  acoustics::RadiatingSurface radiating = acoustics::radiating_surface(outer.mesh);
  acoustics::check_resolution(radiating, options.frequency_hz, bem);

  TerminalMonitor monitor(common.quiet);
  const acoustics::HelmholtzBem solver(std::move(radiating));
  solver.check_outside(points);
  const BemResult result = solver.solve(options.frequency_hz, velocity, bem, monitor);
  if (!result.usable()) throw NumericalError("transfer: " + result.message);
  warn_coarse(result, bem);
  warn_device(result.device_message);
  const Eigen::VectorXcd pressure = solver.pressure_at(result, points);

  nlohmann::json used = options_json(options);
  used.update({{"frequency_hz", options.frequency_hz}, {"unit_m", options.unit_m}});
  SurfaceTransferDocument document;
  document.header = make_header("transfer-surface", "done", common, used,
                                {options.surface, options.velocity_csv, options.points_csv});
  document.solution = solution_of(result);
  document.radiated_power_w = result.radiated_power_w[0];
  for (const Complex& p : pressure) document.pressure.push_back({p.real(), p.imag()});
  write_json(common, json_of(document));
  say(common, "%s: %d elements at %g Hz, pressure at %td points\n", options.surface.c_str(), result.n_elements,
      options.frequency_hz, points.cols());
  return kDone;
}

int run_model(const TransferOptions& options, const CommonOptions& common) {
  if (options.output.empty()) throw InputError("-o", "is missing", "", "a file for the transfer model (.vtu)");
  if (std::filesystem::path(options.output).extension() != ".vtu")
    throw InputError("-o", "is no .vtu", options.output, "a name that ends in .vtu");
  options.radiate.validate();
  const modal::ModalModel model = modal::read_modal_model(options.model);
  nlohmann::json used = options_json(options);
  used.update({{"elements_per_wavelength", options.radiate.elements_per_wavelength},
               {"max_elements", options.radiate.max_elements},
               {"kept_power_fraction", options.radiate.order.kept_power_fraction},
               {"paper_rule", options.radiate.order.paper_rule}});
  // Of a stopped run: the modes it had finished, beside the output, good for the same model and options only.
  const std::filesystem::path partial = options.output + ".partial.vtu";
  const std::string key =
      nlohmann::json({{"model_sha256", input_file(options.model).sha256}, {"options", used}, {"version", version()}})
          .dump();
  acoustics::RadiateProgress progress(partial, key, options.radiate.medium);
  if (progress.unreadable()) warn(partial.string() + " cannot be read: starting afresh");
  const std::vector<acoustics::ModeTransfer> known = progress.modes();
  if (!known.empty())
    say(common, "going on after %zu of %td modes (%s)\n", known.size(), model.n_modes(), partial.c_str());
  TerminalMonitor monitor(common.quiet);
  const acoustics::RadiateResult result = acoustics::radiate(
      model, options.radiate, monitor, known, [&](const acoustics::ModeTransfer& mode) { progress.add(mode); });
  if (!result.usable()) {
    progress.remove();  // it would fail again at the same mode: only a stopped run goes on
    throw NumericalError(result.message);
  }

  warn_device(result.device_message);
  TransferDocument document;
  document.device = result.device;
  document.header = make_header("transfer", "done", common, used, {options.model});
  acoustics::write_transfer_model(options.output, result.transfer, json_of(document.header.provenance).dump());
  int highest = 0;
  for (const acoustics::ModeTransfer& mode : result.transfer.modes) {
    highest = std::max(highest, mode.multipole.order);
    document.modes.push_back({mode.mode, mode.frequency_hz, mode.multipole.order, mode.radiated_power_w,
                              mode.decay_radiation_per_s, mode.kept_power_fraction, mode.n_bem_elements,
                              mode.residual});
  }
  write_json(common, json_of(document));
  progress.remove();
  say(common, "%s: %zu modes, multipoles to order %d\n", options.output.c_str(), result.transfer.modes.size(), highest);
  return kDone;
}

int run_transfer(const TransferOptions& given, const CommonOptions& common) {
  TransferOptions options = given;
  options.radiate.device = given.device.choice();
  const int forms =
      (options.model.empty() ? 0 : 1) + (options.sphere.empty() ? 0 : 1) + (options.surface.empty() ? 0 : 1);
  if (forms != 1)
    throw InputError("transfer", "needs one of a modal model, --sphere and --surface",
                     std::to_string(forms) + " given");
  if (!options.sphere.empty()) return run_sphere(options, common);
  if (options.surface.empty()) return run_model(options, common);
  if (options.velocity_csv.empty() || options.points_csv.empty())
    throw InputError("--surface", "needs --velocity-csv, --frequency-hz and --points");
  return run_surface(options, common);
}

}  // namespace

Subcommand add_transfer(CLI::App& program, CommonOptions& common) {
  auto options = std::make_shared<TransferOptions>();
  CLI::App* app = program.add_subcommand("transfer", "How each mode sounds outside: boundary elements and multipoles");
  app->add_option("model", options->model, "Modal model (.vtu) from klang modes -o or klang fit");
  app->add_option("-o,--output", options->output, "Transfer model (.vtu), for klang synth --transfer");
  app->add_option("--sphere", options->sphere, "A sphere instead: pulsating, dipole, quadrupole or octupole, 1 m/s");
  app->add_option("--radius-m", options->radius_m, "Radius of the sphere")->capture_default_str();
  app->add_option("--ka", options->ka, "Wavenumber times radius of the sphere");
  app->add_option("--elements", options->elements, "Elements of the sphere, at least")->capture_default_str();
  app->add_option("--surface", options->surface, "A closed surface instead (.stl, .obj, .ply, .off)");
  app->add_option("--velocity-csv", options->velocity_csv,
                  "Its outward normal velocity [m/s]: re,im for each triangle or each vertex, in the surface's order");
  app->add_option("--frequency-hz", options->frequency_hz, "Frequency of that velocity");
  app->add_option("--points", options->points_csv, "Where to find the pressure: x_m,y_m,z_m per line");
  app->add_option("--unit-m", options->unit_m, "Length of the surface file's unit")->capture_default_str();
  add_fields(*app, common, options->radiate,
             {{"medium.density_kg_m3"},
              {"medium.sound_speed_m_s"},
              {"elements_per_wavelength", {}, "Modal model: boundary elements per wavelength of sound"},
              {"max_elements", {}, "Modal model: boundary elements at most"},
              {"order.kept_power_fraction", "--kept-power",
               "Modal model: part of the radiated power that the multipoles keep"},
              {"order.paper_rule", "--paper-order", "Modal model: order max(kL/4, 4) instead (loses power)"},
              {"allow_coarse"}});
  add_device_option(*app, common, options->device, "The matrices are made and solved");
  name_field(*app, common, "radius_m", "--radius-m");
  app->footer(
      "Examples:\n"
      "  klang transfer bowl.vtu -o bowl-transfer.vtu --json bowl-transfer.json\n"
      "  klang transfer --sphere dipole --radius-m 0.1 --ka 5 --json s.json\n"
      "  klang transfer --surface body.stl --velocity-csv vn.csv --frequency-hz 1000 --points pts.csv --json p.json\n"
      "A run that was stopped goes on where it stopped when it is started again with the same options.");
  return {app,
          [options, &common] { return run_transfer(*options, common); },
          {result_kind<TransferDocument>("transfer", "the result of `klang transfer MODEL`"),
           result_kind<SphereTransferDocument>("transfer-sphere", "the result of `klang transfer --sphere`"),
           result_kind<SurfaceTransferDocument>("transfer-surface", "the result of `klang transfer --surface`")}};
}

}  // namespace klang::apps
