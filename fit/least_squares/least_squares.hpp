#pragma once
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "core/foundation/base/monitor.hpp"

namespace klang::fit {

/// ceres::Solve as all of fit calls it: on one thread, without a word on standard output or error (Ceres tells each failed step
/// to glog, which writes to standard error; from the first call on, glog says nothing but what ends the process), and stopped
/// between two steps when the monitor says so. A fit that was stopped is not usable; the caller's next throw_if_stopped()
/// ends it.
/// @param options  logging, threads and callbacks are set here
ceres::Solver::Summary least_squares(ceres::Solver::Options options, ceres::Problem& problem,
                                     const Monitor& monitor = silent_monitor());

}  // namespace klang::fit
