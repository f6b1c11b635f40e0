#include "fit/elastic/matching.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/random.hpp"

namespace klang::fit {
namespace {

// Free tube, 0.505 m (tests/reference/chimes.json: tubes[0].full_spectrum_3d): bending pairs and torsion, then n = 2 pairs.
const std::vector<std::pair<double, int>> kTube = {{587.883, 2},  {1575.116, 2}, {2969.531, 2}, {3054.663, 1},
                                                   {4541.236, 2}, {4542.491, 2}, {4563.309, 2}, {4614.710, 2},
                                                   {4681.101, 2}, {4731.423, 2}, {4952.867, 2}, {4980.113, 1},
                                                   {5315.595, 2}, {5842.382, 2}, {6109.326, 1}};

std::vector<ModelLine> tube_lines() {
  std::vector<double> f, v;
  for (const auto& [frequency, multiplicity] : kTube) {
    const bool torsion = multiplicity == 1;
    for (int i = 0; i < multiplicity; ++i) {
      f.push_back(frequency);
      v.push_back(torsion ? 0.0 : 1.0);
    }
  }
  const auto n = static_cast<Eigen::Index>(f.size());
  return model_lines(Eigen::Map<Eigen::VectorXd>(f.data(), n), Eigen::Map<Eigen::VectorXd>(v.data(), n), 0.1);
}

PartialTable table_of(const std::vector<double>& frequencies, const std::vector<double>& amplitudes = {}) {
  PartialTable table;
  for (std::size_t i = 0; i < frequencies.size(); ++i) {
    Partial partial;
    partial.frequency_hz = frequencies[i];
    if (!amplitudes.empty()) partial.amplitude = amplitudes[i];
    table.partials.push_back(partial);
  }
  return table;
}

TEST(Assignment, EqualsTheBestOfAllPermutations) {
  RandomStream random(4, 1);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 1 + static_cast<int>(random.below(5)), m = n + static_cast<int>(random.below(3));
    Eigen::MatrixXd cost(n, m);
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < m; ++j) cost(i, j) = random.uniform(-3.0, 3.0);
    }
    std::vector<int> order(static_cast<std::size_t>(m));
    std::iota(order.begin(), order.end(), 0);
    double best = 1e9;
    do {
      double sum = 0.0;
      for (int i = 0; i < n; ++i) sum += cost(i, order[static_cast<std::size_t>(i)]);
      best = std::min(best, sum);
    } while (std::next_permutation(order.begin(), order.end()));
    const auto column = least_cost_assignment(cost);
    double sum = 0.0;
    std::vector<char> used(static_cast<std::size_t>(m), 0);
    for (int i = 0; i < n; ++i) {
      sum += cost(i, column[static_cast<std::size_t>(i)]);
      EXPECT_FALSE(used[static_cast<std::size_t>(column[static_cast<std::size_t>(i)])]++);
    }
    EXPECT_NEAR(sum, best, 1e-12);
  }
}

TEST(Lines, EqualFrequenciesBecomeOneLine) {
  const auto lines = tube_lines();
  ASSERT_EQ(lines.size(), kTube.size());
  EXPECT_EQ(lines[0].modes, (std::vector<int>{0, 1}));
  EXPECT_EQ(lines[3].modes, (std::vector<int>{6}));
  EXPECT_NEAR(lines[2].frequency_hz, 2969.531, 1e-9);
}

TEST(Matching, BendingPartialsFindTheirPairsAndAStrangerStaysAlone) {
  // 10 cents flat; 2000 Hz is a rattle; the third bending pair is split by 6 Hz; the torsion is not heard.
  const double flat = std::exp2(-10.0 / 1200.0);
  const auto match =
      match_partials(table_of({587.883 * flat, 1575.116 * flat, 2000.0, 2966.5 * flat, 2972.5 * flat, 4681.101 * flat}),
                     tube_lines(), 0.0, {25.0, 60.0, 40.0});
  ASSERT_EQ(match.line_of_partial.size(), 6u);
  EXPECT_EQ(match.line_of_partial[0], 0);
  EXPECT_EQ(match.line_of_partial[1], 1);
  EXPECT_EQ(match.line_of_partial[2], -1);
  EXPECT_EQ(match.line_of_partial[3], 2);
  EXPECT_EQ(match.line_of_partial[4], 2);
  EXPECT_EQ(match.n_matched, 5);
}

TEST(Matching, RightShiftScoresAboveEveryOtherWithinAFifth) {
  const double factor = std::exp2(-260.0 / 1200.0);  // stiffness 26 % lower than the guess
  const auto table = table_of({587.9 * factor, 1575.0 * factor, 2969.0 * factor, 4681.0 * factor});
  double best = -1e9, at = 0.0;
  for (double shift = -700.0; shift <= 700.0; shift += 5.0) {
    const double score = match_partials(table, tube_lines(), shift, {25.0, 100.0, 40.0}, false).score;
    if (score > best) best = score, at = shift;
  }
  EXPECT_NEAR(at, -260.0, 10.0);
}

TEST(Matching, OnePartialTakesTheLowestLine) {
  double best = -1e9;
  int line = -1;
  for (double shift = -700.0; shift <= 700.0; shift += 5.0) {
    const auto match = match_partials(table_of({500.0}), tube_lines(), shift, {25.0, 100.0, 40.0});
    if (match.score > best) best = match.score, line = match.line_of_partial[0];
  }
  EXPECT_EQ(line, 0);
}

TEST(Matching, WeakPartialsNeedABetterFitThanStrongOnes) {
  const auto score = [&](double amplitude) {
    return match_partials(table_of({600.0, 1575.1}, {amplitude, 1.0}), tube_lines(), 0.0, {25.0, 100.0, 40.0}).score;
  };
  EXPECT_GT(score(1.0), score(1e-3));
}

TEST(Matching, EmptyTableMatchesNothing) {
  EXPECT_EQ(match_partials({}, tube_lines(), 0.0, {}).n_matched, 0);
  EXPECT_EQ(match_partials(table_of({100.0}), {}, 0.0, {}).line_of_partial, std::vector<int>{-1});
}

}  // namespace
}  // namespace klang::fit
