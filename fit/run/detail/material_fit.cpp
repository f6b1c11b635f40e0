#include "fit/run/detail/material_fit.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/solid/support_doubt.hpp"

namespace klang::fit::detail {
namespace {

// Modes are wanted this far above the highest partial: a guess 30 % too soft in stiffness lies 20 % low in frequency.
constexpr double kModeMargin = 1.25;
constexpr double kRelinearise = 0.025;  // step of a dimension after which its meshes are made anew
constexpr int kMaxRounds = 3;

SpecimenModel specimen_model(const FitProblem& problem, const ParameterSpace& space, std::size_t index,
                             const SpecimenData& data, const FitOptions& options) {
  const Specimen& specimen = problem.specimens[index];
  const double highest = kModeMargin * data.highest_partial_hz();
  SpecimenModel model;
  model.body = make_body(specimen, problem.material, highest);
  ReducedSpectrumOptions reduced;
  reduced.band = {problem.band.low_hz, highest};
  reduced.count = options.n_modes;
  reduced.vary_ratio = space.elastic_is_free();
  reduced.watch_given = true;
  model.spectrum =
      std::make_shared<ReducedSpectrum>(specimen, model.body, space.free_dimensions(index), reduced, silent_monitor());
  return model;
}

/// A specimen without partials takes no part: an empty model would have no modes.
SpectrumModels spectra_of(const std::vector<SpecimenModel>& specimens) {
  std::shared_ptr<const SpectrumModel> any;
  for (const SpecimenModel& model : specimens)
    any = any ? any : std::static_pointer_cast<const SpectrumModel>(model.spectrum);
  SpectrumModels spectra;
  for (const SpecimenModel& model : specimens) spectra.push_back(model.spectrum ? model.spectrum : any);
  return spectra;
}

/// The problem with its material and dimensions at x.
FitProblem at_solution(const FitProblem& problem, const ParameterSpace& space, const Eigen::VectorXd& x) {
  FitProblem moved = problem;
  moved.material.lame_lambda_pa = space.quantity("lame_lambda_pa", x).value;
  moved.material.lame_mu_pa = space.quantity("lame_mu_pa", x).value;
  moved.material.density_kg_m3 = space.quantity("density_kg_m3", x).value;
  for (std::size_t s = 0; s < problem.specimens.size(); ++s) {
    const auto local = space.local(s, x);
    const auto& names = space.free_dimensions(s);
    for (std::size_t d = 0; d < names.size(); ++d) {
      moved.specimens[s].shape->dims[names[d]] = local.point.dimensions[d];
    }
  }
  return moved;
}

JointMatchOptions match_options(const FitProblem& problem, const FitOptions& options) {
  JointMatchOptions match;
  match.gate_cents = options.gate_cents;
  match.elastic.model_std = options.model_std_cents * kLogPerCent;
  match.elastic.robust = options.robust;
  match.elastic.priors = problem.priors;
  return match;
}

/// What errors of given dimensions, masses and density pull, in columns of ElasticFit::systematic: each tolerance moves the
/// frequencies of its specimen together, so that no scatter shows it.
void add_tolerances(MaterialFit& fit, const std::vector<PartialTable>& tables) {
  ElasticFit& elastic = fit.joint.fit;
  const auto data = elastic_data(tables, fit.joint.lines, fit.joint.matches);
  const auto n = static_cast<Eigen::Index>(data.size());
  if (elastic.derivative.rows() != n || fit.space->size() == 0) return;
  Eigen::VectorXd weight(n), density = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i)
    weight[i] = elastic.weight[i] / (std::pow(item(data, i).sigma, 2) + elastic.scatter * elastic.scatter);
  const auto add = [&](const Eigen::VectorXd& shift) {  // of ln f by one standard deviation
    elastic.systematic.conservativeResize(Eigen::NoChange, elastic.systematic.cols() + 1);
    elastic.systematic.rightCols(1) = elastic.derivative.transpose() * weight.cwiseProduct(shift);
  };
  for (std::size_t s = 0; s < fit.specimens.size(); ++s) {
    const Specimen& specimen = fit.start.specimens[s];
    if (!fit.specimens[s].spectrum || specimen.tolerance.empty()) continue;
    const std::vector<std::string> names = fit.spectra[s]->given_dimensions();
    const Eigen::MatrixXd slopes = fit.spectra[s]->given_slopes(fit.space->local(s, elastic.x).point);
    for (const auto& [name, std] : specimen.tolerance) {
      const auto at = std::find(names.begin(), names.end(), name) - names.begin();
      const bool dimension = at < static_cast<std::ptrdiff_t>(names.size());
      const double given =
          dimension ? specimen.shape->dims.at(name) : specimen.mass_kg.value_or(fit.start.material.density_kg_m3);
      Eigen::VectorXd shift = Eigen::VectorXd::Zero(n);
      for (Eigen::Index i = 0; i < n; ++i) {
        const ElasticDatum& datum = item(data, i);
        if (static_cast<std::size_t>(datum.specimen) != s) continue;
        for (const int mode : datum.modes)
          shift[i] += (dimension ? slopes(mode, at) : -0.5) * std / given / static_cast<double>(datum.modes.size());
      }
      if (name == "density_kg_m3") {
        density += shift;
      } else {
        add(shift);
      }
    }
  }
  if (density.squaredNorm() > 0.0) add(density);
}

/// Supports that cut through their body, bodies of a size that points to another unit.
void add_body_doubts(MaterialFit& fit) {
  constexpr double kLongest = 5.0, kShortest = 1e-3;  // metres
  for (std::size_t s = 0; s < fit.specimens.size(); ++s) {
    const Specimen& specimen = fit.start.specimens[s];
    if (!fit.specimens[s].spectrum) continue;
    const mesh::TetMesh& mesh = fit.specimens[s].body.mesh;
    if (const std::string doubt = solid::support_doubt(specimen.support, mesh); !doubt.empty())
      fit.reasons.push_back(
          {ReasonKind::kSupport, Verdict::kDoubtful, specimen.name, specimen.support.where, doubt, {}, {}, {}});
    const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).maxCoeff();
    if (size_m <= kLongest && size_m >= kShortest) continue;
    fit.reasons.push_back({ReasonKind::kUnits, Verdict::kDoubtful, specimen.name,
                           specimen.mesh_file ? "unit_m" : "shape",
                           "the body is " + to_text(size_m) + " m long: " +
                               (specimen.mesh_file ? "unit_m = 0.001 beside mesh, if the file is in millimetres?"
                                                   : "are its dimensions in metres?"),
                           size_m, kShortest, kLongest});
  }
}

