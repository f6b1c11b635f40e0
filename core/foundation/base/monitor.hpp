#pragma once
#include <string_view>

namespace klang {

/// What long work tells its caller, and how the caller stops it. Library code never prints; the command line
/// shows progress on a terminal. Both members may be called from any thread.
class Monitor {
 public:
  virtual ~Monitor() = default;
  /// stage: a few words ("eigenmodes"); fraction: 0 to 1 of that stage.
  virtual void progress(std::string_view stage, double fraction);
  virtual bool stop_requested() const;
  /// Throws Interrupted when a stop was requested.
  void throw_if_stopped() const;
};

/// Says nothing, never stops.
Monitor& silent_monitor();

}  // namespace klang
