#include "core/foundation/base/shared_jobs.hpp"

#include <atomic>
#include <mutex>
#include <optional>

#include "core/foundation/base/job_ranks.hpp"
#include "core/foundation/base/parallel.hpp"

namespace klang {

void for_each_shared_job(std::size_t n, const std::function<std::string(std::size_t)>& job,
                         const std::function<void(std::size_t, std::string_view)>& accept, std::string_view stage,
                         Monitor& monitor, JobThreads threads) {
  const bool one_by_one = threads == JobThreads::kAllForOneJob;
  static std::atomic<bool> sharing = false;
  if (JobRanks* ranks = shared_ranks(); ranks != nullptr && !sharing.exchange(true)) {
    struct Over {
      ~Over() { sharing = false; }
    } over;
    std::optional<BlasThreads> one;  // as in for_each_job
    if (!one_by_one && n >= static_cast<std::size_t>(thread_count())) one.emplace(1);
    ranks->run({n, one_by_one ? 1 : thread_count(), stage}, job, accept, monitor);
    monitor.throw_if_stopped();
    return;
  }
  if (one_by_one) {
    for (std::size_t i = 0; i < n; ++i) {
      monitor.throw_if_stopped();
      accept(i, job(i));
      monitor.progress(stage, static_cast<double>(i + 1) / static_cast<double>(n));
    }
    return;
  }
  std::mutex mutex;
  for_each_job(
      n,
      [&](std::size_t i) {
        const std::string result = job(i);
        const std::lock_guard lock(mutex);
        accept(i, result);
      },
      stage, monitor);
}

}  // namespace klang
