#pragma once
#include <sys/types.h>

#include <string>

namespace klang::reports {

/// A private X server without a screen (Xvfb), for programs that cannot draw without a display. It lives as
/// long as the object and is gone, reaped, afterwards; it also ends when this process dies.
class VirtualDisplay {
 public:
  /// Looks for Xvfb along PATH and waits for it up to timeout_s. Where that fails, name() is empty and
  /// problem() says why in a few words ("no Xvfb").
  explicit VirtualDisplay(double timeout_s = 30.0);
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  /// What DISPLAY must be set to (":99"), or empty.
  const std::string& name() const { return name_; }
  const std::string& problem() const { return problem_; }
  pid_t process() const { return process_; }

 private:
  void stop();
  std::string name_, problem_;
  pid_t process_ = -1;
};

}  // namespace klang::reports
