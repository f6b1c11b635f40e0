#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/fracture/dynamic/strain_history.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

solid::Material clay() {
  solid::Material material;
  material.lame_lambda_pa = 6e8;
  material.lame_mu_pa = 4e8;
  material.density_kg_m3 = 1000.0;
  return material;
}

/// What half a turn of a shear of 0.08 dissipates, in n steps.
double turned_j_m3(int n) {
  std::vector<fracture::Gradient> path;
  for (int i = 0; i <= n; ++i) {
    const double angle = kPi * i / n, shear = 0.08 * std::min(1.0, 4.0 * i / n);
    path.push_back({1, shear * std::cos(angle), shear * std::sin(angle), 0, 1, 0, 0, 0, 1});
  }
  return fracture::strain_history(path, clay(), {0.02, 0.15}).states.back().dissipated_j_m3;
}

}  // namespace

/// D02's additive plasticity along a path that turns.
Study plastic_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Additive plasticity of one element";
  study.question =
      "Does what a turning shear dissipates converge with the steps of the path, and is the yield where it should be?";
  // Volume-preserving stretch a: plastic strain of norm sqrt(2/3) (a^2 - 1/a) - gamma1 once it flows.
  const double a = 1.05, b = 1.0 / std::sqrt(a);
  const fracture::HistoryDocument stretched =
      fracture::strain_history({{a, 0, 0, 0, b, 0, 0, 0, b}}, clay(), {0.02, 0.15});
  study.claims.push_back(judged({"plastic.stretch",
                                 "norm of plastic strain at a stretch of 1.05, Green's measure",
                                 stretched.max_plastic_strain,
                                 0.5 * (std::sqrt(2.0 / 3.0) * (a * a - 1.0 / a) - 0.02),
                                 1e-14,
                                 {},
                                 false}));
  // tests/reference/plastic.json: row of stretch 1.25 and back, stretch 1.01
  const double c = 1.01, d = 1.0 / std::sqrt(c);
  const fracture::HistoryDocument first = fracture::strain_history({{c, 0, 0, 0, d, 0, 0, 0, d}}, clay(), {0.02, 0.15});
  study.claims.push_back(judged({"plastic.stress",
                                 "second Piola-Kirchhoff stress at a stretch of 1.01 [Pa]",
                                 first.states[0].pk2_pa[0],
                                 6661114.561613223,
                                 1e-5,
                                 {},
                                 false}));
  Series series;
  series.id = "turning-shear";
  series.title = "Dissipation of a shear that turns by half a turn";
  series.reference = "the same in 46,080 steps";
  series.step_words = "steps";
  series.error_words = "relative error of the dissipated energy";
  series.expected_order = 1.0;
  series.error_tolerance = 0.02;
  if (!wanted(options, series.id)) return study;
  const double exact = turned_j_m3(46080);
  constexpr std::array<int, 4> kSteps{90, 180, 360, 720};
  const std::size_t n = level_count(options, kSteps.size());
  for (std::size_t i = 0; i < n; ++i) {
    monitor.throw_if_stopped();
    const Stopwatch watch;
    Level level;
    level.n = kSteps[i];
    level.value = turned_j_m3(kSteps[i]);
    level.exact = exact;
    level.error = std::abs(*level.value / exact - 1.0);
    level.n_unknowns = kSteps[i];
    level.wall_time_s = watch.seconds();
    series.levels.push_back(level);
  }
  study.series.push_back(std::move(series));
  return study;
}

}  // namespace klang::validate
