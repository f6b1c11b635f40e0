#include <benchmark/benchmark.h>

#include <vector>

#include "core/sound/soundbank/detail/shell_kernel.hpp"
#include "core/sound/soundbank/ellipsoid_radiation.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "tests/core/sound/soundbank/small_bank.hpp"

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
  for (auto _ : state)
    benchmark::DoNotOptimize(
        sb::EllipsoidModes({0.1, 0.6, 1.0}, klang::test::glass(), {static_cast<int>(state.range(0)), 12}));
}
BENCHMARK(BM_Ellipsoid_modes)->ArgName("degree")->Arg(8)->Arg(14)->Unit(benchmark::kMillisecond);

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

// The hot loop of the radiation: 103 additions and multiplications an image of a source.
void BM_Shell_kernel(benchmark::State& state) {
  sb::detail::SourceColumns sources;
  sources.n_padded = 1024;
  for (int d = 0; d < 3; ++d) {
    sources.points_m[d].assign(sources.n_padded, 0.1 * (d + 1));
    sources.normals[d].assign(sources.n_padded, 0.5);
  }
  std::vector<double> re(sources.n_padded), im(sources.n_padded);
  for (auto _ : state) {
    sb::detail::mirrored_normal_derivative(sources, {{0.3, 0.4, 0.5}, {0.6, 0.64, 0.48}}, 3, 40.0, 30.0, re.data(),
                                           im.data());
    benchmark::DoNotOptimize(re.data());
  }
  state.counters["flop_per_s"] =
      benchmark::Counter(8.0 * 103.0 * 1024.0 * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK(BM_Shell_kernel);

}  // namespace
