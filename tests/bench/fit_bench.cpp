#include <benchmark/benchmark.h>

#include <filesystem>
#include <fstream>

#include "fit/run/fit.hpp"
#include "tests/process_file.hpp"

namespace {

/// Joint fit of chimes from tables of their first bending frequency (S02 Table 2): meshes, modes, matching, fit.
void BM_Fit_joint(benchmark::State& state) {
  const double lengths[] = {0.505, 0.475, 0.435, 0.410, 0.388, 0.353};
  const double frequencies[] = {585.8, 656.0, 781.8, 877.5, 982.5, 1167.0};
  klang::fit::FitProblem problem;
  problem.material = {4.98e10, 2.57e10, 2700.0, "", ""};
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa"};
  for (int i = 0; i < state.range(0); ++i) {
    klang::fit::Specimen specimen;
    specimen.name = "chime" + std::to_string(i);
    specimen.shape =
        klang::mesh::ShapeSpec{"tube", {{"length_m", lengths[i]}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
    const auto path = klang::test::process_file(specimen.name + ".csv");
    std::ofstream(path) << "frequency_hz\n" << frequencies[i] << '\n';
    specimen.partials = path;
    problem.specimens.push_back(specimen);
  }
  for (auto _ : state) {
    const auto result = klang::fit::run_fit(problem, {});
    if (!result.usable()) state.SkipWithError("the fit did not converge");
    benchmark::DoNotOptimize(result.matches.size());
  }
}
BENCHMARK(BM_Fit_joint)
    ->ArgName("chimes")
    ->Arg(1)
    ->Arg(6)
    ->Unit(benchmark::kSecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
