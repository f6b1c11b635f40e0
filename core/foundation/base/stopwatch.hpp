#pragma once
#include <chrono>

namespace klang {

/// Wall time by the steady clock, since it was made, restarted or last lapped.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }
  /// Seconds so far; starts anew.
  double lap() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;  // never set back
  Clock::time_point start_ = Clock::now();
};

}  // namespace klang
