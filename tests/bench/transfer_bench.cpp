// All-mode transfer at one listener and at many: items are listeners. The scenes have sum of orders 2176, as the plate of
// SB section 6 (theirs: 0.156 s on 8 cores, 0.0003 s on a GPU).
#include <benchmark/benchmark.h>

#include <cstdlib>
#include <numeric>

#include "core/foundation/base/parallel.hpp"
#include "core/sound/transfer/transfer_evaluation.hpp"
#include "core/sound/transfer/transfer_opencl.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace {
using namespace klang;
using namespace klang::acoustics;

// 80 modes of orders 8 ... 46, 36 of about 60, or 544 of 4; the sum is 2176.
TransferModel scene(std::int64_t n_modes) {
  std::vector<int> orders;
  for (std::int64_t i = 0; i < n_modes; ++i) {
    orders.push_back(
        static_cast<int>(n_modes == 80 ? 7 + i / 2 + (i < 56 ? 1 : 0) : 2176 * (i + 1) / n_modes - 2176 * i / n_modes));
  }
  if (std::accumulate(orders.begin(), orders.end(), 0) != 2176) std::abort();
  return random_transfer(orders, 1);
}

Eigen::Matrix3Xd listeners(std::int64_t n) {
  Eigen::Matrix3Xd x(3, n);
  for (std::int64_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / 200.0;
    x.col(i) << 1.0 + 0.3 * std::cos(t), 2.0 * std::sin(0.3 * t), 0.5 + 0.1 * t;
  }
  return x;
}

void BM_Transfer_cpu(benchmark::State& state) {
  const TransferEvaluator evaluator(scene(state.range(0)));
  const Eigen::Matrix3Xd x = listeners(state.range(1));
  set_thread_count(static_cast<int>(state.range(2)));
  Eigen::MatrixXcd p;
  for (auto _ : state) {
    evaluator.evaluate(x, p);
    benchmark::DoNotOptimize(p.data());
  }
  set_thread_count(0);
  const double n = static_cast<double>(state.iterations()) * static_cast<double>(state.range(1));
  state.SetItemsProcessed(static_cast<std::int64_t>(n));
  state.counters["GFlop"] = evaluator.operations_per_listener() * 1e-9;
  state.counters["GFlop/s"] =
      benchmark::Counter(evaluator.operations_per_listener() * n * 1e-9, benchmark::Counter::kIsRate);
}

// |p| of one mode on a slice of 512 x 512 points, as the pictures ask.
void BM_Transfer_slice(benchmark::State& state) {
  const TransferEvaluator evaluator(random_transfer({static_cast<int>(state.range(0))}, 1));
  Eigen::Matrix3Xd x(3, 512 * 512);
  for (Eigen::Index i = 0; i < x.cols(); ++i)
    x.col(i) << static_cast<double>(i % 512) / 256.0 - 1.0013, static_cast<double>(i / 512) / 256.0 - 1.0017, 0.11;
  Eigen::MatrixXcd p;
  for (auto _ : state) {
    evaluator.evaluate(x, p);
    benchmark::DoNotOptimize(p.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations()) * x.cols());
}
BENCHMARK(BM_Transfer_slice)->ArgName("order")->Arg(10)->Arg(40)->Unit(benchmark::kMillisecond)->UseRealTime();

// On the default OpenCL device (PoCL: the same processor).
void BM_Transfer_opencl(benchmark::State& state) {
  const TransferModel model = scene(state.range(0));
  const Eigen::Matrix3Xd x = listeners(state.range(1));
  try {
    OpenClTransfer device(model, "", state.range(2) != 0 ? Precision::kDouble : Precision::kSingle);
    Eigen::MatrixXcd p;
    device.evaluate(x, p);
    for (auto _ : state) {
      device.evaluate(x, p);
      benchmark::DoNotOptimize(p.data());
    }
    state.SetLabel(device.device().name);
  } catch (const opencl::Error& error) {
    state.SkipWithError(error.what());
  }
  const double n = static_cast<double>(state.iterations()) * static_cast<double>(state.range(1));
  state.SetItemsProcessed(static_cast<std::int64_t>(n));
  state.counters["GFlop/s"] =
      benchmark::Counter(TransferEvaluator(model).operations_per_listener() * n * 1e-9, benchmark::Counter::kIsRate);
}

BENCHMARK(BM_Transfer_cpu)
    ->ArgNames({"modes", "listeners", "threads"})
    ->ArgsProduct({{80, 36, 544}, {1, 600}, {1, 2}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

BENCHMARK(BM_Transfer_opencl)
    ->ArgNames({"modes", "listeners", "double"})
    ->ArgsProduct({{80, 36}, {1, 600}, {0, 1}})
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

}  // namespace
