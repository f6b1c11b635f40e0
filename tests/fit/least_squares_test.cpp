// The one call of Ceres: silent whatever fails, and stopped when asked.
#include "fit/least_squares/least_squares.hpp"

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

namespace klang::fit {
namespace {

/// x - 3, which cannot be evaluated beyond a wall.
class Walled final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit Walled(double wall) : wall_(wall) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = parameters[0][0] - 3.0;
    if (jacobians && jacobians[0]) jacobians[0][0] = 1.0;
    return parameters[0][0] < wall_;
  }

 private:
  double wall_;
};

class Stopped final : public Monitor {
 public:
  bool stop_requested() const override { return true; }
};

TEST(LeastSquares, FailingFitsSayNothingOnEitherStream) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const double wall : {-1.0, 1e-9, std::nan("")}) {
    double x = 0.0;
    ceres::Problem problem;
    problem.AddResidualBlock(new Walled(wall), nullptr, &x);
    ceres::Solver::Options options;
    options.logging_type = ceres::PER_MINIMIZER_ITERATION;
    options.minimizer_progress_to_stdout = true;
    least_squares(options, problem);
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(LeastSquares, FindsTheMinimum) {
  double x = 0.0;
  ceres::Problem problem;
  problem.AddResidualBlock(new Walled(10.0), nullptr, &x);
  EXPECT_TRUE(least_squares({}, problem).IsSolutionUsable());
  EXPECT_LE(std::abs(x - 3.0), 1e-8);
}

TEST(LeastSquares, AStoppedFitIsNotUsable) {
  double x = 0.0;
  ceres::Problem problem;
  problem.AddResidualBlock(new Walled(10.0), nullptr, &x);
  EXPECT_FALSE(least_squares({}, problem, Stopped()).IsSolutionUsable());
}

}  // namespace
}  // namespace klang::fit
