#include "core/foundation/base/detail/job_runner.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "core/foundation/base/errors.hpp"

namespace klang::detail {
namespace {

JobOutcome outcome_of(const std::function<std::string(std::size_t)>& job, std::size_t index) {
  JobOutcome outcome{index, JobFailure::kNone, {}};
  try {
    // Isolated: a thread that waits inside a job must not take up another slot's endless loop.
    tbb::this_task_arena::isolate([&] { outcome.text = job(index); });
  } catch (const InputError& error) {
    outcome = {index, JobFailure::kInput, error.what()};
  } catch (const NumericalError& error) {
    outcome = {index, JobFailure::kNumerical, error.what()};
  } catch (const Interrupted&) {
    outcome = {index, JobFailure::kInterrupted, {}};
  } catch (const std::exception& error) {
    outcome = {index, JobFailure::kOther, error.what()};
  }
  return outcome;
}

}  // namespace

void throw_failure(const JobOutcome& outcome) {
  switch (outcome.failure) {
    case JobFailure::kInput:
      throw InputError(outcome.text);
    case JobFailure::kInterrupted:
      throw Interrupted();
    case JobFailure::kNumerical:
      throw NumericalError(outcome.text);
    default:
      throw std::runtime_error(outcome.text);
  }
}

JobRunner::JobRunner(const std::function<std::string(std::size_t)>& job, int n_slots) : job_(job) {
  thread_ = std::thread([this, n_slots] {
    tbb::parallel_for(
        0, n_slots, [this](int) { work(); }, tbb::simple_partitioner());
  });
}

JobRunner::~JobRunner() {
  {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    waiting_.clear();
  }
  changed_.notify_all();
  thread_.join();
}

void JobRunner::work() {
  for (;;) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return closed_ || !waiting_.empty(); });
    if (closed_) return;
    const std::size_t index = waiting_.front();
    waiting_.pop_front();
    lock.unlock();
    JobOutcome outcome = outcome_of(job_, index);
    lock.lock();
    done_.push_back(std::move(outcome));
  }
}

void JobRunner::give(std::size_t index) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(index);
  }
  changed_.notify_one();
}

std::optional<JobOutcome> JobRunner::take() {
  const std::lock_guard lock(mutex_);
  if (done_.empty()) return std::nullopt;
  JobOutcome outcome = std::move(done_.front());
  done_.pop_front();
  return outcome;
}

}  // namespace klang::detail
