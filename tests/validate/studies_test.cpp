#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/bem/radiating_surface.hpp"
#include "validate/studies/study.hpp"
#include "validate/studies/study_document.hpp"
#include "validate/studies/two_medium.hpp"

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
  for (Eigen::Index i = 0; i < map.vertices_m.rows(); ++i)
    EXPECT_LE(std::abs(map.vertices_m.row(i).norm() - 0.03), 1e-12);
}

TEST(FemStudy, CurvedQuadraticBallApproachesOrderFourOnThreeLevels) {
  const Study ball = run_study("fem", {.levels = 3, .only = "ball-p2", .fields = false});
  expect_passed(ball);
  EXPECT_GE(*ball.series[0].order.pairwise[2], *ball.series[0].order.pairwise[1]);
}

TEST(SynthesisStudy, RecurrenceIsAtRoundOffAndSampledForcesConvergeAtOrderTwo) {
  expect_passed(run_study("synthesis", {.levels = 5, .only = {}}));
}

// tests/reference/radiation.json: truncation_offcentre_monopole (the study's claims hold its fifteen numbers).
TEST(MultipoleStudy, ReproducesTheTruncationTableAndTheRateOfTheSeries) {
  const Study study = run_study("multipole");
  expect_passed(study);
  EXPECT_EQ(study.claims.size(), 15U);
  const SliceField& slice = study.fields.slices.at(0);
  EXPECT_EQ(slice.values.rows(), 512);
  EXPECT_TRUE(std::isnan(slice.values(256, 256))) << "inside the body";
  // In the corner of the plane the field is that of the closed form: 1 / (4 pi R).
  const Eigen::Vector3d corner = slice.corner_m, source = 0.1 * Eigen::Vector3d(0.6, 0.0, 0.8);
  EXPECT_LE(std::abs(slice.values(0, 0) * 4.0 * M_PI * (corner - source).norm() - 1.0), 1e-12);
  // The paper's order makes lobes where a monopole has none; order 14 does not.
  const auto spread_db = [](const BalloonField& b) {
    return 20.0 * std::log10(b.magnitude.maxCoeff() / b.magnitude.minCoeff());
  };
  EXPECT_GE(spread_db(study.fields.balloons.at(0)), 10.0);
  EXPECT_LE(spread_db(study.fields.balloons.at(1)), 1.0);
}

TEST(LiquidColumnStudy, PressureConvergesAtOrderTwoAtSixteenPlaces) {
  const Study study = run_study("liquid-column", {.levels = 4, .only = {}, .fields = false});
  expect_passed(study);
  for (const Level& level : study.series[0].levels) EXPECT_EQ(level.points.size(), 16U);
}

TEST(LiquidWaveStudy, FrequencyAndLossOfASmallWaveAreWithinTheirBars) {
  const Study study = run_study("liquid-wave", {.levels = 3, .only = {}, .fields = false});
  expect_passed(study);
  ASSERT_EQ(study.series.size(), 1U);
  for (std::size_t i = 1; i < 3; ++i) EXPECT_LE(study.series[0].levels[i].error, study.series[0].levels[i - 1].error);
  EXPECT_EQ(study.claims.size(), 2U) << "frequency and loss at 32 cells per wavelength";
}

TEST(LiquidDamStudy, FrontIsTheExperimentsWithinThreePercentInTheMean) {
  const Study study = run_study("liquid-dam", {.levels = 3, .only = {}, .fields = false});
  expect_passed(study);
  EXPECT_LE(study.series.at(0).levels.back().error, 0.03);
}

TEST(LiquidAdvectionStudy, ZalesaksDiscKeepsItsAreaWithoutAnyShiftAndMostOfItsShape) {
  const Study study = run_study("liquid-advection", {.levels = 3, .only = "zalesak", .fields = false});
  expect_passed(study);
  const std::vector<Level>& levels = study.series.at(0).levels;
  ASSERT_EQ(levels.size(), 3U);
  EXPECT_LE(levels[2].error, 0.003);
  for (std::size_t i = 1; i < 3; ++i) EXPECT_LE(levels[i].error, levels[i - 1].error);
  EXPECT_LE(levels[2].shape_error.value_or(1.0), 0.008)
      << "0.045 without what particles carry, 0.011 when the grid taught it them";
  EXPECT_EQ(study.claims.size(), 1U) << "the shape at the finest cells";
  EXPECT_LE(levels[2].shape_error.value_or(1.0), levels[0].shape_error.value_or(0.0));
}

TEST(SceneStudy, StepsMeshAndSweepsReachTheirOrdersAndBreakageDoesNotDependOnTheStep) {
  const Study study = run_study("scene", {.levels = 3, .only = {}, .fields = false});
  expect_passed(study);
  ASSERT_EQ(study.series.size(), 7U);
  EXPECT_EQ(study.series[0].id, "mesh-bar");
  EXPECT_EQ(study.claims.size(), 4U) << "time of the first break, twice, pieces, and the column after mixing";
}

