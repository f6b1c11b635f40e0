#pragma once
#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/foundation/base/monitor.hpp"

namespace klang {

struct RankMessage {
  int from = 0;
  std::string bytes;
};

/// How the processes ("ranks") of one run talk to each other: MPI in the program, queues in tests. One thread calls.
class RankTransport {
 public:
  virtual ~RankTransport() = default;
  virtual int rank() const = 0;
  virtual int size() const = 0;
  /// Does not wait for the receiver.
  virtual void send(int to, std::string_view bytes) = 0;
  /// What has come by now, if anything. Messages of one sender keep their order.
  virtual std::optional<RankMessage> receive() = 0;
};

/// Shares jobs among ranks that all run the same program on the same input. Every rank calls run() with the same jobs in the
/// same order; rank 0 hands them out one by one, and each rank ends up with all results, so that all go on alike and any
/// number of ranks gives the same digits. Rank 0 alone is meant to write files (apps/kit/ranks.hpp sees to that).
class JobRanks {
 public:
  using Job = std::function<std::string(std::size_t index)>;
  using Accept = std::function<void(std::size_t index, std::string_view result)>;

  explicit JobRanks(RankTransport& transport) : transport_(transport) {}
  int rank() const { return transport_.rank(); }
  int size() const { return transport_.size(); }

  /// Returns when every rank has come here. @throws NumericalError where one of them does not within a minute
  void meet();
  struct Batch {
    std::size_t n = 0;       ///< jobs
    int n_at_once = 1;       ///< on each rank
    std::string_view stage;  ///< a few words for progress
  };
  /// job(i) for i in [0, n), each on one rank; accept(i, result) for all on all
  /// ranks: on rank 0 as they come, from the calling thread. The failure of the lowest index, a stop of any rank or the end of a rank
  /// is thrown on all.
  void run(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor);

  struct End {
    bool together = true;  ///< every rank has said that it ends; else the others must be ended by force
    int code = 0;          ///< this rank's, or where that is 0 and rank 0 asks, that of the lowest rank that failed
    std::string what;      ///< of that rank
  };
  /// Every rank says how it ends. A rank that failed waits for the others for the patience at most, one that did not for
  /// as long as they work.
  End finish(int code, const std::string& what, std::chrono::milliseconds patience);

 private:
  void lead(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor);
  void follow(const Batch& batch, const Job& job, const Accept& accept, Monitor& monitor);
  RankTransport& transport_;
  std::size_t calls_ = 0;
  std::set<int> gone_;  ///< ranks whose end rank 0 has heard of before its own
};

/// for_each_job with results goes over these ranks from now on; null (the beginning): this process does all by itself. They must
/// outlive their use.
void share_jobs_over(JobRanks* ranks);
JobRanks* shared_ranks();

}  // namespace klang
