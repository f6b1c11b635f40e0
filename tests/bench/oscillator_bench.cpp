// Throughput of the oscillator bank on one core: items are mode-samples.
#include <benchmark/benchmark.h>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/stage/oscillator_bank.hpp"

namespace {

void BM_OscillatorBank_render(benchmark::State& state) {
  using namespace klang;
  constexpr double kRate = 48000.0;
  const auto n_modes = static_cast<std::size_t>(state.range(0));
  const Eigen::Index n_frames = state.range(1) * 48000 / 1000;
  RandomStream random(1, 0);
  std::vector<stage::Oscillator> oscillators;
  for (std::size_t i = 0; i < n_modes; ++i) {
    oscillators.push_back({2 * kPi * random.uniform(30.0, 20000.0), random.uniform(0.5, 50.0), 1.0});
  }
  const double contact_s = static_cast<double>(state.range(2)) * 1e-6;
  const std::vector<stage::ModalImpulse> impulses = {
      {0.01, Eigen::VectorXd::Ones(static_cast<Eigen::Index>(n_modes)), contact_s}};
  set_thread_count(1);
  for (auto _ : state) {
    benchmark::DoNotOptimize(stage::oscillation(oscillators, impulses, kRate, n_frames));
  }
  set_thread_count(0);
  const auto frames = static_cast<double>(n_frames) * static_cast<double>(state.iterations());
  state.SetItemsProcessed(static_cast<std::int64_t>(frames * static_cast<double>(n_modes)));
  state.counters["real_time_factor"] = benchmark::Counter(frames / kRate, benchmark::Counter::kIsRate);
}

// modes / milliseconds of sound / contact in microseconds
BENCHMARK(BM_OscillatorBank_render)
    ->ArgNames({"modes", "ms", "contact_us"})
    ->Args({20, 100, 0})
    ->Args({20, 3000, 200})
    ->Args({100, 3000, 0})
    ->Args({1000, 3000, 0})
    ->Args({1000, 3000, 200})
    ->Unit(benchmark::kMillisecond);

}  // namespace
