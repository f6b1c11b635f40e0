#include <gtest/gtest.h>

#include <cmath>

#include "core/base/errors.hpp"
#include "core/base/parallel.hpp"
#include "validate/study.hpp"

namespace klang::validate {
namespace {

void expect_passed(const Study& study) {
  EXPECT_EQ(study.status, StudyStatus::kDone);
  EXPECT_FALSE(study.series.empty());
  for (const Series& series : study.series) {
    if (series.counts) {
      EXPECT_TRUE(series.passed) << series.id << ": " << series.verdict;
    }
  }
  for (const Claim& claim : study.claims) EXPECT_TRUE(claim.passed) << claim.name << " " << claim.measured;
}

TEST(FemStudy, BarAndLinearBallReachTheirOrders) {
  expect_passed(run_study("fem", {.levels = 0, .only = "bar-p2", .fields = false}));
  const Study ball = run_study("fem", {.levels = 3, .only = "ball-p1", .fields = true});
  expect_passed(ball);
  ASSERT_EQ(ball.fields.surfaces.size(), 1U);
  const SurfaceField& map = ball.fields.surfaces[0];
  EXPECT_EQ(map.values.size(), map.vertices_m.rows());
  EXPECT_GE(map.values.minCoeff(), 0.0);
  EXPECT_GE(map.values.maxCoeff(), 1e-3);
  EXPECT_LE(map.values.maxCoeff(), 0.1);
  for (Eigen::Index i = 0; i < map.vertices_m.rows(); ++i) EXPECT_LE(std::abs(map.vertices_m.row(i).norm() - 0.03), 1e-12);
}

TEST(FemStudy, CurvedQuadraticBallApproachesOrderFourOnThreeLevels) {
  const Study ball = run_study("fem", {.levels = 3, .only = "ball-p2", .fields = false});
  expect_passed(ball);
  EXPECT_GE(*ball.series[0].order.pairwise[2], *ball.series[0].order.pairwise[1]);
}

TEST(SynthesisStudy, RecurrenceIsAtRoundOffAndSampledForcesConvergeAtOrderTwo) {
  expect_passed(run_study("synthesis", {.levels = 5, .only = {}}));
}

TEST(Studies, GiveTheSameNumbersOnAnyNumberOfThreads) {
  const auto levels = [] { return levels_csv(run_study("fem", {.levels = 3, .only = "bar-p2", .fields = false})); };
  const int before = thread_count();
  set_thread_count(1);
  const std::string one = levels();
  set_thread_count(2);
  EXPECT_EQ(levels(), one);
  set_thread_count(before);
}

TEST(Studies, RefuseUnknownNamesAndStopWhenAsked) {
  EXPECT_THROW(run_study("fluid"), InputError);
  EXPECT_THROW(run_study("fem", {.levels = 2, .only = {}}), InputError);
  EXPECT_THROW(run_study("fem", {.only = "nothing"}), InputError);
  struct Stopper : Monitor {
    bool stop_requested() const override { return true; }
  } stopper;
  for (const std::string& name : study_names()) EXPECT_THROW(run_study(name, {}, stopper), Interrupted) << name;
}

}  // namespace
}  // namespace klang::validate
