// Whether stated intervals hold the truth as often as they say, from sounds of tubes that a Ritz series made.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.hpp"
#include "datasets-synthetic/recipe.hpp"
#include "fit/damping.hpp"
#include "fit/identifiability.hpp"
#include "fit/joint_match.hpp"
#include "fit/reduced_spectrum.hpp"
#include "fit/ringdown.hpp"

namespace klang::fit {
namespace {

constexpr int kSeeds = 100;
// Half a second: with longer sounds the noise falls below 1e-7 of frequency, where the series that makes the truth ends.
const char* const kRecipe = R"(
name = "two chimes"
[material]
youngs_modulus_pa = 68.9e9
poissons_ratio = 0.33
density_kg_m3 = 2700.0
[damping]
model = "rayleigh"
rayleigh_stiffness_s = 1e-7
rayleigh_mass_per_s = 1.5
[sound]
sample_rate_hz = 32000
duration_s = 0.5
peak = 0.5
highest_hz = 9000
[noise]
snr_db = 40
[fit]
parameters = ["lame_lambda_pa", "lame_mu_pa"]
[[specimen]]
name = "D5"
shape = { kind = "tube", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }
strike = [{ time_s = 0.1, at = [1.0, 0.0, 0.93], impulse_n_s = [-0.02, 0.0, 0.0], contact_s = 2e-5 }]
pickup = [{ at = [0.7071067811865476, 0.7071067811865476, -0.97], direction = [1.0, 1.0, 0.0] }]
[[specimen]]
name = "D6"
shape = { kind = "tube", length_m = 0.353, outer_radius_m = 0.0125, wall_m = 0.001 }
strike = [{ time_s = 0.1, at = [1.0, 0.0, 0.93], impulse_n_s = [-0.02, 0.0, 0.0], contact_s = 2e-5 }]
pickup = [{ at = [0.7071067811865476, 0.7071067811865476, -0.97], direction = [1.0, 1.0, 0.0] }]
)";

TEST(Coverage, NinetyFivePercentIntervalsOfChimesHoldTheTruthInNinetyToNinetyNineOfAHundredSounds) {
  FitProblem problem;
  problem.material = solid::from_youngs_modulus(1.04 * 68.9e9, 0.31, 2700.0);
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa"};
  for (const auto& [name, length_m] : {std::pair{"D5", 0.505}, std::pair{"D6", 0.353}}) {
    Specimen specimen;
    specimen.name = name;
    specimen.shape = mesh::ShapeSpec{"tube", {{"length_m", length_m}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
    problem.specimens.push_back(specimen);
  }
  const ParameterSpace space(problem);
  SpectrumModels models(2);
  for_each_job(2, [&](std::size_t s) {
    const SpecimenBody body = make_body(problem.specimens[s], problem.material, 11000.0);
    ReducedSpectrumOptions options;
    options.band = {20.0, 11000.0};
    models[s] = std::make_shared<ReducedSpectrum>(problem.specimens[s], body, space.free_dimensions(s), options);
  });
  const std::vector<std::pair<const char*, double>> truth = {
      {"youngs_modulus_pa", 68.9e9}, {"lame_lambda_pa", 50280849181.77798}, {"lame_mu_pa", 25902255639.097744}};
  std::vector<std::vector<int>> held(kSeeds, std::vector<int>(truth.size() + 2, 0));
  for_each_job(kSeeds, [&](std::size_t seed) {
    const auto dataset = datasets::make_dataset_from_text(kRecipe, "two chimes", 1000 + seed);
    std::vector<PartialTable> tables;
    for (const auto& recording : dataset.recordings) tables.push_back(identify_ringdown(recording.signal, {}).partials);
    const JointMatch joint = match_and_fit(space, models, tables, {});
    const ElasticReport report = elastic_report(space, joint.fit, joint.leash, problem);
    for (const FitParameter& parameter : report.parameters) {
      for (std::size_t k = 0; k < truth.size(); ++k) {
        if (parameter.name == truth[k].first && parameter.ci95)
          held[seed][k] = (*parameter.ci95)[0] <= truth[k].second && truth[k].second <= (*parameter.ci95)[1];
      }
    }
    std::vector<DecayPoint> points;
    for (std::size_t s = 0; s < tables.size(); ++s) {
      for (std::size_t i = 0; i < tables[s].partials.size(); ++i) {
        const Partial& p = tables[s].partials[i];
        if (joint.matches[s].line_of_partial[i] >= 0 && p.decay_per_s)
          points.push_back({p.frequency_hz, *p.decay_per_s, p.decay_std_per_s.value_or(0.0)});
      }
    }
    std::vector<std::string> warnings;
    const DampingResult damping = fit_damping(points, warnings);
    for (const auto& candidate : damping.candidates) {
      if (candidate.kind != DampingKind::kRayleigh) continue;
      for (const auto& parameter : candidate.parameters) {
        const double value = parameter.name == "rayleigh_stiffness_s" ? 1e-7 : 1.5;
        if (parameter.ci95)
          held[seed][truth.size() + (parameter.name == "rayleigh_stiffness_s" ? 0 : 1)] =
              (*parameter.ci95)[0] <= value && value <= (*parameter.ci95)[1];
      }
    }
  });
  const std::vector<const char*> names = {"E", "lambda", "mu", "rayleigh_stiffness_s", "rayleigh_mass_per_s"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    int n_held = 0;
    for (const auto& seed : held) n_held += seed[k];
    RecordProperty(names[k], n_held);
    EXPECT_GE(n_held, 90) << names[k];
    EXPECT_LE(n_held, 99) << names[k];
  }
}

}  // namespace
}  // namespace klang::fit
