#include <benchmark/benchmark.h>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/revolution_modes.hpp"

namespace {

namespace mesh = klang::mesh;
namespace modal = klang::modal;
namespace solid = klang::solid;

const solid::Material kAluminium{4.98e10, 2.57e10, 2700, "", ""};

void report(benchmark::State& state, const mesh::TetMesh& body, const modal::EigenResult& result) {
  state.counters["nodes"] = body.n_nodes();
  state.counters["modes"] = static_cast<double>(result.model.n_modes());
  state.counters["none_missing"] = result.none_missing.value_or(false) ? 1 : 0;
  state.counters["peak_GB"] = static_cast<double>(modal::peak_memory_bytes()) / 1e9;
  for (const auto& [name, seconds] : result.wall_time_s) state.counters[name + "_s"] = seconds;
}

// The D3 chime of S02, 20 modes, from its dimensions to proven modes.
void BM_Tube_mesh_to_result(benchmark::State& state, std::array<int, 3> divisions) {
  const mesh::ShapeSpec tube{"tube", {{"length_m", 0.505}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
  for (auto _ : state) {
    const mesh::TetMesh body = mesh::mesh_shape(tube, mesh::ShapeDivisions{divisions}, 2);
    modal::EigenOptions options;
    options.count = 20;
    const auto result = modal::solve_modes(body, solid::assemble(body), kAluminium, {}, options);
    if (!result.usable()) state.SkipWithError(result.message.c_str());
    report(state, body, result);
  }
}

// The same by harmonics of its section, shapes sampled to the default mesh: what `klang modes --shape tube` does.
void BM_Tube_by_harmonics(benchmark::State& state, int count) {
  const mesh::ShapeSpec tube{"tube", {{"length_m", 0.505}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
  for (auto _ : state) {
    const mesh::TetMesh body = mesh::mesh_shape(tube);
    modal::EigenOptions options;
    options.count = count;
    options.estimate_mesh_error = true;
    const auto result = modal::solve_revolution_modes(tube, body, kAluminium, options);
    if (!result.usable()) state.SkipWithError(result.message.c_str());
    report(state, body, result);
  }
}
BENCHMARK_CAPTURE(BM_Tube_by_harmonics, modes_2, 2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Tube_by_harmonics, modes_20, 20)->Unit(benchmark::kMillisecond)->UseRealTime();

BENCHMARK_CAPTURE(BM_Tube_mesh_to_result, 1k_nodes, {12, 8, 1})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Tube_mesh_to_result, 12k_nodes, {48, 20, 1})->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Tube_mesh_to_result, 14k_nodes, {48, 24, 1})->Unit(benchmark::kMillisecond)->UseRealTime();

mesh::TetMesh box(int cells) {
  const mesh::ShapeSpec cube{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.1}}, {}};
  return mesh::mesh_shape(cube, mesh::ShapeDivisions{{cells, cells, cells}}, 2);
}

void BM_Assembly_box(benchmark::State& state, int cells) {
  const mesh::TetMesh body = box(cells);
  for (auto _ : state) benchmark::DoNotOptimize(solid::assemble(body));
  state.counters["nodes"] = body.n_nodes();
  state.counters["dofs_per_s"] =
      benchmark::Counter(3.0 * body.n_nodes(), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK_CAPTURE(BM_Assembly_box, 1k_nodes, 4)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Assembly_box, 100k_nodes, 23)->Unit(benchmark::kMillisecond)->UseRealTime();

// A cube is the hardest body of its size: its factor is the largest.
void BM_Cube_50_modes(benchmark::State& state, int cells) {
  const mesh::TetMesh body = box(cells);
  for (auto _ : state) {
    modal::EigenOptions options;
    options.count = 50;
    const auto result = modal::solve_modes(body, solid::assemble(body), kAluminium, {}, options);
    if (!result.usable()) state.SkipWithError(result.message.c_str());
    report(state, body, result);
  }
}
BENCHMARK_CAPTURE(BM_Cube_50_modes, 1k_nodes, 4)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);
BENCHMARK_CAPTURE(BM_Cube_50_modes, 100k_nodes, 23)->Unit(benchmark::kMillisecond)->UseRealTime()->Iterations(1);

// A plate of the same number of nodes.
void BM_Plate_50_modes(benchmark::State& state, std::array<int, 3> cells) {
  const mesh::ShapeSpec plate{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.008}}, {}};
  const mesh::TetMesh body = mesh::mesh_shape(plate, mesh::ShapeDivisions{cells}, 2);
  for (auto _ : state) {
    modal::EigenOptions options;
    options.count = 50;
    const auto result = modal::solve_modes(body, solid::assemble(body), kAluminium, {}, options);
    if (!result.usable()) state.SkipWithError(result.message.c_str());
    report(state, body, result);
  }
}
BENCHMARK_CAPTURE(BM_Plate_50_modes, 100k_nodes, {74, 74, 2})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
