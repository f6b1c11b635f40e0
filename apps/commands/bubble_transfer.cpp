#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/commands/bubble_transfer_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/device_option.hpp"
#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "apps/kit/number_table.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/dual_domain/tank_modes.hpp"
#include "core/sound/dual_domain/transfer_series.hpp"

namespace klang::apps {
namespace {

using Complex = std::complex<double>;
using bubble::DualDomainOptions;

struct TransferOptions {
  std::string boundary, bubble, path, points, output;
  double unit_m = 1.0;
  std::optional<double> frame_step_s;
  std::optional<double> given_radius_m, decay_per_s;
  bubble::BoundaryOptions surface;
  DeviceOption device;
  opencl::DeviceChoice where;            ///< what it means here
  bubble::TransferSeriesOptions series;  ///< of one boundary, too, as far as they concern it
};

/// What follows from the options, and all of them checked.
void finish(TransferOptions& o, std::uint64_t seed) {
  const bool paper = o.series.solver.literature == bubble::Literature::kPaper;
  const auto theory = paper ? bubble::BubbleTheory::kPaper : bubble::BubbleTheory::kLeighton;
  o.series.seed = seed;
  if (o.given_radius_m) {
    o.series.radius_m =
        checked("command line", "--radius-m", *o.given_radius_m, bubble::kSmallestRadiusM, bubble::kLargestRadiusM);
  } else {
    checked("command line", "--frequency-hz", o.series.frequency_hz, 1.0, 1e5);
    o.series.radius_m = bubble::bubble_radius_m(o.series.frequency_hz, {}, theory);
  }
  o.where = o.device.choice();
  if (paper && o.device.device)
    throw InputError("command line", "--device", *o.device.device,
                     "no --literature paper: it has nothing for a device");
  o.series.decay_per_s = o.decay_per_s.value_or(0.0);
  o.series.validate();
  o.surface.validate();
}

nlohmann::json options_json(const TransferOptions& o) {
  const DualDomainOptions& solver = o.series.solver;
  return {{"frequency_hz", o.series.frequency_hz},
          {"radius_m", o.series.radius_m},
          {"fluid_sources", o.series.fluid_sources},
          {"air_sources", o.series.air_sources},
          {"expand_m", o.surface.expand_m},
          {"unit_m", o.unit_m},
          {"ridge", solver.ridge},
          {"literature", to_text(solver.literature)},
          {"solver", to_text(solver.solver)},
          {"fluid_functions", to_text(solver.fluid_space)},
          {"images", solver.images},
          {"method", to_text(o.series.method)},
          {"liquid_loss_factor", solver.liquid_loss_factor},
          {"wall_admittance", solver.wall_admittance},
          {"air_vertices", o.series.air_vertices},
          {"scaled_columns", solver.scale_columns},
          {"liquid_density_kg_m3", solver.liquid.density_kg_m3},
          {"liquid_sound_speed_m_s", solver.liquid.sound_speed_m_s},
          {"air_density_kg_m3", solver.air.density_kg_m3},
          {"air_sound_speed_m_s", solver.air.sound_speed_m_s}};
}

/// Resonances of the vessel near the bubble's pitch, where |P| is what the loss makes it.
std::vector<TankModeRecord> named_modes(const bubble::LiquidBoundary& boundary,
                                        const bubble::TransferSeriesOptions& o) {
  constexpr double kBand = 1.12;  // a sixth of an octave to both sides
  constexpr std::size_t kMostNamed = 6;
  std::vector<TankModeRecord> records;
  std::string text;
  for (const bubble::TankMode& mode :
       bubble::tank_modes(boundary, o.solver.liquid.sound_speed_m_s, o.frequency_hz / kBand, o.frequency_hz * kBand)) {
    if (records.size() < kMostNamed)
      text += (text.empty() ? "" : ", ") + std::to_string(std::lround(mode.frequency_hz)) + " Hz (" +
              std::to_string(mode.m) + "," + std::to_string(mode.n) + "," + std::to_string(mode.p) + ")";
    records.push_back({mode.frequency_hz, mode.m, mode.n, mode.p});
  }
  if (!records.empty())
    warn("the liquid, taken as a box between rigid walls, resonates near " + to_text(o.frequency_hz) + " Hz: " + text +
         "; the pressure there is what --liquid-loss-factor " + to_text(o.solver.liquid_loss_factor) +
         " and --wall-admittance " + to_text(o.solver.wall_admittance) +
         " make it, and the fit of waves holds a resonance down, by more than error_estimate says");
  return records;
}

int run_series(const TransferOptions& options, const CommonOptions& common) {
  if (std::filesystem::path(options.output).extension() != ".csv")
    throw InputError("command line", "-o", options.output, "a .csv file for the transfer over time");
  const bubble::BoundaryFrames frames = bubble::find_frames(options.boundary, options.frame_step_s.value_or(0.0));
  bubble::BubblePath path;
  if (options.path.empty()) {
    path.time_s = {frames.time_s.front(), frames.time_s.back() + 1.0};
    path.position_m.assign(2, parse_vector("--bubble", options.bubble));
  } else {
    const Eigen::MatrixXd table = read_number_table(options.path, 4, "time_s,x_m,y_m,z_m");
    for (Eigen::Index i = 0; i < table.rows(); ++i) {
      path.time_s.push_back(table(i, 0));
      path.position_m.push_back(table.row(i).tail<3>().transpose());
    }
  }
  const Eigen::MatrixXd points = read_number_table(options.points, 3, "x_m,y_m,z_m");
  if (points.rows() != 1)
    throw InputError(options.points, "a series needs one listener", std::to_string(points.rows()) + " points", "1");
  bubble::TransferSeriesOptions series = options.series;
  if (!options.decay_per_s) series.decay_per_s = bubble::bubble_oscillation(series.radius_m).decay_per_s;
  TerminalMonitor monitor(common.quiet);
  const bubble::TransferSeriesResult result = bubble::transfer_series(
      frames.time_s,
      [&](std::size_t i) {
        return bubble::LiquidBoundary(bubble::read_boundary(frames.files[i], options.unit_m), options.surface);
      },
      path, points.row(0).transpose(), series, monitor);
  if (result.status != bubble::TransferSeriesResult::Status::kDone)
    throw NumericalError("bubble transfer: " + result.message);
  write_file(options.output, bubble::transfer_series_csv(result, series.frequency_hz));

  std::vector<std::filesystem::path> inputs = {options.points};
  if (!options.path.empty()) inputs.emplace_back(options.path);
  inputs.insert(inputs.end(), frames.files.begin(), frames.files.end());
  BubbleTransferSeriesDocument document;
  document.header = make_header("bubble_transfer_series", "done", common, options_json(options), inputs);
  document.tank_modes = named_modes(
      bubble::LiquidBoundary(bubble::read_boundary(frames.files[0], options.unit_m), options.surface), series);
  if (result.n_fluid_sources < series.fluid_sources || result.n_air_sources < series.air_sources)
    warn("the coarsest frame carries " + std::to_string(result.n_fluid_sources) + " fluid and " +
         std::to_string(result.n_air_sources) + " air sources");
  document.error_estimate = result.error_estimate;
  document.method = to_text(series.method);
  document.n_frames = static_cast<int>(frames.files.size());
  document.n_solves = static_cast<int>(result.n_solves);
  document.fluid_sources_used = static_cast<int>(result.n_fluid_sources);
  document.air_sources_used = static_cast<int>(result.n_air_sources);
  document.n_replaced_sources = static_cast<int>(result.n_replaced_sources);
  document.decay_per_s = series.decay_per_s;
  for (const bubble::TransferAtTime& step : result.steps)
    document.transfer.push_back({step.time_s, step.pressure.real(), step.pressure.imag(), step.fit_error_fluid,
                                 step.fit_error_air, step.frozen});
  write_json(common, json_of(document));
  say(common, "%s: %zu times from %d solves of %zu frames\n", options.output.c_str(), result.steps.size(),
      result.n_solves, frames.files.size());
  return kDone;
}

/// A bubble in one boundary and where it is heard.
struct OneBubble {
  const bubble::BoundaryMesh& mesh;
  const bubble::LiquidBoundary& boundary;
  bubble::SwingingBubble bubble;
  const Eigen::MatrixXd& points;
  std::vector<Eigen::Vector3d> ears() const {
    std::vector<Eigen::Vector3d> list;
    for (Eigen::Index i = 0; i < points.rows(); ++i) list.emplace_back(points.row(i).transpose());
    return list;
  }
};

/// The header with the pressures at the listeners and their errors, the largest of which is the result's.
BubbleTransferDocument with_pressures(const TransferOptions& options, const CommonOptions& common,
                                      const std::vector<Complex>& pressures,
                                      const std::vector<bubble::ReciprocalTransfer>& references) {
  BubbleTransferDocument document;
  document.header =
      make_header("bubble_transfer", "done", common, options_json(options), {options.boundary, options.points});
  document.method = to_text(options.series.method);
  if (!references.empty()) document.error_estimate = 0.0;
  for (std::size_t i = 0; i < pressures.size(); ++i) {
    document.pressure.push_back({{pressures[i].real(), pressures[i].imag()}, {}, {}});
    if (references.empty()) continue;
    const double error = bubble::error_estimate(pressures[i], references[i]);
    document.pressure.back().error_estimate = error;
    document.error_estimate = std::max(*document.error_estimate, error);
  }
  return document;
}

BubbleTransferDocument reciprocal(const TransferOptions& options, const CommonOptions& common, const OneBubble& one) {
  if (!options.output.empty())
    throw InputError("command line", "-o", options.output,
                     "no file: the reciprocal method does not find the bubble's motion of the surface");
  if (options.series.solver.literature == bubble::Literature::kPaper)
    throw InputError("command line", "--literature", "paper", "right, with --method reciprocal");
  TerminalMonitor monitor(common.quiet);
  const Stopwatch total;
  const bubble::SourcePoints sources =
      bubble::random_source_points(one.boundary, options.series.fluid_sources, 1, common.seed);
  const bubble::ReciprocalOptions solve{options.series.solver, options.series.air_vertices, true, options.where};
  const std::vector<Eigen::Vector3d> ears = one.ears();
  const bubble::EarField air = bubble::ear_field(one.boundary, options.series.frequency_hz, ears, solve, monitor);
  const bubble::EarInLiquid liquid = bubble::ear_in_liquid(one.boundary, air, sources, solve, monitor);
  const std::vector<bubble::ReciprocalTransfer> found =
      bubble::checked_transfer(one.boundary, air, liquid, sources, one.bubble, solve);
  if (!air.device_message.empty()) warn(air.device_message);
  std::vector<Complex> pressures;
  for (const bubble::ReciprocalTransfer& f : found) pressures.push_back(f.pressure);
  BubbleTransferDocument document = with_pressures(options, common, pressures, found);
  for (std::size_t i = 0; i < found.size(); ++i)
    document.pressure[i].uncorrected = PressureRecord{found[i].plain.real(), found[i].plain.imag()};
  document.fit_error_fluid = *std::max_element(liquid.fit_error.begin(), liquid.fit_error.end());
  document.n_elements = air.n_elements;
  document.elements_per_wavelength = air.elements_per_wavelength;
  document.header.wall_time_s = {{"air", air.wall_time_s}, {"total", total.seconds()}};
  say(common, "%zu samples, %d elements, %g Hz: error estimate %.3g %%, %.2f s\n", one.boundary.samples().size(),
      air.n_elements, options.series.frequency_hz, 100.0 * document.error_estimate.value_or(0.0), total.seconds());
  return document;
}

BubbleTransferDocument forward(const TransferOptions& options, const CommonOptions& common, const OneBubble& one) {
  TerminalMonitor monitor(common.quiet);
  DualDomainOptions solve = options.series.solver;
  solve.wall_slopes = !options.output.empty();
  const bubble::SourcePoints sources =
      bubble::random_source_points(one.boundary, options.series.fluid_sources, options.series.air_sources, common.seed);
  const bubble::DualDomainResult result =
      bubble::solve_dual_domain(one.boundary, options.series.frequency_hz, sources, {one.bubble}, solve, monitor)[0];
  if (!result.usable()) throw NumericalError("bubble transfer: " + result.message);
  if (result.n_fluid_sources < options.series.fluid_sources || result.n_air_sources < options.series.air_sources)
    warn("the surface has only " + std::to_string(one.boundary.samples().size()) +
         " samples: " + std::to_string(result.n_fluid_sources) + " fluid and " + std::to_string(result.n_air_sources) +
         " air sources are used");
  if (!options.output.empty())
    bubble::write_boundary_solution(options.output, one.mesh, one.boundary, result,
                                    options.series.solver.liquid.density_kg_m3);
  const std::vector<Eigen::Vector3d> ears = one.ears();
  std::vector<Complex> pressures;
  for (const Eigen::Vector3d& ear : ears) pressures.push_back(bubble::air_pressure(result, ear));
  std::vector<bubble::ReciprocalTransfer> references;
  if (solve.literature == bubble::Literature::kCorrected) {
    const bubble::ReciprocalOptions check{options.series.solver, options.series.air_vertices, true, options.where};
    references = bubble::reciprocal_transfer(one.boundary, options.series.frequency_hz, sources, {{one.bubble}, ears},
                                             check, monitor)[0];
    if (!references[0].device_message.empty()) warn(references[0].device_message);
  }
  BubbleTransferDocument document = with_pressures(options, common, pressures, references);
  document.source_strength_kg_m_s2 = result.source_strength.real();
  document.fit_error_fluid = result.fit_error_fluid;
  document.fit_error_air = result.fit_error_air;
  document.alpha_m = result.alpha_m;
  const auto counts = [](auto fluid, auto air) { return DomainCounts{static_cast<int>(fluid), static_cast<int>(air)}; };
  document.n_sources = counts(result.n_fluid_sources, result.n_air_sources);
  document.n_unknowns = counts(result.n_fluid_unknowns, result.n_air_unknowns);
  document.n_steps = counts(result.n_fluid_steps, result.n_air_steps);
  document.n_images = static_cast<int>(result.fluid.images.size());
  document.header.wall_time_s = result.wall_time_s;
  const std::string error = document.error_estimate
                                ? ", error estimate " + to_text(std::round(1e3 * *document.error_estimate) / 10) + " %"
                                : "";
  say(common, "%zu samples, %g Hz: fit errors %.3g %% (liquid), %.3g %% (air)%s, %.2f s\n",
      one.boundary.samples().size(), options.series.frequency_hz, 100.0 * result.fit_error_fluid,
      100.0 * result.fit_error_air, error.c_str(), result.wall_time_s.at("total"));
  return document;
}

int run_one(const TransferOptions& options, const CommonOptions& common) {
  if (!options.output.empty() && std::filesystem::path(options.output).extension() != ".vtp")
    throw InputError("-o", "is no .vtp", options.output, "a name that ends in .vtp");
  const Eigen::Vector3d at = parse_vector("--bubble", options.bubble);
  const Eigen::MatrixXd points = read_number_table(options.points, 3, "x_m,y_m,z_m");
  const bubble::BoundaryMesh mesh = bubble::read_boundary(options.boundary, options.unit_m);
  const bubble::LiquidBoundary boundary(mesh, options.surface);
  boundary.check_bubble(at, 0.1 * options.series.radius_m);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    if (boundary.inside_air_boundary(points.row(i).transpose()))
      throw InputError(options.points, "point " + std::to_string(i) + " lies inside the liquid",
                       to_text(points(i, 0)) + "," + to_text(points(i, 1)) + "," + to_text(points(i, 2)),
                       "points in the air");
  std::vector<TankModeRecord> modes = named_modes(boundary, options.series);
  BubbleTransferDocument document =
      options.series.method == bubble::TransferMethod::kForward
          ? forward(options, common, {mesh, boundary, {at, options.series.radius_m}, points})
          : reciprocal(options, common, {mesh, boundary, {at, options.series.radius_m}, points});
  document.n_samples = static_cast<int>(boundary.samples().size());
  document.volume_m3 = boundary.volume_m3();
  document.radius_m = options.series.radius_m;
  document.tank_modes = std::move(modes);
  write_json(common, json_of(document));
  return kDone;
}

int run_bubble_transfer(TransferOptions options, const CommonOptions& common) {
  finish(options, common.seed);
  const bool series = bubble::is_series(options.boundary);
  if (options.bubble.empty() == (options.path.empty() || !series))
    throw InputError(
        "command line",
        series ? "a series needs one of --bubble and --path" : "--bubble is needed, and --path is for a series",
        options.bubble.empty() ? "no --bubble" : "both");
  if (series && options.device.device)
    throw InputError("command line", "--device", *options.device.device,
                     "one boundary: a series runs on the processor");
  if (!series && options.frame_step_s)
    throw InputError("command line", "--frame-step-s", to_text(*options.frame_step_s),
                     "a series, drop_####.vtp: one boundary has no steps");
  return series ? run_series(options, common) : run_one(options, common);
}

}  // namespace

Subcommand add_bubble_transfer(CLI::App& group, CommonOptions& common) {
  auto options = std::make_shared<TransferOptions>();
  CLI::App* app = group.add_subcommand("transfer", "How a bubble in a body of liquid sounds in the air around it");
  app->add_option("--boundary", options->boundary,
                  "Closed surface of the liquid (.vtp, .vtu, .obj) with regions: 0 free surface, 1 rigid wall, 2 solid "
                  "in the liquid, "
                  "3 its dry part. A series: drop_####.vtp, or a .pvd")
      ->required();
  app->add_option("--bubble", options->bubble, "Position x,y,z [m]");
  app->add_option("--path", options->path, "Series: positions over time (CSV time_s,x_m,y_m,z_m)");
  add_fields(*app, common, options->series, {{"frequency_hz"}});
  app->get_option("--frequency-hz")->default_str("")->required();
  app->add_option("--radius-m", options->given_radius_m, "Its radius; default: the one that rings at this frequency");
  app->add_option("--points", options->points, "Where to find the pressure: x_m,y_m,z_m per line (CSV)")->required();
  app->add_option("-o,--output", options->output,
                  "Surface with the solution (.vtp); series: transfer over time (.csv) for klang bubble synth");
  add_fields(*app, common, options->series, {{"fluid_sources"}, {"air_sources"}});
  add_fields(*app, common, options->surface, {{"expand_m"}});
  app->add_option("--unit-m", options->unit_m, "Length of the surface file's unit")->capture_default_str();
  app->add_option("--frame-step-s", options->frame_step_s, "Series drop_####.vtp: time between frames");
  app->add_option(
      "--decay-per-s", options->decay_per_s,
      "Series: decay of the bubble, for growing steps and the end at 1/1000; default from the radius, 0: every frame");
  add_fields(*app, common, options->series,
             {{"solver.literature"},
              {"solver.fluid_space", "--fluid-functions"},
              {"method"},
              {"solver.liquid_loss_factor", "--liquid-loss-factor"},
              {"solver.wall_admittance", "--wall-admittance"},
              {"air_vertices"},
              {"solver.solver"},
              {"solver.ridge"},
              {"solver.wall_length_m"},
              {"solver.images", "!--no-images", "Pass 1 without images of the bubble in surfaces close to it"},
              {"solver.scale_columns", "!--no-scaling", "Ridge on functions that are not scaled to length 1"},
              {"solver.liquid.density_kg_m3", "--liquid-density-kg-m3", "Density of the liquid"},
              {"solver.liquid.sound_speed_m_s", "--liquid-sound-speed-m-s", "Sound speed of the liquid"},
              {"solver.air.density_kg_m3", "--air-density-kg-m3", "Density of the air"},
              {"solver.air.sound_speed_m_s", "--air-sound-speed-m-s", "Sound speed of the air"}});
  add_device_option(*app, common, options->device, "The boundary elements of the air are made and solved");
  for (const auto& [field, flag] :
       {std::pair{"radius_m", "--radius-m"}, {"decay_per_s", "--decay-per-s"}, {"boundary", "--boundary"}})
    name_field(*app, common, field, flag);
  app->footer(
      "Pressure in Pa for a bubble wall that swings by 1 m (unit amplitude).\n"
      "Examples:\n"
      "  klang bubble transfer --boundary tank.vtp --bubble 0.1,0.1,-0.03 --frequency-hz 1500 --points ears.csv --json "
      "t.json -o v.vtp\n"
      "  klang bubble transfer --boundary drop_####.vtp --frame-step-s 0.002 --path bubble.csv --frequency-hz 2000 "
      "--points ear.csv -o z.csv\n"
      "As printed in HF: --literature paper --fluid-functions sources --no-images --no-scaling --solver direct");
  return {app,
          [options, &common] { return run_bubble_transfer(*options, common); },
          {result_kind<BubbleTransferDocument>("bubble_transfer", "the result of `klang bubble transfer`"),
           result_kind<BubbleTransferSeriesDocument>("bubble_transfer_series",
                                                     "the result of `klang bubble transfer` with a series")}};
}

}  // namespace klang::apps
