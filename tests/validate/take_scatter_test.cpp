#include "validate/regression/detail/take_scatter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/foundation/base/random.hpp"
#include "validate/regression/detail/quantiles.hpp"

namespace klang::validate {
namespace {

// Tables of the distributions (Abramowitz and Stegun 1964, tables 26.2 and 26.10).
TEST(Quantiles, NormalAndStudentMatchTheTables) {
  EXPECT_LE(std::abs(detail::normal_two_sided(0.05) - 1.959963984540054), 1e-10);
  EXPECT_LE(std::abs(detail::normal_two_sided(1e-4) - 3.890591886413124), 1e-10);
  EXPECT_LE(std::abs(detail::student_two_sided(0.05, 3) - 3.182446305284263), 1e-9);
  EXPECT_LE(std::abs(detail::student_two_sided(0.01, 1) - 63.65674116287399), 1e-7);
  EXPECT_LE(std::abs(detail::student_two_sided(0.001, 10) - 4.586893858702636), 1e-8);
  EXPECT_LE(std::abs(detail::student_two_sided(0.02, 1e9) - detail::normal_two_sided(0.02)), 1e-9);
}

// Abramowitz and Stegun 1964, table 26.9.
TEST(Quantiles, FisherTailMatchesTheTable) {
  EXPECT_LE(std::abs(detail::fisher_tail(4.10, 2, 10) - 0.05), 1e-4);
  EXPECT_LE(std::abs(detail::fisher_tail(7.56, 2, 10) - 0.01), 1e-4);
  EXPECT_LE(std::abs(detail::fisher_tail(2.71, 5, 20) - 0.05), 1e-4);
}

/// Values of three takes about 0 with a standard deviation, the analyses' own being exact.
detail::Samples three(double std, RandomStream& random) {
  detail::Samples samples;
  for (std::size_t k = 0; k < 3; ++k) samples.add(std * random.normal(), 0.0, k);
  return samples;
}

TEST(TakeScatter, QuantitiesOfOneScatterShareTheirDegreesOfFreedom) {
  RandomStream random(3, 1);
  int shared = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<detail::Samples> quantities;
    for (int i = 0; i < 8; ++i) quantities.push_back(three(1.0, random));
    const detail::Scatter scatter = detail::moderated_scatter(quantities);
    shared += scatter.dof >= 10.0;
    for (const double s : scatter.std) {
      EXPECT_GE(s, 0.2);
      EXPECT_LE(s, 3.0);
    }
  }
  EXPECT_GE(shared, 30);
}

TEST(TakeScatter, AQuantityThatScattersTenTimesAsMuchKeepsItsOwnScatterOnFewDegrees) {
  RandomStream random(3, 2);
  std::vector<detail::Samples> quantities;
  for (int i = 0; i < 8; ++i) quantities.push_back(three(i == 0 ? 100.0 : i < 4 ? 1.0 : 0.01, random));
  const detail::Scatter scatter = detail::moderated_scatter(quantities);
  EXPECT_GE(scatter.std[0], 10.0 * scatter.std[7]);
  EXPECT_LE(scatter.dof, 8.0);
}

TEST(TakeScatter, WhatTheAnalysesExplainIsNoScatter) {
  RandomStream random(3, 3);
  std::vector<detail::Samples> quantities(20);
  for (auto& q : quantities)
    for (std::size_t k = 0; k < 3; ++k) q.add(random.normal(), 1.3, k);
  for (const double s : detail::moderated_scatter(quantities).std) EXPECT_LE(s, 1e-12);
}

TEST(TakeScatter, OneBadlyKnownQuantityDoesNotHideTheOthersScatter) {
  RandomStream random(3, 5);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<detail::Samples> quantities;
    for (int i = 0; i < 7; ++i) quantities.push_back(three(0.1, random));
    detail::Samples bad;
    for (std::size_t k = 0; k < 3; ++k) bad.add(0.1 * random.normal(), 1.0, k);
    quantities.push_back(bad);
    const detail::Scatter scatter = detail::moderated_scatter(quantities);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_GE(scatter.std[i], 0.01) << trial;
  }
}

// Found with 200 pairs of three takes: 12.01 +- 0.39, 11.90 +- 0.05 and 11.95 +- 0.06 per s of ten decays that scatter by 10 %.
TEST(TakeScatter, ValuesThatLieTogetherByLuckKeepAScatter) {
  RandomStream random(3, 6);
  std::vector<detail::Samples> quantities;
  for (int i = 0; i < 9; ++i) quantities.push_back(three(0.1, random));
  detail::Samples lucky;
  lucky.add(std::log(12.0148), 0.0324, 0);
  lucky.add(std::log(11.9047), 0.0040, 1);
  lucky.add(std::log(11.9458), 0.0047, 2);
  quantities.push_back(lucky);
  EXPECT_GE(detail::moderated_scatter(quantities).std[9], 0.02);
}

TEST(TakeScatter, TakesThatMoveAsAWholeAreSeenAndIndependentOnesAreNot) {
  RandomStream random(3, 4);
  int seen = 0, invented = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<detail::Samples> together(5), alone(5);
    for (std::size_t k = 0; k < 3; ++k) {
      const double common = random.normal();
      for (auto& q : together) q.add(common + 0.2 * random.normal(), 0.0, k);
      for (auto& q : alone) q.add(random.normal(), 0.0, k);
    }
    seen += detail::common_scatter(together, 3) > 0.0;
    invented += detail::common_scatter(alone, 3) > 0.0;
  }
  EXPECT_GE(seen, 165);    // in one of nine trials the three shifts lie too near each other: 178, and three deviations
  EXPECT_LE(invented, 2);  // 0.2 % of 200 and three deviations
}
}  // namespace
}  // namespace klang::validate
