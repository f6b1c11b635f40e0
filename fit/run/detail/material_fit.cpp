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

/// The numbers of a specimen that are given and not fitted, with d ln f / d ln of each for its modes (mass and density: -1/2).
std::vector<std::pair<std::string, Eigen::VectorXd>> given_slopes(const MaterialFit& fit, std::size_t s) {
  const Specimen& specimen = fit.start.specimens[s];
  const SpectrumModel& model = *fit.spectra[s];
  std::vector<std::pair<std::string, Eigen::VectorXd>> given;
  const std::vector<std::string> names = model.given_dimensions();
  const Eigen::MatrixXd slopes = model.given_slopes(fit.space->local(s, fit.joint.fit.x).point);
  for (std::size_t d = 0; d < names.size(); ++d) given.emplace_back(names[d], slopes.col(static_cast<Eigen::Index>(d)));
  const Eigen::VectorXd by_mass = Eigen::VectorXd::Constant(model.n_modes(), -0.5);
  // A mesh larger by a factor rings lower by it; with its mass given it is lighter, too.
  if (specimen.mesh_file)
    given.emplace_back("size", Eigen::VectorXd::Constant(model.n_modes(), specimen.mass_kg ? 0.5 : -1.0));
  if (specimen.mass_kg) {
    given.emplace_back("mass_kg", by_mass);
  } else if (!fit.space->density_is_free()) {
    given.emplace_back("density_kg_m3", by_mass);
  }
  return given;
}

double given_value(const MaterialFit& fit, const Specimen& specimen, const std::string& name) {
  if (name == "mass_kg") return specimen.mass_kg.value_or(0.0);
  return name == "density_kg_m3" ? fit.start.material.density_kg_m3 : specimen.shape->dims.at(name);
}

/// What errors of given dimensions, masses and density pull: ElasticFit::given, and for those with a tolerance a column of
/// ElasticFit::systematic. Each moves the frequencies of its specimen together, so that no scatter shows it.
void add_tolerances(MaterialFit& fit, const std::vector<PartialTable>& tables) {
  ElasticFit& elastic = fit.joint.fit;
  const auto data = elastic_data(tables, fit.joint.lines, fit.joint.matches);
  const auto n = static_cast<Eigen::Index>(data.size());
  if (elastic.derivative.rows() != n || fit.space->size() == 0) return;
  Eigen::VectorXd weight(n);
  for (Eigen::Index i = 0; i < n; ++i)
    weight[i] = elastic.weight[i] / (std::pow(item(data, i).sigma, 2) + elastic.scatter * elastic.scatter);
  GivenQuantity density{"density_kg_m3", Eigen::VectorXd::Zero(fit.space->size()), {}};
  bool has_density = false;
  for (std::size_t s = 0; s < fit.specimens.size(); ++s) {
    const Specimen& specimen = fit.start.specimens[s];
    if (!fit.specimens[s].spectrum || specimen.predict) continue;
    for (const auto& [name, slopes] : given_slopes(fit, s)) {
      Eigen::VectorXd shift = Eigen::VectorXd::Zero(n);  // of ln f as ln of the given rises by 1
      for (Eigen::Index i = 0; i < n; ++i) {
        const ElasticDatum& datum = item(data, i);
        if (static_cast<std::size_t>(datum.specimen) != s) continue;
        for (const int mode : datum.modes) shift[i] += slopes[mode] / static_cast<double>(datum.modes.size());
      }
      GivenQuantity given{specimen.name + "." + name, elastic.derivative.transpose() * weight.cwiseProduct(shift), {}};
      const auto tolerance = specimen.tolerance.find(name);
      if (tolerance != specimen.tolerance.end())
        given.relative_std = tolerance->second / given_value(fit, specimen, name);
      if (name != density.name) {
        elastic.given.push_back(std::move(given));
        continue;
      }
      density.pull += given.pull;  // one error for all specimens
      if (given.relative_std) density.relative_std = given.relative_std;
      has_density = true;
    }
  }
  if (has_density) elastic.given.push_back(std::move(density));
  for (const GivenQuantity& given : elastic.given) {
    if (!given.relative_std) continue;
    elastic.systematic.conservativeResize(Eigen::NoChange, elastic.systematic.cols() + 1);
    elastic.systematic.rightCols(1) = *given.relative_std * given.pull;
  }
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
