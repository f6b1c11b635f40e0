#include "core/foundation/base/monitor.hpp"

#include "core/foundation/base/errors.hpp"

namespace klang {

void Monitor::progress(std::string_view, double) {}

bool Monitor::stop_requested() const { return false; }

void Monitor::throw_if_stopped() const {
  if (stop_requested()) throw Interrupted();
}

Monitor& silent_monitor() {
  static Monitor monitor;
  return monitor;
}

}  // namespace klang
