#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace klang::detail {

/// Errors that cross the border between processes keep their exit code.
enum class JobFailure : char { kNone, kInput, kNumerical, kInterrupted, kOther };

struct JobOutcome {
  std::size_t index = 0;
  JobFailure failure = JobFailure::kNone;
  std::string text;  ///< the result, or what the failure says
};

/// Throws what the failure was.
[[noreturn]] void throw_failure(const JobOutcome& outcome);

/// Runs jobs that come one by one on this process's threads, while the thread that owns it talks to others.
class JobRunner {
 public:
  JobRunner(const std::function<std::string(std::size_t)>& job, int n_slots);
  /// Waits for the jobs that run; those that wait are dropped.
  ~JobRunner();
  JobRunner(const JobRunner&) = delete;
  JobRunner& operator=(const JobRunner&) = delete;
  void give(std::size_t index);
  /// A job that is done, if any.
  std::optional<JobOutcome> take();

 private:
  void work();
  const std::function<std::string(std::size_t)>& job_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::size_t> waiting_;
  std::deque<JobOutcome> done_;
  bool closed_ = false;
  std::thread thread_;
};

}  // namespace klang::detail
