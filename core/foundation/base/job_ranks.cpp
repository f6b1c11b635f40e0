#include "core/foundation/base/job_ranks.hpp"

#include <algorithm>
#include <map>
#include <thread>
#include <vector>

#include "core/foundation/base/detail/job_runner.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/packed.hpp"

namespace klang {
namespace {

using detail::JobOutcome;
using detail::JobRunner;

enum class Kind : char { kMeet, kHello, kJob, kOutcome, kEnd, kGone, kBye };

constexpr std::chrono::microseconds kPause{200}, kLongestPause{3000};
constexpr std::chrono::seconds kMeetingPatience{60};
constexpr std::size_t kInAdvance =
    1;  ///< jobs that a rank has beyond those it works on, so that it need not wait for the next

void pack(Packer& to, const JobOutcome& outcome) { to.add(outcome.index).add(outcome.failure).add_list(outcome.text); }

JobOutcome unpack_outcome(Unpacker& from) {
  JobOutcome outcome;
  outcome.index = from.take<std::size_t>();
  outcome.failure = from.take<detail::JobFailure>();
  outcome.text = from.take_list<std::string>();
  return outcome;
}

std::string gone_message(int code, const std::string& what) {
  return Packer().add(Kind::kGone).add(code).add_list(what).take();
}

/// Waits where nothing has come, longer and longer: looking for messages takes time from the job beside it.
class Patience {
 public:
  void wait(bool heard) {
    pause_ = heard ? kPause : std::min(2 * pause_, kLongestPause);
    if (!heard) std::this_thread::sleep_for(pause_);
  }

 private:
  std::chrono::microseconds pause_ = kPause;
};

/// Rank 0's account of one run().
struct Ledger {
  std::size_t n, next = 0, n_done = 0;
  std::vector<std::size_t> in_hand;  ///< jobs that each rank has
  std::vector<std::size_t> slots;    ///< that it may have; 0: has not come yet
  std::vector<bool> gone;
  std::vector<std::map<std::size_t, std::string>> results;  ///< by the rank that made them
  std::optional<JobOutcome> failure;

