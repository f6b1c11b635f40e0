#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/stopwatch.hpp"
#include "fit/run/detail/final_modes.hpp"
#include "fit/run/detail/fitted_sound.hpp"
#include "fit/run/detail/judge_input.hpp"
#include "fit/run/detail/material_fit.hpp"
#include "fit/run/detail/measured_data.hpp"
#include "fit/run/detail/mode_damping.hpp"
#include "fit/run/detail/mode_matches.hpp"
#include "fit/run/fit.hpp"

namespace klang::fit {
namespace {

std::vector<SpecimenResult> measured_specimens(const FitProblem& problem, const detail::MeasuredData& data) {
  std::vector<SpecimenResult> specimens;
  for (std::size_t s = 0; s < problem.specimens.size(); ++s) {
    SpecimenResult& specimen = specimens.emplace_back();
    specimen.name = problem.specimens[s].name;
    specimen.predicted = problem.specimens[s].predict;
    if (!data.specimens[s].ringdowns.empty()) specimen.ringdown = data.specimens[s].ringdowns.front();
    if (!data.specimens[s].signals.empty()) specimen.recorded = data.specimens[s].signals.front();
    specimen.partials = data.specimens[s].partials;
  }
  return specimens;
}

void add_material(const FitProblem& problem, const detail::MaterialFit& fit, FitResult& result) {
  ElasticReport report = detail::material_report(problem, fit);
  result.material = fit.fitted().material;
  result.material->name.clear();
  result.material->source = "fitted";
  result.parameters = std::move(report.parameters);
  result.correlation = std::move(report.correlation);
  result.budget = std::move(report.budget);
  result.cost_initial = fit.joint.fit.cost_initial;
  result.cost_final = fit.joint.fit.cost_final;
  result.n_iterations = fit.joint.fit.n_iterations;
}

void add_final_modes(std::vector<std::optional<detail::FinalModes>> modes, FitResult& result) {
  for (std::size_t s = 0; s < modes.size(); ++s) {
    if (!modes[s]) continue;
    SpecimenResult& specimen = result.specimens[s];
    specimen.model = std::move(modes[s]->model);
    specimen.none_missing = modes[s]->none_missing;
    specimen.predicted_frequency_hz = std::move(modes[s]->frequency_hz);
    specimen.mesh_relative_error = std::move(modes[s]->mesh_relative_error);
  }
}

/// The matches, and how far each specimen's are off.
void add_matches(const detail::ModeMatches& matches, FitResult& result) {
  result.matches = matches.matches;
  for (std::size_t s = 0; s < result.specimens.size(); ++s) {
    SpecimenResult& specimen = result.specimens[s];
    const std::vector<int>& modes = matches.mode_of_partial[s];
    for (std::size_t i = 0; i < modes.size(); ++i) {
      if (modes[i] < 0) specimen.unmatched_partials.push_back(static_cast<int>(i));
    }
    double sum = 0.0, n_matched = 0.0;
    for (const PartialMatch& match : matches.matches) {
      if (match.specimen != static_cast<int>(s)) continue;
      sum += match.deviation_cents * match.deviation_cents;
      n_matched += 1.0;
      specimen.max_deviation_cents = std::max(specimen.max_deviation_cents, std::abs(match.deviation_cents));
    }
    if (n_matched > 0.0) specimen.rms_deviation_cents = std::sqrt(sum / n_matched);
  }
}

void add_damping(detail::ModeDamping damping, FitResult& result) {
  result.damping = std::move(damping.damping);
  const auto first_derived =
      std::find_if(result.parameters.begin(), result.parameters.end(), [](const FitParameter& p) { return p.derived; });
  for (const FitParameter& parameter : damping.law_parameters) {
    if (!parameter.std) continue;
    BudgetEntry& entry = result.budget.emplace_back();
    entry.parameter = parameter.name;
    entry.source = "decays";
    entry.contribution_std = parameter.std;
    entry.share = 1.0;
  }
  result.parameters.insert(first_derived, damping.law_parameters.begin(), damping.law_parameters.end());
  for (std::size_t s = 0; s < result.specimens.size(); ++s)
    result.specimens[s].predicted_decay_per_s = std::move(damping.predicted_decay_per_s[s]);
}

void add_warnings(const std::vector<std::string>& warnings, FitResult& result) {
  result.warnings.insert(result.warnings.end(), warnings.begin(), warnings.end());
}

/// The verdict beside each number that is given as known.
void add_verdict(FitResult& result) {
  for (FitParameter& parameter : result.parameters) {
    if (parameter.identifiable || parameter.ci95) parameter.verdict = result.judgement.verdict;
  }
}

void conclude(const JointMatch& joint, std::size_t n_partials, FitResult& result) {
  result.status = joint.fit.converged && joint.settled ? FitStatus::kConverged : FitStatus::kNotConverged;
  char text[160];
  std::snprintf(text, sizeof text, "%d of %zu partials matched; model scatter %.2g cents (estimated, in the intervals)",
                joint.n_matched, n_partials, joint.fit.scatter / detail::kLogPerCent);
  result.message = text;
}

}  // namespace

void FitOptions::validate() const { validate_fields("fit options", *this); }

FitResult run_fit(const FitProblem& problem, const FitOptions& options, Monitor& monitor) {
  options.validate();
  FitResult result;
  Stopwatch watch;
  const detail::MeasuredData data = detail::read_measured_data(problem, monitor);
  result.specimens = measured_specimens(problem, data);
  add_warnings(data.warnings, result);
  result.wall_time_s["partials"] = watch.lap();
  if (data.n_fitted_partials == 0) {
    result.status = FitStatus::kNoPartials;
    result.message = "no partial stands above the noise";
    for (const auto& warning : result.warnings) result.message += "; " + warning;
    return result;
  }

  const detail::MaterialFit fit = detail::fit_material(problem, data, options, monitor);
  result.wall_time_s["models"] = fit.models_wall_time_s;
  result.wall_time_s["match"] = fit.match_wall_time_s;
  if (fit.joint.n_matched == 0) {
    result.status = FitStatus::kNoMatch;
    result.message = "no partial lies near a mode of the model: check dimensions, material and support";
    return result;
  }
  add_material(problem, fit, result);
  for (std::size_t s = 0; s < fit.specimens.size(); ++s) {
    for (const std::string& note : fit.specimens[s].body.notes)
      result.warnings.push_back(problem.specimens[s].name + ": " + note);
  }

  watch.lap();
  add_final_modes(detail::solve_final_modes(fit, data, monitor), result);
  result.wall_time_s["final_modes"] = watch.lap();

  detail::ModeMatches matches = detail::match_modes(fit, result.specimens);
  add_warnings(matches.warnings, result);

  detail::ModeDamping damping = detail::fit_mode_damping(problem, result.specimens, matches, monitor);
  add_warnings(damping.warnings, result);
  add_matches(matches, result);
  if (problem.radiation_damping) result.wall_time_s["radiation"] = damping.radiation_wall_time_s;
  watch.lap();
  add_damping(std::move(damping), result);

  for (std::size_t s = 0; s < result.specimens.size(); ++s)
    result.specimens[s].fitted =
        detail::fitted_sound(data.specimens[s], result.specimens[s], matches.mode_of_partial[s]);
  result.wall_time_s["sound"] = watch.lap();
  conclude(fit.joint, data.n_fitted_partials, result);
  result.judgement = judge_fit(detail::judge_input(problem, fit, data, matches, options, result));
  add_verdict(result);
  return result;
}

}  // namespace klang::fit
