#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"
#include "validate/claim/order_estimate.hpp"
#include "validate/studies/study.hpp"

namespace klang::validate {
namespace {

const std::vector<double> kSteps = {0.08, 0.05, 0.03, 0.02, 0.0125};

std::vector<double> power_law(double order, double factor) {
  std::vector<double> error;
  for (const double h : kSteps) error.push_back(factor * std::pow(h, order));
  return error;
}

TEST(ObservedOrder, IsExactForAPowerLawWhateverTheRefinementFactors) {
  for (const double order : {0.5, 1.0, 2.0, 3.7, 4.0}) {
    const OrderEstimate found = estimate_order(kSteps, power_law(order, 7.3), Convergence::kAlgebraic);
    ASSERT_EQ(found.status, OrderStatus::kEstimated);
    EXPECT_LE(std::abs(*found.observed_order - order), 1e-12);
    EXPECT_LE((*found.ci95)[1] - (*found.ci95)[0], 1e-10);
    EXPECT_EQ(found.n_used, 5);
    EXPECT_EQ(found.asymptotic, true);
    EXPECT_FALSE(found.pairwise[0]);
    for (std::size_t i = 1; i < 5; ++i) EXPECT_LE(std::abs(*found.pairwise[i] - order), 1e-12);
  }
}

TEST(ObservedOrder, IsTheRateOfAGeometricSequence) {
  std::vector<double> n, error;
  for (int i = 2; i < 9; ++i) n.push_back(i), error.push_back(3.0 * std::exp(-0.69 * i));
  const OrderEstimate found = estimate_order(n, error, Convergence::kGeometric);
  EXPECT_LE(std::abs(*found.observed_order - 0.69), 1e-12);
}

TEST(ObservedOrder, LeavesOutLevelsAtTheFloorAndAllAfterThem) {
  std::vector<double> error = power_law(4.0, 1.0);
  error[3] = 3e-9, error[4] = 2e-7;  // round-off jumps about
  const OrderEstimate found = estimate_order(kSteps, error, Convergence::kAlgebraic, 1e-8);
  EXPECT_EQ(found.excluded, (std::vector<std::string>{"", "", "", "floor", "floor"}));
  EXPECT_LE(std::abs(*found.observed_order - 4.0), 1e-12);
  EXPECT_EQ(found.n_used, 3);
}

TEST(ObservedOrder, DropsPreAsymptoticLevelsOnlyWhileFourAreLeft) {
  std::vector<double> error = power_law(2.0, 1.0);
  error[0] *= 0.2;  // the coarsest level is by chance too good
  const OrderEstimate found = estimate_order(kSteps, error, Convergence::kAlgebraic);
  EXPECT_EQ(found.excluded[0], "pre-asymptotic");
  EXPECT_LE(std::abs(*found.observed_order - 2.0), 1e-12);
  const std::vector<double> four(kSteps.begin(), kSteps.end() - 1), four_errors(error.begin(), error.end() - 1);
  const OrderEstimate kept = estimate_order(four, four_errors, Convergence::kAlgebraic);
  EXPECT_EQ(kept.n_used, 4);
  EXPECT_GE(std::abs(*kept.observed_order - 2.0), 0.3) << "the bad level is in and is seen";
}

TEST(ObservedOrder, AZeroOrInfiniteErrorIsNoLevel) {
  std::vector<double> error = power_law(2.0, 1.0);
  error[1] = 0.0, error[2] = std::nan("");
  const OrderEstimate found = estimate_order(kSteps, error, Convergence::kAlgebraic);
  EXPECT_EQ(found.n_used, 3);
  EXPECT_EQ(found.excluded[1], "no error");
  EXPECT_EQ(estimate_order({0.1, 0.05}, {0.0, 1e-3}, Convergence::kAlgebraic).status, OrderStatus::kTooFewLevels);
}

// Normal noise of 5 % on every error: the 95 % band of five levels (Student's t, 3 degrees of freedom) must hold the true
// order in 95 % of the cases; 2000 seeds leave a standard deviation of 0.5 %.
TEST(ObservedOrder, BandHoldsTheTrueOrderInNineteenOfTwentyNoisyStudies) {
  int n_inside = 0;
  constexpr int kSeeds = 2000;
  for (int seed = 0; seed < kSeeds; ++seed) {
    RandomStream random(7, static_cast<std::uint64_t>(seed));
    std::vector<double> error = power_law(2.0, 1.0);
    error.pop_back();  // four levels: nothing is ever trimmed
    for (double& e : error) e *= std::exp(0.05 * random.normal());
    const std::vector<double> four(kSteps.begin(), kSteps.end() - 1);
    const OrderEstimate found = estimate_order(four, error, Convergence::kAlgebraic);
    n_inside += (*found.ci95)[0] <= 2.0 && 2.0 <= (*found.ci95)[1];
  }
  const double share = static_cast<double>(n_inside) / kSeeds;
  EXPECT_LE(std::abs(share - 0.95), 0.02) << share;
}

// Celik et al. 2008, J. Fluids Eng. 130, 078001, Table 1: three examples with their printed digits.
TEST(GridConvergenceIndex, ReproducesCeliksTable) {
  struct Row {
    std::array<double, 3> r, value;
    double order, extrapolated, gci_percent;
  };
  const std::vector<Row> rows = {{{1.0, 1.5, 1.5 * 4.0 / 3.0}, {6.063, 5.972, 5.863}, 1.53, 6.1685, 2.2},
                                 {{1.0, 2.0, 2.0 * 2.143}, {10.7880, 10.7250, 10.6050}, 0.75, 10.8801, 1.1},
                                 {{1.0, 2.0, 2.0 * 2.143}, {6.0042, 5.9624, 6.0909}, 1.51, 6.0269, 0.5}};
  for (const Row& row : rows) {
    const auto gci = grid_convergence(row.r, row.value);
    ASSERT_TRUE(gci);
    EXPECT_LE(std::abs(gci->order - row.order), 0.006);
    EXPECT_LE(std::abs(gci->extrapolated - row.extrapolated), 1.5e-3);
    EXPECT_LE(std::abs(100.0 * gci->gci_fine - row.gci_percent), 0.06);
    EXPECT_EQ(gci->oscillating, row.order == 1.51);
  }
}

// Roache's example of a supersonic inlet (ratio 2 twice).
TEST(GridConvergenceIndex, ReproducesThePressureRecoveryExample) {
  const auto gci = grid_convergence({1.0, 2.0, 4.0}, {0.97050, 0.96854, 0.96178});
  ASSERT_TRUE(gci);
  EXPECT_LE(std::abs(gci->order - 1.786170), 1e-5);
  EXPECT_LE(std::abs(gci->extrapolated - 0.971300), 1e-6);
  EXPECT_LE(std::abs(gci->gci_fine - 0.00103083), 1e-8);
  EXPECT_LE(std::abs(gci->gci_coarse - 0.00356249), 1e-8);
  EXPECT_LE(std::abs(gci->asymptotic_ratio - 1.0 / 0.997980), 2e-5);  // the example prints the inverse
}

TEST(GridConvergenceIndex, DivergingOrConstantValuesHaveNone) {
  EXPECT_FALSE(grid_convergence({1.0, 2.0, 4.0}, {3.0, 2.0, 1.9}));
  EXPECT_FALSE(grid_convergence({1.0, 2.0, 4.0}, {3.0, 3.0, 3.0}));
}

TEST(Richardson, FindsLimitAndOrderOfASequenceWithoutAnExactReference) {
  std::vector<double> value;
  for (const double h : kSteps) value.push_back(5.25 - 3.0 * std::pow(h, 2.4));
  const auto found = richardson_limit(kSteps, value);
  ASSERT_TRUE(found);
  EXPECT_LE(std::abs(found->limit - 5.25), 1e-9);
  EXPECT_LE(std::abs(found->order - 2.4), 1e-6);
  EXPECT_FALSE(richardson_limit({0.1, 0.05}, {1.0, 2.0}));
}

Series series_of(const std::vector<double>& error) {
  Series series;
  series.id = "s";
  series.expected_order = 2.0;
  series.order_tolerance = 0.2;
  series.error_tolerance = 1.0;
  for (std::size_t i = 0; i < error.size(); ++i) {
    Level level;
    level.h_m = kSteps[i];
    level.error = error[i];
    series.levels.push_back(level);
  }
  return series;
}

TEST(StudyVerdict, NeedsTheOrderAndTheError) {
  Series good = series_of(power_law(2.1, 1.0));
  judge(good);
  EXPECT_TRUE(good.passed) << good.verdict;
  Series slow = series_of(power_law(1.7, 1.0));
  judge(slow);
  EXPECT_FALSE(slow.passed);
  Series fast = series_of(power_law(3.0, 1.0));
  judge(fast);
  EXPECT_FALSE(fast.passed) << "the band has two sides";
  fast.higher_is_fine = true;
  judge(fast);
  EXPECT_TRUE(fast.passed);
  Series large = series_of(power_law(2.0, 1.0));
  large.error_tolerance = 1e-5;
  judge(large);
  EXPECT_FALSE(large.passed);
  Series broken = series_of(power_law(2.0, 1.0));
  broken.levels.back().error = std::nan("");
  judge(broken);
  EXPECT_FALSE(broken.passed) << "a NaN at the finest level does not pass";
}

TEST(StudyVerdict, RoundOffIsJudgedByItsLargestError) {
  Series series = series_of({1e-15, 5e-15, 2e-15});
  series.kind = Convergence::kRoundOff;
  series.error_tolerance = 6e-15;
  judge(series);
  EXPECT_TRUE(series.passed);
  series.error_tolerance = 4e-15;
  judge(series);
  EXPECT_FALSE(series.passed);
  series.levels[0].error = std::nan("");
  series.error_tolerance = 1.0;
  judge(series);
  EXPECT_FALSE(series.passed);
}

}  // namespace
}  // namespace klang::validate
