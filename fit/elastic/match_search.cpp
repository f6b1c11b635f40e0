#include "fit/elastic/match_search.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit {
namespace {

constexpr double kCentsPerLog = 1200.0 / 0.693147180559945309417;
constexpr double kLargestLogFactor = 0.42;  // of frequency: stiffness factor 0.43 to 2.3
constexpr double kStiffnessStd = 0.35, kPoissonStd = 0.12;
constexpr std::size_t kStrongPartials = 6, kLowLines = 10, kMostStarts = 8;

struct Start {
  Eigen::VectorXd x;
  double score = 0.0;
  double log_factor = 0.0, poisson = 0.0;
};

double prior_score(double log_factor, double poisson_offset) {
  return -0.5 * std::pow(2.0 * log_factor / kStiffnessStd, 2) - 0.5 * std::pow(poisson_offset / kPoissonStd, 2);
}

/// Rows of the loudest partials and of the lowest ones.
std::vector<std::size_t> telling_partials(const PartialTable& table) {
  std::vector<std::size_t> rows(table.partials.size());
  std::iota(rows.begin(), rows.end(), 0u);
  std::vector<std::size_t> chosen(rows.begin(),
                                  rows.begin() + static_cast<long>(std::min(rows.size(), kStrongPartials)));
  std::stable_sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) {
    return table.partials[a].amplitude.value_or(0.0) > table.partials[b].amplitude.value_or(0.0);
  });
  rows.resize(std::min(rows.size(), kStrongPartials));
  for (const std::size_t row : rows) {
    if (std::find(chosen.begin(), chosen.end(), row) == chosen.end()) chosen.push_back(row);
  }
  return chosen;
}

std::vector<double> candidate_factors(const std::vector<PartialTable>& tables, const SpecimenLines& lines) {
  std::vector<double> factors = {0.0};
  for (std::size_t s = 0; s < tables.size(); ++s) {
    for (const std::size_t row : telling_partials(tables[s])) {
      for (std::size_t k = 0, seen = 0; k < lines[s].size() && seen < kLowLines; ++k) {
        if (lines[s][k].visibility < 0.02) continue;
        ++seen;
        const double factor = std::log(tables[s].partials[row].frequency_hz / lines[s][k].frequency_hz);
        if (std::abs(factor) <= kLargestLogFactor) factors.push_back(factor);
      }
    }
  }
  std::sort(factors.begin(), factors.end());
  std::vector<double> kept;  // closer than 4 cents is the same start
  for (const double factor : factors) {
    if (kept.empty() || (factor - kept.back()) * kCentsPerLog > 4.0) kept.push_back(factor);
  }
  return kept;
}

}  // namespace

std::vector<Eigen::VectorXd> match_starts(const ParameterSpace& space, const SpectrumModels& models,
                                          const std::vector<PartialTable>& tables, const JointMatchOptions& options) {
  std::vector<double> poissons = {space.start_poissons_ratio()};
  if (space.ratio_is_free()) {
    for (const double value : {0.06, 0.14, 0.2, 0.26, 0.32, 0.38, 0.44}) {
      if (std::abs(value - poissons.front()) > 0.03) poissons.push_back(value);
    }
  }
  const MatchOptions match{25.0, std::max(100.0, options.gate_cents), 40.0};
  std::vector<Start> starts;
  for (const double poisson : poissons) {
    const Eigen::VectorXd x = space.with_poissons_ratio(space.start(), poisson);
    const SpecimenLines lines = lines_at(space, models, x, 3.0);
    const auto factors = space.can_shift() ? candidate_factors(tables, lines) : std::vector<double>{0.0};
    for (const double factor : factors) {
      Start start{space.shifted(x, factor), prior_score(factor, poisson - poissons.front()), factor, poisson};
      for (std::size_t s = 0; s < tables.size(); ++s) {
        start.score += match_partials(tables[s], lines[s], factor * kCentsPerLog, match, false).score;
      }
      starts.push_back(std::move(start));
    }
  }
  std::stable_sort(starts.begin(), starts.end(), [](const Start& a, const Start& b) { return a.score > b.score; });
  std::vector<Start> kept;  // different enough to end in different places
  for (const Start& start : starts) {
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const Start& other) {
      return std::abs(start.log_factor - other.log_factor) * kCentsPerLog < 30.0 &&
             std::abs(start.poisson - other.poisson) < 0.1;
    });
    if (is_new && (kept.empty() || start.score > kept.front().score - 12.0)) kept.push_back(start);
    if (kept.size() >= kMostStarts) break;
  }
  std::vector<Eigen::VectorXd> points;
  for (const Start& start : kept) points.push_back(start.x);
  // The guess itself too: a rough score may favour a body so much softer or stiffer that its modes lie dense there.
  const bool has_guess = std::any_of(kept.begin(), kept.end(), [&](const Start& start) {
    return std::abs(start.log_factor) * kCentsPerLog < 30.0 && std::abs(start.poisson - poissons.front()) < 0.1;
  });
  if (!has_guess) points.push_back(space.start());
  return points;
}

}  // namespace klang::fit
