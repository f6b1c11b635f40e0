#include "validate/regression/detail/partial_pairs.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::validate::detail {
namespace {

constexpr double kFurthestCents = 50.0, kLevelScaleDb = 30.0;

double level(const fit::Partial& p) { return 20.0 * std::log10(std::max(p.amplitude.value_or(0.0), 1e-15)); }

double loudest(const std::vector<fit::Partial>& partials) {
  double highest = -300.0;
  for (const fit::Partial& p : partials) highest = std::max(highest, level(p));
  return highest;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> paired(const std::vector<fit::Partial>& a,
                                                        const std::vector<fit::Partial>& b, double gain_db) {
  const auto n = static_cast<Eigen::Index>(a.size()), m = static_cast<Eigen::Index>(b.size());
  Eigen::MatrixXd cost(n + 1, m + 1);  // least cost of the first i and j
  enum class Step : unsigned char { kPair, kSkipA, kSkipB };
  std::vector<Step> step(static_cast<std::size_t>((n + 1) * (m + 1)), Step::kSkipA);
  const auto at = [&](Eigen::Index i, Eigen::Index j) -> Step& {
    return step[static_cast<std::size_t>(i * (m + 1) + j)];
  };
  for (Eigen::Index i = 0; i <= n; ++i) {
    for (Eigen::Index j = 0; j <= m; ++j) {
      if (i == 0 || j == 0) {
        cost(i, j) = static_cast<double>(i + j);
        at(i, j) = i == 0 ? Step::kSkipB : Step::kSkipA;
        continue;
      }
      cost(i, j) = cost(i - 1, j) + 1.0;
      if (cost(i, j - 1) + 1.0 < cost(i, j)) {
        cost(i, j) = cost(i, j - 1) + 1.0;
        at(i, j) = Step::kSkipB;
      }
      const fit::Partial &p = a[static_cast<std::size_t>(i - 1)], &q = b[static_cast<std::size_t>(j - 1)];
      const double apart = cents(q.frequency_hz, p.frequency_hz) / kFurthestCents;
      const double louder = (level(q) - level(p) - gain_db) / kLevelScaleDb;
      const double together = cost(i - 1, j - 1) + apart * apart + louder * louder;
      if (std::abs(apart) <= 1.0 && together < cost(i, j)) {
        cost(i, j) = together;
        at(i, j) = Step::kPair;
      }
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (Eigen::Index i = n, j = m; i > 0 || j > 0;) {
    switch (at(i, j)) {
      case Step::kPair:
        --i, --j;
        pairs.emplace_back(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
        break;
      case Step::kSkipA:
        --i;
        break;
      case Step::kSkipB:
        --j;
        break;
    }
  }
  std::reverse(pairs.begin(), pairs.end());
  return pairs;
}

Gain gain_between(const std::vector<fit::Partial>& a, const std::vector<fit::Partial>& b,
                  const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
  if (pairs.empty()) return {};
  std::vector<double> differences;
  for (const auto& [i, j] : pairs) differences.push_back(level(b[j]) - level(a[i]));
  const double centre = median(differences);
  constexpr double kOutlierDb = 6.0, kOwnScatterDb = 0.2;  // a single partial shall not decide alone
  double weights = 0.0, sum = 0.0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (std::abs(differences[k] - centre) > kOutlierDb) continue;
    const auto& p = a[pairs[k].first];
    const auto& q = b[pairs[k].second];
    constexpr double kDbPerNeper = 8.685889638065037;
    const double std_p = kDbPerNeper * p.amplitude_std.value_or(0.0) / std::max(p.amplitude.value_or(0.0), 1e-15);
    const double std_q = kDbPerNeper * q.amplitude_std.value_or(0.0) / std::max(q.amplitude.value_or(0.0), 1e-15);
    const double weight = 1.0 / (std_p * std_p + std_q * std_q + kOwnScatterDb * kOwnScatterDb);
    weights += weight;
    sum += weight * differences[k];
  }
  return {sum / weights, 1.0 / std::sqrt(weights)};
}

Pairing pairing(const std::vector<fit::Partial>& a, const std::vector<fit::Partial>& b) {
  Pairing result;
  result.gain.db = loudest(b) - loudest(a);
  for (int pass = 0; pass < 3; ++pass) {
    result.pairs = paired(a, b, result.gain.db);
    if (result.pairs.empty()) break;
    result.gain = gain_between(a, b, result.pairs);
  }
  return result;
}

}  // namespace klang::validate::detail