  Ledger(std::size_t jobs, std::size_t ranks) : n(jobs), in_hand(ranks), slots(ranks), gone(ranks), results(ranks) {}
  void fail(JobOutcome outcome) {
    if (!failure || outcome.index < failure->index) failure = std::move(outcome);
  }
  bool idle() const {
    return std::all_of(in_hand.begin(), in_hand.end(), [](std::size_t jobs) { return jobs == 0; });
  }
  bool all_here() const {
    for (std::size_t r = 0; r < slots.size(); ++r)
      if (slots[r] == 0 && !gone[r]) return false;
    return true;
  }
  bool over() const { return idle() && (failure || (n_done == n && all_here())); }
};

void settle(Ledger& ledger, std::size_t rank, JobOutcome outcome, const JobRanks::Accept& accept) {
  if (outcome.index < ledger.n && ledger.in_hand[rank] > 0) --ledger.in_hand[rank];
  if (outcome.failure != detail::JobFailure::kNone) return ledger.fail(std::move(outcome));
  accept(outcome.index, outcome.text);
  ++ledger.n_done;
  ledger.results[rank].emplace(outcome.index, std::move(outcome.text));
}

/// What a rank sends while rank 0 leads call number `call`.
void hear(Ledger& ledger, const RankMessage& message, std::size_t call, std::string_view stage,
          const JobRanks::Accept& accept) {
  const auto rank = static_cast<std::size_t>(message.from);
  Unpacker from(message.bytes);
  switch (from.take<Kind>()) {
    case Kind::kHello: {
      if (from.take<std::size_t>() != call) return;  // of a call that failed before this rank came
      const auto n = from.take<std::size_t>();
      ledger.slots[rank] = from.take<std::size_t>();
      const auto theirs = from.take_list<std::string>();
      if (n != ledger.n || theirs != stage)
        ledger.fail({0, detail::JobFailure::kNumerical,
                     "the processes of this run do not agree on what is left to do (" + std::string(stage) + ": " +
                         std::to_string(ledger.n) + " jobs, " + theirs + ": " + std::to_string(n) + ")"});
      return;
    }
    case Kind::kOutcome:
      return settle(ledger, rank, unpack_outcome(from), accept);
    case Kind::kGone: {
      from.take<int>();
      ledger.gone[rank] = true;
      ledger.in_hand[rank] = 0;
      ledger.fail({0, detail::JobFailure::kNumerical,
                   "process " + std::to_string(rank) + " ended: " + from.take_list<std::string>()});
      return;
    }
    default:
      return;
  }
}

std::string end_message(const Ledger& ledger, std::size_t to) {
  Packer message;
  message.add(Kind::kEnd).add(ledger.failure.has_value());
  if (ledger.failure) {
    pack(message, *ledger.failure);
    return message.take();
  }
  for (std::size_t r = 0; r < ledger.results.size(); ++r) {
    if (r == to) continue;
    for (const auto& [index, result] : ledger.results[r]) message.add(index).add_list(result);
  }
  return message.take();
}

}  // namespace

void JobRanks::meet() {
  const std::string here = Packer().add(Kind::kMeet).take();
  if (rank() != 0) transport_.send(0, here);
  int missing = rank() == 0 ? size() - 1 : 1;
  const auto until = std::chrono::steady_clock::now() + kMeetingPatience;
  while (missing > 0) {
    if (const auto message = transport_.receive()) {
      Unpacker from(message->bytes);
      const Kind kind = from.take<Kind>();
      if (kind == Kind::kMeet) --missing;
      if (kind == Kind::kGone) {
        from.take<int>();
        gone_.insert(message->from);
        throw NumericalError("process " + std::to_string(message->from) + " ended: " + from.take_list<std::string>());
      }
      continue;
    }
    if (std::chrono::steady_clock::now() > until) throw NumericalError("the processes of this run do not meet");
    std::this_thread::sleep_for(kPause);
  }
  if (rank() != 0) return;
  for (int r = 1; r < size(); ++r) transport_.send(r, here);
}

void JobRanks::lead(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor) {
  const std::size_t n = batch.n;
  Ledger ledger(n, static_cast<std::size_t>(size()));
  JobRunner runner(job, batch.n_at_once);
  Patience patience;
  ledger.slots[0] = static_cast<std::size_t>(batch.n_at_once);
  while (!ledger.over()) {
    bool heard = false;
    while (const auto message = transport_.receive()) {
      hear(ledger, *message, calls_, batch.stage, accept);
      heard = true;
    }
    while (auto outcome = runner.take()) {
      settle(ledger, 0, std::move(*outcome), accept);
      heard = true;
    }
    if (monitor.stop_requested()) ledger.fail({0, detail::JobFailure::kInterrupted, {}});
    for (std::size_t r = 0; r < ledger.slots.size() && !ledger.failure; ++r) {
      // At the end nobody holds a job that another could begin.
      const std::size_t in_advance = r > 0 && n - ledger.next > 2 * ledger.slots.size() ? kInAdvance : 0;
      while (ledger.next < n && ledger.in_hand[r] < ledger.slots[r] + in_advance && ledger.slots[r] > 0 &&
             !ledger.gone[r]) {
        ++ledger.in_hand[r];
        const std::size_t index = ledger.next++;
        if (r == 0)
          runner.give(index);
        else
          transport_.send(static_cast<int>(r), Packer().add(Kind::kJob).add(index).take());
      }
    }
    if (heard) monitor.progress(batch.stage, static_cast<double>(ledger.n_done) / static_cast<double>(n));
    patience.wait(heard);
  }
  for (int r = 1; r < size(); ++r) {
    if (ledger.gone[static_cast<std::size_t>(r)]) {
      gone_.insert(r);
    } else {
      transport_.send(r, end_message(ledger, static_cast<std::size_t>(r)));
    }
  }
  if (ledger.failure) detail::throw_failure(*ledger.failure);
}

void JobRanks::follow(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor) {
  const auto slots = static_cast<std::size_t>(batch.n_at_once);
  transport_.send(0, Packer().add(Kind::kHello).add(calls_).add(batch.n).add(slots).add_list(batch.stage).take());
  std::map<std::size_t, std::string> results;
  bool stopped = false;
  JobRunner runner(job, batch.n_at_once);
  Patience patience;
  for (;;) {
    bool heard = false;
    while (auto outcome = runner.take()) {
      Packer message;
      message.add(Kind::kOutcome);
      pack(message, *outcome);
      transport_.send(0, message.take());
      if (outcome->failure == detail::JobFailure::kNone) results.emplace(outcome->index, std::move(outcome->text));
      heard = true;
    }
    if (!stopped && monitor.stop_requested()) {
      Packer message;
      message.add(Kind::kOutcome);
      pack(message, {batch.n, detail::JobFailure::kInterrupted, {}});
      transport_.send(0, message.take());
      stopped = true;
    }
    if (const auto message = transport_.receive()) {
      heard = true;
      Unpacker from(message->bytes);
      switch (from.take<Kind>()) {
        case Kind::kJob:
          runner.give(from.take<std::size_t>());
          break;
        case Kind::kGone:
          from.take<int>();
          throw NumericalError("process 0 ended: " + from.take_list<std::string>());
        case Kind::kEnd: {
          if (from.take<bool>()) detail::throw_failure(unpack_outcome(from));
          while (!from.done()) {
            const auto index = from.take<std::size_t>();
            results.emplace(index, from.take_list<std::string>());
          }
          for (const auto& [index, result] : results) accept(index, result);
          return;
        }
        default:
          break;
      }
    }
    patience.wait(heard);
  }
}

void JobRanks::run(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor) {
  if (batch.n == 0) return;
  ++calls_;
  if (rank() == 0)
    lead(batch, job, accept, monitor);
  else
    follow(batch, job, accept, monitor);
}

JobRanks::End JobRanks::finish(int code, const std::string& what, std::chrono::milliseconds patience) {
  End end{true, code, what};
  const std::string gone = gone_message(code, what);
  if (rank() != 0)
    transport_.send(0, gone);
  else if (code != 0)
    for (int r = 1; r < size(); ++r) transport_.send(r, gone);  // some may wait for a job
  int missing = rank() == 0 ? size() - 1 - static_cast<int>(gone_.size()) : 1, lowest = size();
  const auto until = std::chrono::steady_clock::now() + patience;
  while (missing > 0) {
    if (const auto message = transport_.receive()) {
      Unpacker from(message->bytes);
      const Kind kind = from.take<Kind>();
      if (kind == Kind::kBye || (kind == Kind::kGone && rank() == 0)) --missing;
      if (kind != Kind::kGone || rank() != 0) continue;
      const int theirs = from.take<int>();
      if (code == 0 && theirs != 0 && message->from < lowest) {
        lowest = message->from;
        end.code = theirs;
        end.what = "process " + std::to_string(lowest) + ": " + from.take_list<std::string>();
      }
      continue;
    }
    if (code != 0 && std::chrono::steady_clock::now() > until) return {false, code, what};
    std::this_thread::sleep_for(kPause);
  }
  if (rank() == 0)
    for (int r = 1; r < size(); ++r) transport_.send(r, Packer().add(Kind::kBye).take());
  return end;
}

namespace {
JobRanks* ranks_of_process = nullptr;
}

void share_jobs_over(JobRanks* ranks) { ranks_of_process = ranks; }
JobRanks* shared_ranks() { return ranks_of_process; }

}  // namespace klang
