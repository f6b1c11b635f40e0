// Steps of heaps of convex stones of 14 corners, and of coins, on a floor. Limit: collision detection, one pair of hulls about 10 us.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/physics/rigid/rigid_world.hpp"
#include "tests/core/physics/rigid/bodies.hpp"

namespace {

using namespace klang::rigid;
using Eigen::Vector3d;

/// After 0.2 s: stones apart on the floor in a grid, or falling on each other.
void rigid_steps(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  const bool piled = state.range(1) != 0;
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  RigidWorld world(options);
  const int columns = piled ? std::max(2, static_cast<int>(std::cbrt(n))) : static_cast<int>(std::sqrt(n)) + 1;
  for (int i = 0; i < n; ++i) {
    RigidBodySpec body = stone(0.01);
    body.position_m = 0.021 * Vector3d(i % columns, i / columns % columns, 0.6 + i / columns / columns);
    world.add(body);
  }
  for (int i = 0; i < 1000; ++i) world.step();
  std::size_t contacts = 0, impacts = 0;
  for (auto _ : state) {
    const StepRecord step = world.step();
    contacts = step.contacts.size();
    for (const ContactImpulse& c : step.contacts) impacts += c.kind == klang::events::ImpulseKind::kImpact ? 1 : 0;
  }
  state.counters["steps_per_s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
  state.counters["contacts"] = static_cast<double>(contacts);
  state.counters["impacts"] = benchmark::Counter(static_cast<double>(impacts), benchmark::Counter::kAvgIterations);
}

BENCHMARK(rigid_steps)->Args({20, 0})->Args({328, 0})->Unit(benchmark::kMillisecond);
// The same steps each time: a heap comes to rest.
BENCHMARK(rigid_steps)->Args({100, 1})->Args({328, 1})->Iterations(1000)->Unit(benchmark::kMillisecond);

/// Coins (prisms of 32 sides) that fall loosely on one another: the first 0.2 s, from the fall to rest.
void rigid_coins(benchmark::State& state) {
  RigidWorldOptions options;
  options.rate_hz = 5000;
  options.floor = Skin{};
  RigidWorld world(options);
  for (int i = 0; i < state.range(0); ++i) {
    RigidBodySpec body = coin();
    body.orientation = Eigen::Quaterniond(1, 0.12 * std::sin(2.1 * i), 0.12 * std::cos(1.4 * i), 0.2 * i).normalized();
    body.position_m << 0.026 * (i % 4), 0.026 * (i / 4 % 4), 0.012 * (0.6 + i / 16);
    world.add(body);
  }
  for (auto _ : state) world.step();
  state.counters["steps_per_s"] = benchmark::Counter(1, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(rigid_coins)->Arg(96)->Iterations(1000)->Unit(benchmark::kMillisecond);

}  // namespace