/// Partials of a specimen that took no part in the fit, on the modes that the fit predicts.
void match_prediction(std::size_t specimen, const PartialTable& table, const FitOptions& options, MaterialFit& fit) {
  constexpr double kToleranceCents = 10.0;  // scale of an honest prediction's errors; heavy tails beyond
  fit.joint.lines[specimen] = lines_at(*fit.space, fit.spectra, fit.joint.fit.x, 3.0)[specimen];
  fit.joint.matches[specimen] =
      match_partials(table, fit.joint.lines[specimen], 0.0, {kToleranceCents, options.gate_cents, 40.0});
}

}  // namespace

FitProblem MaterialFit::fitted() const { return at_solution(start, *space, joint.fit.x); }

std::vector<int> MaterialFit::ranks_at_solution(std::size_t specimen) const {
  const Eigen::VectorXd frequency_hz = model_frequencies(*space, spectra, specimen, joint.fit.x);
  std::vector<int> order(static_cast<std::size_t>(frequency_hz.size())), rank(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return frequency_hz[a] < frequency_hz[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) item(rank, order[k]) = static_cast<int>(k);
  return rank;
}

int MaterialFit::n_modes_matched(std::size_t specimen) const {
  const std::vector<int> rank = ranks_at_solution(specimen);
  int n = 0;
  for (const int line : joint.matches[specimen].line_of_partial) {
    if (line < 0) continue;
    for (const int mode : item(joint.lines[specimen], line).modes) n = std::max(n, item(rank, mode) + 1);
  }
  return n;
}

MaterialFit fit_material(const FitProblem& problem, const MeasuredData& data, const FitOptions& options,
                         Monitor& monitor) {
  const std::size_t n = problem.specimens.size();
  MaterialFit fit;
  fit.start = problem;
  fit.specimens.resize(n);
  std::vector<PartialTable> tables;
  for (std::size_t s = 0; s < n; ++s)
    tables.push_back(problem.specimens[s].predict ? PartialTable{} : data.specimens[s].partials);
  JointMatchOptions match = match_options(problem, options);
  Stopwatch watch;
  for (int round = 0; round < kMaxRounds; ++round) {
    fit.space.emplace(fit.start);
    for_each_job(
        n,
        [&](std::size_t s) {
          if (data.specimens[s].partials.partials.empty()) return;
          fit.specimens[s] = specimen_model(fit.start, *fit.space, s, data.specimens[s], options);
        },
        "models", monitor);
    fit.models_wall_time_s += watch.lap();
    fit.spectra = spectra_of(fit.specimens);
    fit.joint = match_and_fit(*fit.space, fit.spectra, tables, match, monitor);
    fit.match_wall_time_s += watch.lap();
    if (fit.joint.n_matched == 0 || fit.space->largest_dimension_step(fit.joint.fit.x) <= kRelinearise) break;
    fit.start = fit.fitted();
    match.search = false;
  }
  if (fit.joint.n_matched == 0) return fit;
  add_body_doubts(fit);
  add_tolerances(fit, tables);
  for (std::size_t s = 0; s < n; ++s) {
    if (problem.specimens[s].predict && fit.specimens[s].spectrum)
      match_prediction(s, data.specimens[s].partials, options, fit);
  }
  return fit;
}

ElasticReport material_report(const FitProblem& problem, const MaterialFit& fit) {
  ElasticReport report = elastic_report(*fit.space, fit.joint.fit, fit.joint.regularisation, fit.start);
  const ParameterSpace asked(problem);
  for (FitParameter& parameter : report.parameters)
    parameter.start_value = asked.quantity(parameter.name, asked.start()).value;
  return report;
}

}  // namespace klang::fit::detail
