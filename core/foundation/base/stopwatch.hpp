#pragma once
#include <chrono>

namespace klang {

/// Wall time by the steady clock.
class Stopwatch {
 public:
  /// Since it was made or last lapped [s].
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  /// The same, and starts anew.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace klang
