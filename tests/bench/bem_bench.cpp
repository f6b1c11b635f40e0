#include <benchmark/benchmark.h>

#include <cmath>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/transfer/radiate.hpp"

namespace {

using namespace klang::acoustics;
namespace mesh = klang::mesh;
namespace modal = klang::modal;

// One frequency on a sphere of 20 divisions^2 elements, from the surface to the multipoles. ka grows with the mesh: about 8
// elements per wavelength. Bars: 2,000 elements 3 s, 10,000 elements 60 s and 4 GB on 2 cores.
void BM_Bem_one_frequency(benchmark::State& state, int divisions) {
  const SphereCase sphere{1, 0.1, 0.6 * divisions, divisions};
  for (auto _ : state) {
    const SphereResult result = solve_sphere(sphere);
    if (!result.bem.usable()) state.SkipWithError(result.bem.message.c_str());
    state.counters["error"] = result.surface_pressure_relative_error;
    for (const auto& [name, seconds] : result.bem.wall_time_s) state.counters[name + "_s"] = seconds;
  }
  state.counters["elements"] = 20.0 * divisions * divisions;
  state.counters["peak_GB"] = static_cast<double>(modal::peak_memory_bytes()) / 1e9;
}
BENCHMARK_CAPTURE(BM_Bem_one_frequency, elements_320, 4)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Bem_one_frequency, elements_2000, 10)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Bem_one_frequency, elements_10580, 23)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

// Transfer of a free aluminium plate, all modes from 20 Hz to highest_hz; the modes themselves are not counted. Bar: 80 modes
// to 8 kHz in 10 min on 2 cores.
void BM_Transfer_of_plate(benchmark::State& state, double length_m, double width_m, double height_m,
                          double highest_hz) {
  const mesh::ShapeSpec plate{"box", {{"length_m", length_m}, {"width_m", width_m}, {"height_m", height_m}}, {}};
  mesh::ShapeMeshOptions mesh_options;
  mesh_options.wavelength_m = 0.7 * std::sqrt(1.8 * 5400.0 * height_m / highest_hz);  // bending, with a margin
  const mesh::TetMesh body = mesh::mesh_shape(plate, mesh_options);
  modal::EigenOptions options;
  options.band = {20.0, highest_hz};
  const auto modes =
      modal::solve_modes(body, klang::solid::assemble(body), {4.98e10, 2.57e10, 2700, "", ""}, {}, options);
  if (!modes.usable()) state.SkipWithError(modes.message.c_str());
  for (auto _ : state) {
    const RadiateResult result = radiate(modes.model);
    if (!result.usable()) state.SkipWithError(result.message.c_str());
    for (const auto& [name, seconds] : result.wall_time_s) state.counters[name + "_s"] = seconds;
    state.counters["finest_elements"] = result.n_elements_of_level.back();
  }
  state.counters["modes"] = static_cast<double>(modes.model.n_modes());
  state.counters["peak_GB"] = static_cast<double>(modal::peak_memory_bytes()) / 1e9;
}
BENCHMARK_CAPTURE(BM_Transfer_of_plate, small, 0.06, 0.05, 0.003, 8000.0)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Transfer_of_plate, modes_80, 0.34, 0.24, 0.003, 8000.0)
    ->Unit(benchmark::kSecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

}  // namespace
