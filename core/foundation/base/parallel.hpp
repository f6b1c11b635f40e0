#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <set>
#include <string_view>

#include "core/foundation/base/monitor.hpp"

namespace klang {

/// Threads that parallel_for and for_each_job may use, 1 or more; 0 means all cores. Affects the whole process.
void set_thread_count(int n_threads);
int thread_count();

/// Calls body(begin, end) on disjoint ranges that cover [0, n), in parallel. Ranges are cut at multiples of grain
/// whatever the number of threads, so that work summed a range at a time gives the same bits on any machine.
void parallel_for(std::size_t n, std::size_t grain,
                  const std::function<void(std::size_t begin, std::size_t end)>& body);

/// Independent jobs (specimens, seeds, study levels). Runs job(i) for i in [0, n), in parallel, reports the
/// fraction done, stops between jobs; the first exception (of the lowest index that failed) is thrown again.
/// BLAS runs on one thread inside the jobs when there are as many jobs as threads. The one place to go over MPI.
void for_each_job(std::size_t n, const std::function<void(std::size_t index)>& job, std::string_view stage = "jobs",
                  Monitor& monitor = silent_monitor());

/// While it lives, BLAS calls use n_threads threads at most: of several that live at once, in whatever threads, the smallest number holds,
/// and the last to end brings back what was before the first. Needed around BLAS inside parallel_for bodies (use 1) and around
/// one large factorisation (use thread_count()); without it threads multiply.
class BlasThreads {
 public:
  explicit BlasThreads(int n_threads);
  ~BlasThreads();
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;

 private:
  std::multiset<int>::iterator asked_;
};

}  // namespace klang
