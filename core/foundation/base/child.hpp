#pragma once
#include <cstddef>
#include <functional>
#include <string>

#include "core/foundation/base/monitor.hpp"

namespace klang {

/// What became of work in a child process.
struct ChildResult {
  bool done = false;  ///< bytes are what the work gave
  std::string bytes;  ///< or, where the work threw, what it said
  int signal = 0;     ///< that ended the child before it was done; 0: none
};

/// Runs work in a forked copy of this process: for libraries that cannot be asked to stop, that print, or that crash on some
/// input. The child has one thread, its standard output and error go nowhere, and it dies with its parent. Its memory is
/// lost but for the bytes that work returns.
/// Not while other threads of this process are in BLAS (its threads are put down by a fork). Where no process can be
/// made, the work is done here.
/// @param more_bytes that the child may take beside what this process holds (address space); what asks for more gets
/// std::bad_alloc. 0: no limit
/// @throws Interrupted when the monitor asks for a stop: the child is ended first
ChildResult run_in_child(const std::function<std::string()>& work, Monitor& monitor = silent_monitor(),
                         std::size_t more_bytes = 0);

}  // namespace klang
