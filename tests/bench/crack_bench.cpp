// A step of an explicit solid of linear tetrahedra, and a look at all its nodes. Limit of a step: arithmetic of an element.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/physics/fracture/dynamic/cracker.hpp"
#include "tests/core/physics/fracture/dynamic/lattice.hpp"

namespace {

using namespace klang;
using fracture::CrackMesh;
using fracture::ExplicitSolid;

ExplicitSolid shaken(std::int64_t n_elements, double viscosity, double gamma2) {
  const int n = static_cast<int>(std::lround(std::cbrt(static_cast<double>(n_elements) / 6.0)));
  fracture::SolidOptions options;
  options.material = solid::from_youngs_modulus(3.4e8, 0.4, 2309);
  options.viscosity_mu_pa_s = options.viscosity_lambda_pa_s = viscosity;
  options.plasticity = {1e-5, gamma2};
  CrackMesh mesh(test::lattice({n, n, n}, {0.3, 0.3, 0.3}, 0.2), options.material.density_kg_m3);
  for (std::size_t i = 0; i < mesh.rest_m.size(); ++i) mesh.velocity_m_s[i].x() = std::sin(40.0 * mesh.rest_m[i].y());
  return {std::move(mesh), options};
}

void step(benchmark::State& state, double viscosity, double gamma2) {
  ExplicitSolid solid = shaken(state.range(0), viscosity, gamma2);
  const double dt = 0.5 * solid.step_limit_s();
  for (auto _ : state) solid.step(dt);
  state.counters["per_element"] =
      benchmark::Counter(static_cast<double>(state.iterations()) * solid.mesh().n_elements(),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void elastic(benchmark::State& state) { step(state, 0.0, 0.0); }
void damped(benchmark::State& state) { step(state, 6000.0, 0.0); }
void flowing(benchmark::State& state) { step(state, 0.0, 0.2); }
void flowing_damped(benchmark::State& state) { step(state, 6000.0, 0.2); }

void separation_of_all_nodes(benchmark::State& state) {
  ExplicitSolid solid = shaken(state.range(0), 0.0, 0.0);
  for (int i = 0; i < 50; ++i) solid.step(0.5 * solid.step_limit_s());
  const CrackMesh& mesh = solid.mesh();
  for (auto _ : state) {
    fracture::SplitStresses split(mesh.n_elements());
    for (int i = 0; i < mesh.n_nodes(); ++i)
      benchmark::DoNotOptimize(fracture::separation_at(mesh, i, solid.options().material,
                                                       fracture::CrackCriterion::kSeparation, nullptr, &split)
                                   .stress_pa);
  }
  state.counters["per_element"] = benchmark::Counter(static_cast<double>(state.iterations()) * mesh.n_elements(),
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

BENCHMARK(elastic)->Arg(1296)->Arg(8250)->Unit(benchmark::kMicrosecond);
BENCHMARK(damped)->Arg(1296)->Arg(8250)->Unit(benchmark::kMicrosecond);
BENCHMARK(flowing)->Arg(1296)->Arg(8250)->Unit(benchmark::kMicrosecond);
BENCHMARK(flowing_damped)->Arg(1296)->Arg(8250)->Unit(benchmark::kMicrosecond);
BENCHMARK(separation_of_all_nodes)->Arg(1296)->Unit(benchmark::kMicrosecond);

}  // namespace
