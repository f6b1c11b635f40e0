#pragma once
#include <chrono>

namespace klang {

/// Wall time since it was made or restarted.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  void restart() { start_ = Clock::now(); }

 private:
  using Clock = std::chrono::steady_clock;  // never set back
  Clock::time_point start_ = Clock::now();
};

}  // namespace klang
