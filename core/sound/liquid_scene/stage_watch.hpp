#pragma once
#include <sys/resource.h>

#include "core/foundation/base/stopwatch.hpp"

namespace klang::liquid_scene {

/// Processor seconds of all threads of this process so far.
inline double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Wall and processor time of a stage since it was made.
class StageWatch {
 public:
  double seconds() const { return wall_.seconds(); }
  double cpu_s() const { return cpu_seconds() - cpu_before_; }

 private:
  Stopwatch wall_;
  double cpu_before_ = cpu_seconds();
};

}  // namespace klang::liquid_scene
