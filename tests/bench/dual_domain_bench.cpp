// One bubble's transfer by the dual-domain solver: N = 12,000 samples of a tank, 60 quadrupoles in the liquid and 100 in the air
// (the size HF gives 1 to 4 s for), beside LAPACK's zgels on the printed systems. Both in one run.
#include <benchmark/benchmark.h>
#include <sys/resource.h>

#include "core/sound/dual_domain/dual_domain.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"

extern "C" void zgels_(const char* trans, const int* m, const int* n, const int* n_rhs, std::complex<double>* a,
                       const int* lda, std::complex<double>* b, const int* ldb, std::complex<double>* work,
                       const int* n_work, int* info);

namespace {

using namespace klang;
using namespace klang::bubble;

struct Problem {
  LiquidBoundary boundary;
  SourcePoints points;
};

const Problem& problem(bool large) {
  static const auto make = [](double h, int n_fluid, int n_air) {
    LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, h));
    SourcePoints points = random_source_points(boundary, n_fluid, n_air, 1);
    return Problem{std::move(boundary), std::move(points)};
  };
  if (large) {
    static const Problem p = make(0.00498, 60, 100);
    return p;
  }
  static const Problem p = make(0.02, 10, 15);
  return p;
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void solve(benchmark::State& state, bool large, const DualDomainOptions& options) {
  const Problem& p = problem(large);
  std::vector<DualDomainResult> results;
  for (auto _ : state) {
    results = solve_dual_domain(p.boundary, 2000.0, p.points, {{{0.13, 0.10, -0.05}, 0.0016}}, options);
    benchmark::DoNotOptimize(results);
  }
  if (!results[0].usable()) state.SkipWithError(results[0].message.c_str());
  state.counters["samples"] = static_cast<double>(p.boundary.samples().size());
  state.counters["fit_fluid"] = results[0].fit_error_fluid;
  state.counters["fit_air"] = results[0].fit_error_air;
  state.counters["steps_air"] = results[0].n_air_steps;
  state.counters["peak_MB"] = peak_memory_mb();
  for (const auto& [stage, seconds] : results[0].wall_time_s) state.counters[stage] = seconds;
}

void BM_DualDomain_bubble(benchmark::State& state, bool large) { solve(state, large, {}); }
void BM_DualDomain_bubble_direct(benchmark::State& state, bool large) {
  DualDomainOptions options;
  options.solver = LeastSquares::kDirect;
  solve(state, large, options);
}
void BM_DualDomain_bubble_as_printed(benchmark::State& state, bool large) {
  solve(state, large, DualDomainOptions::as_printed());
}
void BM_DualDomain_bubble_as_printed_direct(benchmark::State& state, bool large) {
  DualDomainOptions options = DualDomainOptions::as_printed();
  options.solver = LeastSquares::kDirect;
  solve(state, large, options);
}

/// What HF does: complex QR of both systems by zgels, nothing else (no assembly). Time does not depend on the numbers in it.
void BM_DualDomain_plain_zgels(benchmark::State& state, bool large) {
  const int n_samples = static_cast<int>(problem(large).boundary.samples().size());
  for (auto _ : state) {
    for (const int n_unknowns : {9 * static_cast<int>(problem(large).points.fluid_m.size()),
                                 9 * static_cast<int>(problem(large).points.air_m.size())}) {
      state.PauseTiming();
      const int rows = n_samples + n_unknowns, one = 1;
      std::srand(1);
      Eigen::MatrixXcd a = Eigen::MatrixXcd::Random(rows, n_unknowns);
      Eigen::VectorXcd b = Eigen::VectorXcd::Random(rows);
      int query = -1, info = 0;
      std::complex<double> wanted;
      zgels_("N", &rows, &n_unknowns, &one, a.data(), &rows, b.data(), &rows, &wanted, &query, &info);
      query = static_cast<int>(wanted.real());
      std::vector<std::complex<double>> work(static_cast<std::size_t>(query));
      state.ResumeTiming();
      zgels_("N", &rows, &n_unknowns, &one, a.data(), &rows, b.data(), &rows, work.data(), &query, &info);
      benchmark::DoNotOptimize(b.data());
    }
  }
  state.counters["samples"] = n_samples;
}

BENCHMARK_CAPTURE(BM_DualDomain_bubble, small, false)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DualDomain_bubble, samples_12000, true)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DualDomain_plain_zgels, samples_12000, true)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DualDomain_bubble_direct, samples_12000, true)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DualDomain_bubble_as_printed, samples_12000, true)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_DualDomain_bubble_as_printed_direct, samples_12000, true)
    ->MeasureProcessCPUTime()
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
