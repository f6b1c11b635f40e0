#include "fit/least_squares/least_squares.hpp"

#include <ceres/iteration_callback.h>
#include <glog/logging.h>

namespace klang::fit {
namespace {

class StopWhenAsked final : public ceres::IterationCallback {
 public:
  explicit StopWhenAsked(const Monitor& monitor) : monitor_(monitor) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return monitor_.stop_requested() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }

 private:
  const Monitor& monitor_;
};

bool quiet_glog() {
  FLAGS_minloglevel = google::GLOG_FATAL;
  return true;
}

}  // namespace

ceres::Solver::Summary least_squares(ceres::Solver::Options options, ceres::Problem& problem, const Monitor& monitor) {
  [[maybe_unused]] static const bool quiet = quiet_glog();
  StopWhenAsked stop(monitor);
  options.callbacks = {&stop};
  options.logging_type = ceres::SILENT;
  options.minimizer_progress_to_stdout = false;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary;
}

}  // namespace klang::fit
