// Stress of free panes and a cube of linear tetrahedra. Limit of a solve: the factor is read twice from memory.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/foundation/la/block_ordering.hpp"
#include "core/physics/fracture/quasistatic/contact_responses.hpp"
#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "core/physics/solid/assembly.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang;
using fracture::FreeBodySolver;

solid::Material glass() { return solid::from_youngs_modulus(62e9, 0.2, 2600); }

/// Five nodes through its thickness.
mesh::TetMesh pane(std::int64_t n_nodes) {
  const int n = static_cast<int>(std::sqrt(static_cast<double>(n_nodes) / 5.0)) - 1;
  return test::box_mesh(0.3, 0.3, 0.012, n, n, 4, 1);
}

/// Three nodes through its thickness: the thinnest that bends.
mesh::TetMesh thin_pane(std::int64_t n_nodes) {
  const int n = static_cast<int>(std::sqrt(static_cast<double>(n_nodes) / 3.0)) - 1;
  return test::box_mesh(0.6, 0.6, 0.012, n, n, 2, 1);
}

mesh::TetMesh cube(std::int64_t n_nodes) {
  const int n = static_cast<int>(std::cbrt(static_cast<double>(n_nodes))) - 1;
  return test::box_mesh(0.1, 0.1, 0.1, n, n, n, 1);
}

void count(benchmark::State& state, const FreeBodySolver& solver) {
  state.counters["nodes"] = solver.mesh().n_nodes();
  state.counters["factor_MB"] = 8e-6 * solver.n_factor_entries();
}

template <mesh::TetMesh (*Body)(std::int64_t)>
void assemble_and_factor(benchmark::State& state) {
  const mesh::TetMesh mesh = Body(state.range(0));
  for (auto _ : state) {
    const FreeBodySolver solver(mesh, glass());
    if (!solver.usable()) state.SkipWithError("not factored");
    count(state, solver);
  }
}

template <mesh::TetMesh (*Body)(std::int64_t)>
void factor_alone(benchmark::State& state) {
  const solid::AssembledSolid solid = solid::assemble(Body(state.range(0)));
  la::SparseMatrix k = solid::stiffness(solid, glass().lame_lambda_pa, glass().lame_mu_pa);
  k += 1e6 * glass().density_kg_m3 * solid.mass_unit_density;
  for (auto _ : state) {
    la::SparseCholesky factor;
    if (!factor.factor(k, la::block_ordering(k))) state.SkipWithError("not factored");
  }
}

/// The triangular solves alone, of 1 or 8 columns.
template <mesh::TetMesh (*Body)(std::int64_t), int kColumns>
void triangular_solve(benchmark::State& state) {
  const solid::AssembledSolid solid = solid::assemble(Body(state.range(0)));
  la::SparseMatrix k = solid::stiffness(solid, glass().lame_lambda_pa, glass().lame_mu_pa);
  k += 1e6 * glass().density_kg_m3 * solid.mass_unit_density;
  la::SparseCholesky factor;
  if (!factor.factor(k, la::block_ordering(k))) state.SkipWithError("not factored");
  Eigen::MatrixXd x = Eigen::MatrixXd::Random(k.rows(), kColumns);
  for (auto _ : state) factor.solve(x.data(), x.data(), kColumns);
}

/// With the balance of the load, the residual and the rigid part.
template <mesh::TetMesh (*Body)(std::int64_t), int kColumns>
void solve(benchmark::State& state) {
  FreeBodySolver solver(Body(state.range(0)), glass());
  Eigen::MatrixXd force = Eigen::MatrixXd::Zero(3 * solver.mesh().n_nodes(), kColumns);
  for (int c = 0; c < kColumns; ++c) force(3 * c, c) = 1.0;
  for (auto _ : state) benchmark::DoNotOptimize(solver.solve(force));
  count(state, solver);
}

/// A force in a triangle whose nodes were touched before: responses added up, stress of all elements, the largest of them.
void stress_of_a_known_contact(benchmark::State& state) {
  FreeBodySolver solver(pane(state.range(0)), glass());
  fracture::ContactResponses responses(solver);
  const std::vector<fracture::NodeForce> forces = {{0, {1, 2, 3}}, {1, {3, 2, 1}}, {2, {2, 2, 2}}};
  responses.field(forces);
  double largest = 0.0;
  for (auto _ : state) largest += fracture::largest_principal_stress(solver.mesh(), responses.field(forces)).stress_pa;
  benchmark::DoNotOptimize(largest);
  count(state, solver);
}

void sum_of_responses(benchmark::State& state) {
  FreeBodySolver solver(pane(state.range(0)), glass());
  fracture::ContactResponses responses(solver);
  const std::vector<fracture::NodeForce> forces = {{0, {1, 2, 3}}, {1, {3, 2, 1}}, {2, {2, 2, 2}}};
  responses.field(forces);
  for (auto _ : state) benchmark::DoNotOptimize(responses.displacement_m(forces));
}

#define SIZES ->Arg(2000)->Arg(20000)->Unit(benchmark::kMillisecond)
BENCHMARK(assemble_and_factor<pane>) SIZES;
BENCHMARK(assemble_and_factor<cube>) SIZES;
BENCHMARK(factor_alone<thin_pane>) SIZES;
BENCHMARK(factor_alone<pane>) SIZES;
BENCHMARK(factor_alone<cube>) SIZES;
BENCHMARK(triangular_solve<thin_pane, 1>) SIZES;
BENCHMARK(triangular_solve<thin_pane, 8>) SIZES;
BENCHMARK(triangular_solve<pane, 1>) SIZES;
BENCHMARK(triangular_solve<pane, 8>) SIZES;
BENCHMARK(triangular_solve<cube, 1>) SIZES;
BENCHMARK(solve<thin_pane, 1>) SIZES;
BENCHMARK(solve<pane, 1>) SIZES;
BENCHMARK(solve<pane, 8>) SIZES;
BENCHMARK(solve<cube, 1>) SIZES;
BENCHMARK(sum_of_responses) SIZES;
BENCHMARK(stress_of_a_known_contact) SIZES;

}  // namespace
