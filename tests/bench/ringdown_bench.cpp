#include <benchmark/benchmark.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "fit/ringdown/ringdown.hpp"

namespace {

/// A bell-like sound: n_partials from 180 Hz to 0.31 of the rate, decays 0.5 to 40 per second, noise 60 dB
/// below.
klang::audio::Signal bell(int n_partials, double rate, double duration_s) {
  klang::audio::Signal signal;
  signal.sample_rate_hz = rate;
  signal.samples = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(rate * duration_s), 1);
  klang::RandomStream random(4, 0);
  const auto strike = static_cast<Eigen::Index>(0.1 * rate);
  for (int p = 0; p < n_partials; ++p) {
    const double part = static_cast<double>(p) / std::max(1, n_partials - 1);
    const double f = 180 * std::pow(0.31 * rate / 180, part) * random.uniform(0.98, 1.02);
    const double decay = 0.5 * std::pow(80.0, part), phase = random.uniform(-3, 3);
    for (Eigen::Index i = strike; i < signal.n_frames(); ++i) {
      const double t = static_cast<double>(i - strike) / rate;
      signal.samples(i, 0) += 0.05 * std::exp(-decay * t) * std::cos(2 * klang::kPi * f * t + phase);
    }
  }
  for (Eigen::Index i = 0; i < signal.n_frames(); ++i) signal.samples(i, 0) += 1e-4 * random.normal();
  return signal;
}

void identify(benchmark::State& state, const klang::audio::Signal& signal) {
  std::size_t found = 0;
  for (auto _ : state) {
    const auto result = klang::fit::identify_ringdown(signal);
    found = result.partials.partials.size();
    benchmark::DoNotOptimize(found);
  }
  state.counters["partials"] = static_cast<double>(found);
  state.counters["times_real_time"] =
      benchmark::Counter(signal.duration_s() * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

void BM_Ringdown_identify_short(benchmark::State& state) { identify(state, bell(5, 16000, 0.5)); }
void BM_Ringdown_identify_long(benchmark::State& state) { identify(state, bell(40, 48000, 6)); }

}  // namespace

BENCHMARK(BM_Ringdown_identify_short)
    ->Name("BM_Ringdown_identify/500ms_16kHz")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK(BM_Ringdown_identify_long)
    ->Name("BM_Ringdown_identify/6s_48kHz")
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
