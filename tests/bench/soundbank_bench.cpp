#include <benchmark/benchmark.h>

#include <vector>

#include "../soundbank/small_bank.hpp"
#include "core/soundbank/ellipsoid_radiation.hpp"
#include "core/soundbank/proxy.hpp"

namespace {

namespace sb = klang::soundbank;

// Moments to proxy (shape, place, scale, nearest cell) for many bodies, one thread.
void BM_Soundbank_lookup(benchmark::State& state) {
  const sb::ProxyFinder finder(klang::test::small_bank());
  const auto count = static_cast<int>(state.range(0));
  std::vector<Eigen::Vector3d> moments;
  for (int i = 0; i < count; ++i) {
    const Eigen::Array3d square = sb::unit_axes({-0.6 * i / count, -0.6 * i / count * (i % 7) / 7.0}).array().square();
    moments.emplace_back(square[1] + square[2], square[0] + square[2], square[0] + square[1]);
  }
  for (auto _ : state)
    for (const Eigen::Vector3d& m : moments) benchmark::DoNotOptimize(finder.find(m, 1000.0));
  state.counters["cells"] = static_cast<double>(finder.bank().cells.size());
}
BENCHMARK(BM_Soundbank_lookup)->ArgName("bodies")->Arg(10000)->Unit(benchmark::kMillisecond);

void BM_Ellipsoid_modes(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(sb::EllipsoidModes({0.1, 0.6, 1.0}, klang::test::glass(), {static_cast<int>(state.range(0)), 12}));
}
BENCHMARK(BM_Ellipsoid_modes)->ArgName("degree")->Arg(8)->Arg(12)->Unit(benchmark::kMillisecond);

// Sound of one mode; ka rises with the mode's rank. The shape is the costliest kind: long, of two thicknesses.
void BM_Ellipsoid_radiation(benchmark::State& state) {
  const sb::EllipsoidModes modes({0.2, 0.25, 1.0}, klang::test::glass(), {12, 12});
  const sb::ModeId mode = modes.lowest(static_cast<int>(state.range(0))).back();
  sb::EllipsoidRadiation found;
  for (auto _ : state) benchmark::DoNotOptimize(found = sb::radiate(modes, mode));
  state.counters["ka"] = found.multipole.wavenumber_per_m;
  state.counters["unknowns"] = found.n_unknowns;
  state.counters["boundary_error"] = found.boundary_error;
}
BENCHMARK(BM_Ellipsoid_radiation)->ArgName("rank")->Arg(1)->Arg(8)->Arg(16)->Unit(benchmark::kMillisecond);

}  // namespace