TEST(BemStudy, OrderTwoAlsoAtTheInteriorResonances) {
  for (const char* id : {"pulsating-kapi", "dipole-ka4.4934"}) {
    const Study study = run_study("bem", {.levels = 3, .only = id, .fields = false});
    expect_passed(study);
    EXPECT_EQ(study.series.size(), 1U);
  }
}

TEST(BemStudy, FieldsAgreeWithTheExactPressure) {
  const Study study = run_study("bem", {.levels = 3, .only = "quadrupole", .fields = true});
  ASSERT_EQ(study.fields.slices.size(), 2U);
  const SliceField &pressure = study.fields.slices[0], &error = study.fields.slices[1];
  double largest = 0.0, worst = 0.0;
  for (Eigen::Index i = 0; i < pressure.values.size(); ++i) {
    if (std::isnan(pressure.values(i))) continue;
    largest = std::max(largest, pressure.values(i));
    worst = std::max(worst, error.values(i));
  }
  EXPECT_LE(worst, 0.01 * largest);
  EXPECT_GE(worst, 1e-5 * largest) << "an error of nothing would be no comparison";
  EXPECT_LE(study.fields.surfaces.at(0).values.maxCoeff(), 0.03);
}

// tests/reference/fluid.json: concentric_two_way_exact.
TEST(TwoMedia, SeriesOfTheBallIsTheReferenceAndOneWayLacksWhatItSays) {
  const struct {
    double frequency_hz;
    std::complex<double> exact, one_way;
  } rows[] = {
      {500, {2.8036253487840175e-05, -0.00017229111284443492}, {2.803643943774248e-05, -0.00017229043606423864}},
      {1500, {-8.46648322272779e-05, 7.732643034122478e-05}, {-8.466513133651332e-05, 7.732374532454078e-05}},
      {4000, {5.469712482068791e-05, 1.5735696951745025e-05}, {5.4694810712449445e-05, 1.5739500460791365e-05}}};
  for (const auto& row : rows) {
    const LiquidBall ball{0.05, row.frequency_hz, 0.0, {1000.0, 1497.0}, {}};
    EXPECT_LE(std::abs(ball_pressure(ball, Coupling::kTwoWay, {0.3, 0, 0.4}) - row.exact) / std::abs(row.exact), 1e-10);
    EXPECT_LE(std::abs(ball_pressure(ball, Coupling::kOneWay, {0, 0.5, 0}) - row.one_way) / std::abs(row.one_way),
              1e-10);
  }
}

TEST(TwoMedia, ElementsInTurnsComeToTheTwoWaySeriesOfAnEccentricBubble) {
  mesh::SurfaceMesh sphere = acoustics::geodesic_sphere(0.05, 6);
  bubble::BoundaryMesh mesh{sphere, std::vector<int>(static_cast<std::size_t>(sphere.triangles.rows()), 0), "ball"};
  const bubble::LiquidBoundary boundary(mesh);
  const std::vector<Eigen::Vector3d> points = {{0.2, 0, 0}, {0, 0, 0.3}, {0.1, -0.1, -0.2}};
  const LiquidBall ball{0.05, 4000.0, 0.02, {1000.0, 1497.0}, {}};
  const TwoWayResult result = two_way_pressure(boundary, 4000.0, {0, 0, 0.02}, points, {8});
  EXPECT_TRUE(result.converged);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::complex<double> exact = ball_pressure(ball, Coupling::kTwoWay, points[i]);
    EXPECT_LE(std::abs(result.pressure[i] / result.liquid.source_strength - exact) / std::abs(exact), 0.02);
  }
}

TEST(DualDomainStudy, ErrorOfPassOneFallsAndRandomSetsHaveIntervals) {
  const Study study = run_study("dual-domain", {.levels = 3, .only = "fluid-", .fields = false});
  ASSERT_GE(study.series.size(), 2U);
  const Series& flat = study.series[0];
  for (std::size_t i = 1; i < flat.levels.size(); ++i) EXPECT_LE(flat.levels[i].error, flat.levels[i - 1].error);
  const Series& printed = study.series[1];
  for (const Level& level : printed.levels) {
    ASSERT_TRUE(level.error_ci95.has_value());
    EXPECT_LT((*level.error_ci95)[0], level.error);
    EXPECT_GT((*level.error_ci95)[1], level.error);
  }
}

TEST(Studies, GiveTheSameNumbersOnAnyNumberOfThreads) {
  const auto levels = [] {
    return levels_csv(run_study("fem", {.levels = 3, .only = "bar-p2", .fields = false})) +
           levels_csv(run_study("bem", {.levels = 3, .only = "dipole", .fields = false}));
  };
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
