#include "fit/run/detail/judge_input.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "fit/elastic/match_evidence.hpp"

namespace klang::fit::detail {
namespace {

constexpr double kLeftOutCents = 60.0;

JudgedSpecimen judged_specimen(const FitProblem& problem, const MaterialFit& fit, const MeasuredData& data,
                               const ModeMatches& matches, const FitResult& result, std::size_t s) {
  const SpecimenResult& specimen = result.specimens[s];
  JudgedSpecimen judged;
  judged.name = specimen.name;
  judged.partials = specimen.partials;
  judged.mode_of_partial = matches.mode_of_partial[s];
  judged.frequency_hz = Eigen::Map<const Eigen::VectorXd>(
      specimen.predicted_frequency_hz.data(), static_cast<Eigen::Index>(specimen.predicted_frequency_hz.size()));
  const std::vector<int> rank = fit.ranks_at_solution(s);
  const Eigen::VectorXd visibility = fit.spectra[s]->visibility();
  judged.visibility.resize(visibility.size());
  for (Eigen::Index k = 0; k < visibility.size(); ++k) judged.visibility[item(rank, k)] = visibility[k];
  if (problem.specimens[s].mass_kg) judged.density_kg_m3 = specimen.model.material.density_kg_m3;
  judged.n_takes = data.specimens[s].n_takes;
  judged.take_scatter_cents = data.specimens[s].take_scatter_cents;
  judged.take_share = data.specimens[s].take_share;
  return judged;
}

/// A residual that the judge looks at: a datum of the fit, or a ring that was left out.
struct Row {
  std::size_t specimen = 0;
  std::vector<int> modes;
  double log_frequency = 0.0, sigma = 0.0;
};

std::vector<Row> rows_of(const MaterialFit& fit, const FitResult& result, const std::vector<PartialTable>& tables) {
  std::vector<Row> rows;
  const JointMatch& joint = fit.joint;
  for (const ElasticDatum& datum : elastic_data(tables, joint.lines, joint.matches))
    rows.push_back({static_cast<std::size_t>(datum.specimen), datum.modes, datum.log_frequency, datum.sigma});
  for (std::size_t s = 0; s < tables.size(); ++s) {
    if (result.specimens[s].predicted) continue;
    const auto& line_of_partial = joint.matches[s].line_of_partial;
    for (std::size_t i = 0; i < tables[s].partials.size(); ++i) {
      if (line_of_partial[i] >= 0) continue;
      const Partial& partial = tables[s].partials[i];
      const ModelLine* nearest = nullptr;
      for (std::size_t k = 0; k < joint.lines[s].size(); ++k) {
        const ModelLine& line = joint.lines[s][k];
        const double off = std::abs(cents(partial.frequency_hz, line.frequency_hz));
        const bool taken = std::count(line_of_partial.begin(), line_of_partial.end(), static_cast<int>(k)) > 0;
        if (taken || line.visibility < 0.1 || off > kLeftOutCents) continue;
        if (!nearest || off < std::abs(cents(partial.frequency_hz, nearest->frequency_hz))) nearest = &line;
      }
      if (nearest)
        rows.push_back({s, nearest->modes, std::log(partial.frequency_hz),
                        partial.frequency_std_hz.value_or(0.0) / partial.frequency_hz});
    }
  }
  return rows;
}

/// Elastic constants that were given and not asked for, and how they move lambda and mu [Pa].
struct GivenConstant {
  const char* name = "";
  GivenKind kind = GivenKind::kModulus;
  double value = 0.0, d_lambda = 0.0, d_mu = 0.0;  ///< by ln value, by Poisson's ratio itself
};

/// Beside the constant that was asked for its usual partner (ParameterSpace), both where none was.
std::vector<GivenConstant> given_constants(const ParameterSpace& space, const SpectrumPoint& point) {
  const double lambda = point.lame_lambda_pa, mu = point.lame_mu_pa;
  const double poisson = lambda / (2.0 * (lambda + mu)), young = 2.0 * mu * (1.0 + poisson);
  const double a = 1.0 + poisson, b = 1.0 - 2.0 * poisson;
  const std::string& free = space.single_elastic();
  std::vector<GivenConstant> constants;
  if (free == "lame_mu_pa" && lambda > 0.0)
    constants.push_back({"lame_lambda_pa", GivenKind::kModulus, lambda, lambda, 0.0});
  if (free == "lame_lambda_pa") constants.push_back({"lame_mu_pa", GivenKind::kModulus, mu, 0.0, mu});
  if (free == "poissons_ratio" || !space.elastic_is_free())
    constants.push_back({"youngs_modulus_pa", GivenKind::kModulus, young, lambda, mu});
  if (free == "youngs_modulus_pa" || !space.elastic_is_free())
    constants.push_back({"poissons_ratio", GivenKind::kPoissonsRatio, poisson,
                         young * (1.0 + 2.0 * poisson * poisson) / (a * a * b * b), -young / (2.0 * a * a)});
  return constants;
}

/// A specimen's modes at the solution and what moves them.
struct Slopes {
  Eigen::VectorXd log_frequency, mesh_error;
  Eigen::MatrixXd by_x, by_dimension, by_constant;
};

Slopes slopes_of(const MaterialFit& fit, std::size_t s) {
  const ParameterSpace::Local local = fit.space->local(s, fit.joint.fit.x);
  const Spectrum spectrum = fit.spectra[s]->spectrum(local.point);
  const std::vector<GivenConstant> constants = given_constants(*fit.space, local.point);
  Eigen::MatrixXd by_constant(spectrum.derivative.rows(), static_cast<Eigen::Index>(constants.size()));
  for (Eigen::Index k = 0; k < by_constant.cols(); ++k) {
    const GivenConstant& constant = item(constants, k);
    by_constant.col(k) =
        0.5 * (spectrum.derivative.col(0) * constant.d_lambda + spectrum.derivative.col(1) * constant.d_mu);
  }
  return {0.5 * spectrum.log_angular_frequency_sq.array() - std::log(2.0 * kPi), fit.spectra[s]->relative_error(),
          0.5 * spectrum.derivative * local.derivative, fit.spectra[s]->given_slopes(local.point), by_constant};
}

std::string ring_words(const MaterialFit& fit, const Row& row, bool several) {
  const std::vector<int> rank = fit.ranks_at_solution(row.specimen);
  char text[96];
  std::snprintf(text, sizeof text, "mode %d (%.6g Hz)", item(rank, row.modes.front()), std::exp(row.log_frequency));
  return (several ? fit.start.specimens[row.specimen].name + "'s " : std::string()) + text;
}

JudgedResiduals judged_residuals(const MaterialFit& fit, const FitResult& result,
                                 const std::vector<PartialTable>& tables) {
  const std::vector<Row> rows = rows_of(fit, result, tables);
  const auto n = static_cast<Eigen::Index>(rows.size());
  JudgedResiduals residuals;
  residuals.coordinates = fit.space->coordinate_names();
  if (fit.space->single_elastic() == "lame_mu_pa") residuals.coordinates.front() = "youngs_modulus_pa";
  residuals.guess_std = guess_std(*fit.space);
  residuals.residual.resize(n);
  residuals.sigma.resize(n);
  residuals.derivative = Eigen::MatrixXd::Zero(n, fit.space->size());
  const auto constants = given_constants(*fit.space, fit.space->local(0, fit.joint.fit.x).point);
  for (const GivenConstant& constant : constants)
    residuals.given.push_back({"", constant.name, constant.value, Eigen::VectorXd::Zero(n), constant.kind});
  for (std::size_t s = 0; s < tables.size(); ++s) {
    if (!fit.specimens[s].spectrum || result.specimens[s].predicted) continue;
    const Slopes slopes = slopes_of(fit, s);
    const std::size_t first = residuals.given.size();
    const auto& specimen = fit.start.specimens[s];
    for (const std::string& name : fit.spectra[s]->given_dimensions()) {
      const double value = specimen.shape->dims.at(name);
      const auto tolerance = specimen.tolerance.find(name);
      residuals.given.push_back({result.specimens[s].name, name, value, Eigen::VectorXd::Zero(n), GivenKind::kDimension,
                                 tolerance == specimen.tolerance.end() ? 0.0 : tolerance->second / value});
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      const Row& row = item(rows, i);
      if (row.specimen != s) continue;
      const double share = 1.0 / static_cast<double>(row.modes.size());
      residuals.residual[i] = row.log_frequency;
      double mesh_error = 0.0;
      for (const int mode : row.modes) {
        residuals.residual[i] -= share * item(slopes.log_frequency, mode);
        residuals.derivative.row(i) += share * slopes.by_x.row(mode);
        if (mode < slopes.mesh_error.size()) mesh_error = std::max(mesh_error, slopes.mesh_error[mode]);
        for (std::size_t d = first; d < residuals.given.size(); ++d)
          residuals.given[d].slope[i] += share * slopes.by_dimension(mode, static_cast<Eigen::Index>(d - first));
        for (std::size_t k = 0; k < constants.size(); ++k)
          residuals.given[k].slope[i] += share * slopes.by_constant(mode, static_cast<Eigen::Index>(k));
      }
      residuals.sigma[i] = std::hypot(row.sigma, mesh_error);
    }
  }
  for (const Row& row : rows) residuals.rings.push_back(ring_words(fit, row, tables.size() > 1));
  return residuals;
}

/// Coordinates that the data, not the assumption of staying near the guess, hold.
int n_determined(const MaterialFit& fit) {
  int n = 0;
  for (Eigen::Index j = 0; j < fit.space->size(); ++j)
    n += fit.space->regularisation_std()[j] == 0.0 || fit.joint.regularisation[j] == 0.0;
  return n;
}

}  // namespace

JudgeInput judge_input(const FitProblem& problem, const MaterialFit& fit, const MeasuredData& data,
                       const ModeMatches& matches, const FitOptions& options, const FitResult& result) {
  JudgeInput input;
  input.start = problem.material;
  input.found = *result.material;
  input.parameters = result.parameters;
  std::vector<PartialTable> tables;
  for (std::size_t s = 0; s < result.specimens.size(); ++s) {
    const bool takes_part = fit.specimens[s].spectrum && !result.specimens[s].predicted;
    tables.push_back(takes_part ? result.specimens[s].partials : PartialTable{});
    if (takes_part) input.specimens.push_back(judged_specimen(problem, fit, data, matches, result, s));
  }
  input.residuals = judged_residuals(fit, result, tables);
  const Eigen::VectorXd& residual = fit.joint.fit.residual;
  input.n_data = static_cast<int>(residual.size());
  input.n_free = n_determined(fit);
  input.scatter_cents = fit.joint.fit.scatter / kLogPerCent;
  const int left = std::max(1, input.n_data - input.n_free);
  input.rms_cents = std::sqrt(residual.squaredNorm() / left) / kLogPerCent;
  input.model_std_cents = options.model_std_cents;
  input.rival = fit.joint.rival;
  input.given = fit.reasons;
  return input;
}

}  // namespace klang::fit::detail
