#include "fit/elastic/joint_match.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "fit/elastic/identifiability.hpp"

namespace klang::fit {
namespace {

constexpr double kCentsPerLog = 1200.0 / 0.693147180559945309417;
constexpr double kLargestLogFactor = 0.42;  // of frequency: stiffness factor 0.43 to 2.3
constexpr double kStiffnessPriorStd = 0.35;
constexpr double kPoissonPriorStd = 0.12;
constexpr double kClusterCents = 3.0;
constexpr std::size_t kStrongPartials = 6, kLowLines = 10, kRefined = 4;

using Lines = std::vector<std::vector<ModelLine>>;

struct Start {
  Eigen::VectorXd x;
  double score = 0.0;
  double log_factor = 0.0, poisson = 0.0;
};

Lines lines_at(const ParameterSpace& space, const SpectrumModels& models, const Eigen::VectorXd& x,
               double cluster_cents = kClusterCents) {
  Lines lines(models.size());
  parallel_for(models.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      lines[s] = model_lines(model_frequencies(space, models, s, x), models[s]->visibility(), cluster_cents);
    }
  });
  return lines;
}

double prior_score(double log_factor, double poisson_offset) {
  return -0.5 * std::pow(2.0 * log_factor / kStiffnessPriorStd, 2) -
         0.5 * std::pow(poisson_offset / kPoissonPriorStd, 2);
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

std::vector<double> candidate_factors(const std::vector<PartialTable>& tables, const Lines& lines) {
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

std::vector<Start> ranked_starts(const ParameterSpace& space, const SpectrumModels& models,
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
    const Lines lines = lines_at(space, models, x);
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
    if (kept.size() >= kRefined) break;
  }
  return kept;
}

JointMatch refined(const ParameterSpace& space, const SpectrumModels& models, const std::vector<PartialTable>& tables,
                   const JointMatchOptions& options, const Eigen::VectorXd& x0) {
  JointMatch joint;
  joint.fit.x = x0;
  joint.regularisation = Eigen::VectorXd::Ones(space.size());
  const double model_cents = options.elastic.model_std * kCentsPerLog;
  double tolerance = std::max(25.0, 2.0 * model_cents), cluster = kClusterCents;
  std::vector<std::vector<int>> before;
  for (int round = 0; round < 12; ++round) {
    joint.lines = lines_at(space, models, joint.fit.x, cluster);
    const double gate =
        round < 2 ? std::max(100.0, options.gate_cents) : std::min(options.gate_cents, std::max(6.0 * tolerance, 12.0));
    const MatchOptions match{tolerance, gate, 40.0};
    joint.matches.clear();
    joint.score = 0.0;
    joint.n_matched = 0;
    std::vector<std::vector<int>> now;
    for (std::size_t s = 0; s < tables.size(); ++s) {
      joint.matches.push_back(match_partials(tables[s], joint.lines[s], 0.0, match));
      joint.score += joint.matches.back().score;
      joint.n_matched += joint.matches.back().n_matched;
      std::vector<int> first_modes;
      for (const int line : joint.matches.back().line_of_partial) {
        first_modes.push_back(line < 0 ? -1 : item(joint.lines[s], line).modes.front());
      }
      now.push_back(std::move(first_modes));
    }
    if (joint.n_matched == 0) return joint;
    const auto data = elastic_data(tables, joint.lines, joint.matches);
    const bool same = round > 2 && now == before;
    joint.fit = fit_elastic(space, models, data, joint.fit.x, joint.regularisation, options.elastic);
    if (same && joint.settled) break;
    joint.settled = same;
    before = std::move(now);
    const Eigen::VectorXd regularisation = regularisation_factors(space, joint.fit);
    if (round >= 2 && regularisation != joint.regularisation && !joint.settled) joint.regularisation = regularisation;
    const double seen = joint.fit.scatter * kCentsPerLog;
    tolerance = round < 1 ? 15.0 : std::clamp(1.5 * seen, 3.0, 15.0);
    // Modes that only happen to lie close are told apart once the model is that good; equal ones stay together.
    if (round >= 1) cluster = std::clamp(0.2 * seen, 0.1, kClusterCents);
  }
  // Odds of different ends are compared at one tolerance.
  const MatchOptions common{6.0, options.gate_cents, 40.0};
  const Lines coarse = lines_at(space, models, joint.fit.x);
  joint.score = prior_score(0.0, 0.0);
  for (std::size_t s = 0; s < tables.size(); ++s) {
    joint.score += match_partials(tables[s], coarse[s], 0.0, common).score;
  }
  const auto young0 = space.quantity("youngs_modulus_pa", space.start()).value;
  const auto young = space.quantity("youngs_modulus_pa", joint.fit.x).value;
  const auto poisson = space.quantity("poissons_ratio", joint.fit.x).value;
  joint.score += prior_score(0.5 * std::log(young / young0), poisson - space.start_poissons_ratio());
  return joint;
}

}  // namespace

Eigen::VectorXd model_frequencies(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                                  const Eigen::VectorXd& x) {
  const Spectrum spectrum = models[specimen]->spectrum(space.local(specimen, x).point);
  return (0.5 * spectrum.log_angular_frequency_sq.array()).exp() / (2.0 * kPi);
}

std::vector<ElasticDatum> elastic_data(const std::vector<PartialTable>& tables, const Lines& lines,
                                       const std::vector<TableMatch>& matches) {
  std::vector<ElasticDatum> data;
  for (std::size_t s = 0; s < tables.size(); ++s) {
    for (std::size_t k = 0; k < lines[s].size(); ++k) {
      ElasticDatum datum{static_cast<int>(s), lines[s][k].modes, 0.0, 0.0};
      double n = 0.0, variance = 0.0;
      for (std::size_t i = 0; i < tables[s].partials.size(); ++i) {
        if (matches[s].line_of_partial[i] != static_cast<int>(k)) continue;
        const Partial& partial = tables[s].partials[i];
        // The model's modes are undamped: omega_0^2 = omega_d^2 + decay^2.
        datum.log_frequency +=
            std::log(std::hypot(partial.frequency_hz, partial.decay_per_s.value_or(0.0) / (2.0 * kPi)));
        variance += std::pow(partial.frequency_std_hz.value_or(0.0) / partial.frequency_hz, 2);
        n += 1.0;
      }
      if (n == 0.0) continue;
      datum.log_frequency /= n;
      datum.sigma = std::sqrt(variance) / n;
      data.push_back(std::move(datum));
    }
  }
  return data;
}

JointMatch match_and_fit(const ParameterSpace& space, const SpectrumModels& models,
                         const std::vector<PartialTable>& tables, const JointMatchOptions& options, Monitor& monitor) {
  validate_fields("joint match", options);
  std::vector<Start> starts = {{space.start(), 0.0, 0.0, 0.0}};
  if (options.search) starts = ranked_starts(space, models, tables, options);
  JointMatch best;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    monitor.progress("matching", static_cast<double>(i) / static_cast<double>(starts.size()));
    monitor.throw_if_stopped();
    JointMatch joint = refined(space, models, tables, options, starts[i].x);
    if (i == 0 || (joint.n_matched > 0 && (best.n_matched == 0 || joint.score > best.score))) best = std::move(joint);
  }
  return best;
}

}  // namespace klang::fit
