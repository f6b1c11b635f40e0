#include <benchmark/benchmark.h>

#include <vector>

#include "../soundbank/small_bank.hpp"
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

}  // namespace
