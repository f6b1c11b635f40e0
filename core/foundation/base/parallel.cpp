#include "core/foundation/base/parallel.hpp"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <set>

#include "core/foundation/base/blas_kernels.hpp"
#include "core/foundation/base/check.hpp"

// OpenBLAS declares these in cblas.h beside names that clash with Eigen's; three declarations are enough.
extern "C" {
void openblas_set_num_threads(int n_threads);
int openblas_get_num_threads(void);
}

namespace klang {
namespace {

std::mutex control_mutex;
std::unique_ptr<tbb::global_control> control;
[[maybe_unused]] const bool kernels_chosen = choose_blas_kernels();

}  // namespace

void set_thread_count(int n_threads) {
  const std::lock_guard lock(control_mutex);
  control.reset();
  if (n_threads > 0) {
    control = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                    static_cast<std::size_t>(n_threads));
  }
}

int thread_count() {
  const auto allowed = tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism);
  const auto cores = static_cast<std::size_t>(tbb::info::default_concurrency());
  return static_cast<int>(allowed < cores ? allowed : cores);
}

void parallel_for(std::size_t n, std::size_t grain, const std::function<void(std::size_t, std::size_t)>& body) {
  KLANG_CHECK(grain > 0, "grain must be positive");
  const std::size_t n_ranges = (n + grain - 1) / grain;
  tbb::parallel_for(std::size_t{0}, n_ranges, [&](std::size_t range) {
    const std::size_t begin = range * grain;
    body(begin, begin + grain < n ? begin + grain : n);
  });
}

void for_each_job(std::size_t n, const std::function<void(std::size_t)>& job, std::string_view stage,
                  Monitor& monitor) {
  const bool many = n >= static_cast<std::size_t>(thread_count());
  const BlasThreads blas(many ? 1 : openblas_get_num_threads());
  std::atomic<std::size_t> done = 0;
  std::atomic<bool> failed = false;
  std::mutex mutex;
  std::exception_ptr first;
  std::size_t first_index = n;
  tbb::parallel_for(std::size_t{0}, n, [&](std::size_t i) {
    if (failed || monitor.stop_requested()) return;
    try {
      job(i);
    } catch (const std::exception&) {
      const std::lock_guard lock(mutex);
      failed = true;
      if (i < first_index) {
        first_index = i;
        first = std::current_exception();
      }
    }
    monitor.progress(stage, static_cast<double>(++done) / static_cast<double>(n));
  });
  if (first) std::rethrow_exception(first);
  monitor.throw_if_stopped();
}

namespace {

// OpenBLAS has one number for the process, which guards of several threads share.
std::mutex blas_mutex;
std::multiset<int> blas_asked;
int blas_before = 0;

void set_blas_threads(int n_threads) {
  if (openblas_get_num_threads() != n_threads) openblas_set_num_threads(n_threads);
}

}  // namespace

BlasThreads::BlasThreads(int n_threads) {
  const std::lock_guard lock(blas_mutex);
  if (blas_asked.empty()) blas_before = openblas_get_num_threads();
  asked_ = blas_asked.insert(n_threads);
  set_blas_threads(*blas_asked.begin());
}

BlasThreads::~BlasThreads() {
  const std::lock_guard lock(blas_mutex);
  blas_asked.erase(asked_);
  set_blas_threads(blas_asked.empty() ? blas_before : *blas_asked.begin());
}

}  // namespace klang
