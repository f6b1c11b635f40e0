#pragma once
#include <Eigen/Core>
#include <atomic>
#include <cstdint>

#include "core/foundation/base/monitor.hpp"

namespace klang::fit::bubble {

/// What a search has cost so far, counted and not timed, so that the same recording ends in the same place on every machine;
/// and whether it shall go on. Members may be called from any thread.
class SearchWork {
 public:
  explicit SearchWork(const Monitor& monitor, double limit = 1e18) : monitor_(monitor), limit_(limit) {}
  /// One chirp evaluated at n samples. A slope for each of its seven parameters costs as much again.
  void count(Eigen::Index n, bool with_slopes) { samples_ += with_slopes ? 8 * n : n; }
  bool used_up(double times = 1.0) const { return static_cast<double>(samples_) >= times * limit_; }
  const Monitor& monitor() const { return monitor_; }

 private:
  const Monitor& monitor_;
  double limit_;
  std::atomic<std::int64_t> samples_ = 0;
};

}  // namespace klang::fit::bubble
