#include "tests/fit/coverage.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/modal/damping/rayleigh.hpp"
#include "datasets-synthetic/recipe.hpp"
#include "datasets-synthetic/recipe_spec.hpp"
#include "fit/damping/damping.hpp"
#include "fit/elastic/identifiability.hpp"
#include "fit/elastic/joint_match.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/ringdown/ringdown.hpp"

namespace klang::fit::test {
namespace {

struct Truth {
  const char* name;
  double value;
};

/// Whether each interval of one dataset holds its truth, in the order of truths; relative errors appended.
struct Held {
  std::vector<int> held;
  double youngs_error = 0.0, rayleigh_error = 0.0;
};

std::vector<DecayPoint> decays_of(const std::vector<PartialTable>& tables, const JointMatch& joint) {
  std::vector<DecayPoint> points;
  for (std::size_t s = 0; s < tables.size(); ++s) {
    for (std::size_t i = 0; i < tables[s].partials.size(); ++i) {
      const Partial& p = tables[s].partials[i];
      if (joint.matches[s].line_of_partial[i] >= 0 && p.decay_per_s)
        points.push_back({p.frequency_hz, *p.decay_per_s, p.decay_std_per_s.value_or(0.0)});
    }
  }
  return points;
}

void judge(const std::vector<FitParameter>& parameters, const std::vector<Truth>& truths, Held& result) {
  for (const FitParameter& parameter : parameters) {
    for (std::size_t k = 0; k < truths.size(); ++k) {
      if (parameter.name != truths[k].name) continue;
      result.held[k] =
          parameter.ci95 && (*parameter.ci95)[0] <= truths[k].value && truths[k].value <= (*parameter.ci95)[1];
      const double error = std::abs(parameter.value / truths[k].value - 1.0);
      if (parameter.name == "youngs_modulus_pa") result.youngs_error = error;
      if (parameter.name.starts_with("rayleigh_")) result.rayleigh_error = std::max(result.rayleigh_error, error);
    }
  }
}

}  // namespace

Coverage interval_coverage(const std::string& recipe_toml, int n_seeds, std::uint64_t first_seed, double highest_hz) {
  const datasets::Recipe recipe = datasets::parse_recipe(recipe_toml, "recipe", {});
  FitProblem problem;
  problem.material =
      solid::from_youngs_modulus(1.04 * recipe.material.youngs_modulus_pa(), 0.31, recipe.material.density_kg_m3);
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa"};
  for (const auto& specimen : recipe.specimens) {
    problem.specimens.emplace_back();
    problem.specimens.back().name = specimen.name;
    problem.specimens.back().shape = specimen.shape;
  }
  const ParameterSpace space(problem);
  SpectrumModels models(problem.specimens.size());
  for_each_job(models.size(), [&](std::size_t s) {
    const SpecimenBody body = make_body(problem.specimens[s], problem.material, highest_hz);
    ReducedSpectrumOptions options;
    options.band = {20.0, highest_hz};
    models[s] = std::make_shared<ReducedSpectrum>(problem.specimens[s], body, space.free_dimensions(s), options);
  });
  const std::vector<Truth> truths = {{"youngs_modulus_pa", recipe.material.youngs_modulus_pa()},
                                     {"lame_lambda_pa", recipe.material.lame_lambda_pa},
                                     {"lame_mu_pa", recipe.material.lame_mu_pa},
                                     {"rayleigh_stiffness_s", recipe.damping_parameters[0]},
                                     {"rayleigh_mass_per_s", recipe.damping_parameters[1]}};
  std::vector<Held> each(static_cast<std::size_t>(n_seeds), Held{std::vector<int>(truths.size(), 0)});
  for_each_job(each.size(), [&](std::size_t i) {
    const auto dataset = datasets::make_dataset_from_text(recipe_toml, "recipe", first_seed + i);
    std::vector<PartialTable> tables;
    for (const auto& recording : dataset.recordings) tables.push_back(identify_ringdown(recording.signal, {}).partials);
    const JointMatch joint = match_and_fit(space, models, tables, {});
    judge(elastic_report(space, joint.fit, joint.regularisation, problem).parameters, truths, each[i]);
    std::vector<std::string> warnings;
    for (const auto& candidate : fit_damping(decays_of(tables, joint), warnings).candidates) {
      if (candidate.law == &damping::rayleigh_law()) judge(candidate.parameters, truths, each[i]);
    }
  });
  Coverage coverage;
  coverage.n_sounds = n_seeds;
  for (std::size_t k = 0; k < truths.size(); ++k) {
    coverage.held.emplace_back(truths[k].name, 0);
    for (const Held& one : each) coverage.held.back().second += one.held[k];
  }
  for (const Held& one : each) {
    coverage.worst_youngs_error = std::max(coverage.worst_youngs_error, one.youngs_error);
    coverage.worst_rayleigh_error = std::max(coverage.worst_rayleigh_error, one.rayleigh_error);
  }
  return coverage;
}

}  // namespace klang::fit::test
