// How often intervals hold the truth on the six chimes of datasets-synthetic/recipes: too long for a test at a hundred sounds.
#include <benchmark/benchmark.h>

#include "core/foundation/base/output_file.hpp"
#include "tests/fit/coverage.hpp"
#include "tests/places.hpp"

namespace {

void SixChimes(benchmark::State& state) {
  const std::string recipe =
      klang::read_file(klang::test::source_dir() + "/datasets-synthetic/recipes/six_chimes.toml");
  for (auto _ : state) {
    const auto coverage = klang::fit::test::interval_coverage(recipe, static_cast<int>(state.range(0)), 1000, 12600.0);
    for (const auto& [name, n_held] : coverage.held) state.counters["held_" + name] = n_held;
    state.counters["worst_E_error"] = coverage.worst_youngs_error;
    state.counters["worst_rayleigh_error"] = coverage.worst_rayleigh_error;
  }
}
BENCHMARK(SixChimes)->ArgName("sounds")->Arg(1)->Arg(100)->Iterations(1)->Unit(benchmark::kSecond);

}  // namespace
