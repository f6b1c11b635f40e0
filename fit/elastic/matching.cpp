#include "fit/elastic/matching.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::fit {
namespace {

constexpr double kHeardLoud = 0.75;  // a loud line in a recording that shows as many partials as there are lines
constexpr double kHeardSilent = 0.02;
constexpr double kStrangersPerCent = 1.0 / 1200.0;
constexpr double kSameShare =
    0.01;  // modes of a pair strain alike; this much moves ln f by 3e-4 per 0.1 of Poisson's ratio
constexpr double kSecondOfPair = -1.0;  // log odds: most strikes show one partial of a pair

struct Candidate {
  int partial;
  int line;
  double gain;
};

double log_t3(double x) {  // density of Student's t, 3 degrees of freedom
  const double u = 1.0 + x * x / 3.0;
  return std::log(2.0 / (kPi * std::sqrt(3.0))) - 2.0 * std::log(u);
}

/// What a partial brings to the sound: the root of its energy, amplitude^2 / (2 decay), so that a long clear ring counts
/// for more than a louder thud beside it.
double strength(const Partial& partial, bool by_energy) {
  const double amplitude = partial.amplitude.value_or(0.0);
  return by_energy ? amplitude / std::sqrt(2.0 * *partial.decay_per_s) : amplitude;
}

/// Greater for weak partials: they are more often noise, rattles or other bodies.
std::vector<double> stranger_density(const PartialTable& table) {
  const bool by_energy = std::all_of(table.partials.begin(), table.partials.end(),
                                     [](const Partial& p) { return p.decay_per_s && *p.decay_per_s > 0.0; });
  double strongest = 0.0;
  for (const Partial& partial : table.partials) strongest = std::max(strongest, strength(partial, by_energy));
  std::vector<double> density;
  for (const Partial& partial : table.partials) {
    const double own = partial.amplitude ? strength(partial, by_energy) : strongest;
    const double relative = strongest > 0.0 ? std::max(own / strongest, 1e-5) : 1.0;
    density.push_back(kStrangersPerCent * std::pow(relative, -0.4));
  }
  return density;
}

std::vector<double> heard_probability(const PartialTable& table, const std::vector<ModelLine>& lines,
                                      double shift_cents, double highest_hz) {
  const double factor = std::exp2(shift_cents / 1200.0);
  double n_audible = 0.0;
  for (const ModelLine& line : lines) {
    if (line.frequency_hz * factor <= highest_hz) n_audible += line.visibility;
  }
  const double crowding = std::min(1.0, 1.2 * static_cast<double>(table.partials.size()) / std::max(n_audible, 1.0));
  std::vector<double> probability;
  for (const ModelLine& line : lines) {
    probability.push_back(kHeardSilent + (kHeardLoud * crowding - kHeardSilent) * std::sqrt(line.visibility));
    probability.back() = std::max(probability.back(), 0.01);
  }
  return probability;
}

/// Takes the best pairs first. Within a line's free places; good enough to rank shifts.
std::vector<int> greedy(std::vector<Candidate> candidates, std::size_t n_partials,
                        const std::vector<ModelLine>& lines) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  std::vector<int> line_of_partial(n_partials, -1), taken(lines.size(), 0);
  for (const Candidate& candidate : candidates) {
    const auto line = static_cast<std::size_t>(candidate.line);
    int& chosen = item(line_of_partial, candidate.partial);
    const int places = std::min(2, static_cast<int>(lines[line].modes.size()));
    const double gain = candidate.gain + (taken[line] ? kSecondOfPair : 0.0);
    if (chosen >= 0 || taken[line] >= places || !(gain > 0.0)) continue;
    chosen = candidate.line;
    ++taken[line];
  }
  return line_of_partial;
}

std::vector<int> optimal(const std::vector<Candidate>& candidates, std::size_t n_partials,
                         const std::vector<ModelLine>& lines) {
  // Columns: first and further places of the lines in reach, then one "stranger" a partial at cost 0.
  std::vector<int> column_line, first_column(lines.size(), -1), n_columns(lines.size(), 0);
  for (const Candidate& candidate : candidates) {
    const auto line = static_cast<std::size_t>(candidate.line);
    if (first_column[line] >= 0) continue;
    first_column[line] = static_cast<int>(column_line.size());
    n_columns[line] = std::min(4, static_cast<int>(lines[line].modes.size()));
    column_line.insert(column_line.end(), static_cast<std::size_t>(n_columns[line]), candidate.line);
  }
  const auto n_rows = static_cast<Eigen::Index>(n_partials);
  const auto n_places = static_cast<Eigen::Index>(column_line.size());
  constexpr double kForbidden = 1e6;
  Eigen::MatrixXd cost = Eigen::MatrixXd::Constant(n_rows, n_places + n_rows, kForbidden);
  for (Eigen::Index i = 0; i < n_rows; ++i) cost(i, n_places + i) = 0.0;
  for (const Candidate& candidate : candidates) {
    const auto line = static_cast<std::size_t>(candidate.line);
    for (int k = 0; k < n_columns[line]; ++k) {
      const double gain = candidate.gain + (k > 0 ? kSecondOfPair : 0.0);
      cost(candidate.partial, first_column[line] + k) = -gain;
    }
  }
  std::vector<int> line_of_partial(n_partials, -1);
  const std::vector<int> column = least_cost_assignment(cost);
  for (std::size_t i = 0; i < n_partials; ++i) {
    if (column[i] < n_places) line_of_partial[i] = item(column_line, column[i]);
  }
  return line_of_partial;
}

/// Of several partials on one line, those further than split_cents from the strongest of them go.
void drop_wide_splits(const PartialTable& table, double split_cents, std::vector<int>& line_of_partial) {
  for (std::size_t i = 0; i < line_of_partial.size(); ++i) {
    for (std::size_t j = i + 1; j < line_of_partial.size(); ++j) {
      if (line_of_partial[i] < 0 || line_of_partial[i] != line_of_partial[j]) continue;
      const Partial &a = table.partials[i], &b = table.partials[j];
      if (std::abs(cents(a.frequency_hz, b.frequency_hz)) <= split_cents) continue;
      line_of_partial[a.amplitude.value_or(0.0) >= b.amplitude.value_or(0.0) ? j : i] = -1;
    }
  }
}

}  // namespace

std::vector<ModelLine> model_lines(const Eigen::VectorXd& frequency_hz, const Eigen::VectorXd& visibility,
                                   double cluster_cents, const Eigen::VectorXd& shear_share) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(frequency_hz.size()));
  std::iota(order.begin(), order.end(), Eigen::Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return frequency_hz[a] < frequency_hz[b]; });
  const auto joins = [&](Eigen::Index k, const ModelLine& line) {
    const Eigen::Index last = line.modes.back();
    return cents(frequency_hz[k], frequency_hz[last]) <= cluster_cents &&
           (shear_share.size() == 0 || std::abs(shear_share[k] - shear_share[last]) <= kSameShare);
  };
  std::vector<ModelLine> lines;
  for (const Eigen::Index k : order) {
    // Another kind of mode may lie between two of a pair: look back as far as the cluster reaches.
    std::size_t at = lines.size();
    for (std::size_t l = lines.size(); l-- > 0 && at == lines.size();) {
      if (joins(k, lines[l])) at = l;
      if (cents(frequency_hz[k], frequency_hz[lines[l].modes.front()]) > 10.0 * cluster_cents) break;
    }
    if (at == lines.size()) lines.push_back({0.0, {}, 0.0});
    ModelLine& line = lines[at];
    line.frequency_hz += std::log(frequency_hz[k]);
    line.modes.push_back(static_cast<int>(k));
    line.visibility = std::max(line.visibility, visibility.size() ? visibility[k] : 1.0);
  }
  for (ModelLine& line : lines) {
    line.frequency_hz = std::exp(line.frequency_hz / static_cast<double>(line.modes.size()));
  }
  std::stable_sort(lines.begin(), lines.end(),
                   [](const ModelLine& a, const ModelLine& b) { return a.frequency_hz < b.frequency_hz; });
  return lines;
}

TableMatch match_partials(const PartialTable& table, const std::vector<ModelLine>& lines, double shift_cents,
                          const MatchOptions& options, bool exact) {
  KLANG_CHECK(options.tolerance_cents > 0 && options.gate_cents > 0, "match options must be positive");
  TableMatch match;
  match.line_of_partial.assign(table.partials.size(), -1);
  if (table.partials.empty() || lines.empty()) return match;
  double highest_hz = 0.0;
  for (const Partial& partial : table.partials) highest_hz = std::max(highest_hz, partial.frequency_hz);
  const auto probability = heard_probability(table, lines, shift_cents, highest_hz);
  const auto strangers = stranger_density(table);

  std::vector<Candidate> candidates;
  std::vector<std::vector<double>> gain(table.partials.size());
  const auto pair_gain = [&](std::size_t i, std::size_t k) {
    const double d = cents(table.partials[i].frequency_hz, lines[k].frequency_hz) - shift_cents;
    const double p = probability[k];
    return std::log(p / (1.0 - p)) + log_t3(d / options.tolerance_cents) - std::log(options.tolerance_cents) -
           std::log(strangers[i]);
  };
  for (std::size_t i = 0; i < table.partials.size(); ++i) {
    const double at_hz = table.partials[i].frequency_hz * std::exp2(-shift_cents / 1200.0);
    const double reach = std::exp2(options.gate_cents / 1200.0);
    auto line = std::lower_bound(lines.begin(), lines.end(), at_hz / reach,
                                 [](const ModelLine& l, double f) { return l.frequency_hz < f; });
    for (; line != lines.end() && line->frequency_hz <= at_hz * reach; ++line) {
      const auto k = static_cast<std::size_t>(line - lines.begin());
      const double value = pair_gain(i, k);
      if (value > 0.0) candidates.push_back({static_cast<int>(i), static_cast<int>(k), value});
    }
  }
  match.line_of_partial =
      exact ? optimal(candidates, table.partials.size(), lines) : greedy(candidates, table.partials.size(), lines);
  drop_wide_splits(table, options.split_cents, match.line_of_partial);

  std::vector<int> taken(lines.size(), 0);
  for (std::size_t i = 0; i < match.line_of_partial.size(); ++i) {
    const int line = match.line_of_partial[i];
    if (line < 0) continue;
    const auto k = static_cast<std::size_t>(line);
    match.score += pair_gain(i, k) + (taken[k]++ ? kSecondOfPair : 0.0);
    ++match.n_matched;
  }
  const double highest_line_hz = highest_hz * std::exp2((options.gate_cents - shift_cents) / 1200.0);
  for (std::size_t k = 0; k < lines.size() && lines[k].frequency_hz <= highest_line_hz; ++k) {
    match.score += std::log(1.0 - probability[k]);
  }
  return match;
}

double match_prior_score(const PartialTable& table, const std::vector<ModelLine>& lines, const TableMatch& match,
                         const MatchOptions& options) {
  if (table.partials.empty() || lines.empty()) return 0.0;
  double highest_hz = 0.0, score = 0.0;
  for (const Partial& partial : table.partials) highest_hz = std::max(highest_hz, partial.frequency_hz);
  const auto probability = heard_probability(table, lines, 0.0, highest_hz);
  const auto strangers = stranger_density(table);
  std::vector<int> taken(lines.size(), 0);
  for (std::size_t i = 0; i < match.line_of_partial.size(); ++i) {
    const int line = match.line_of_partial[i];
    if (line < 0) continue;
    const double p = item(probability, line);
    score += std::log(p / (1.0 - p)) - std::log(strangers[i]);
    if (item(taken, line)++) score += kSecondOfPair - std::log(2.0 * options.split_cents);
  }
  const double highest_line_hz = highest_hz * std::exp2(options.gate_cents / 1200.0);
  for (std::size_t k = 0; k < lines.size() && lines[k].frequency_hz <= highest_line_hz; ++k)
    score += std::log(1.0 - probability[k]);
  return score;
}

std::vector<int> least_cost_assignment(const Eigen::MatrixXd& cost) {
  const auto n = static_cast<std::size_t>(cost.rows()), m = static_cast<std::size_t>(cost.cols());
  KLANG_CHECK(n <= m, "more rows than columns");
  constexpr double kInf = std::numeric_limits<double>::infinity();
  // Row 0 and column 0 are sentinels; row_of[j] is the row that holds column j.
  std::vector<double> u(n + 1, 0.0), v(m + 1, 0.0);
  std::vector<std::size_t> row_of(m + 1, 0), previous(m + 1, 0);
  for (std::size_t i = 1; i <= n; ++i) {
    row_of[0] = i;
    std::size_t column = 0;
    std::vector<double> slack(m + 1, kInf);
    std::vector<char> used(m + 1, 0);
    do {  // grow the alternating tree by the column of least slack until a free one is reached
      used[column] = 1;
      const std::size_t row = row_of[column];
      double delta = kInf;
      std::size_t next = 0;
      for (std::size_t j = 1; j <= m; ++j) {
        if (used[j]) continue;
        const double reduced =
            cost(static_cast<Eigen::Index>(row - 1), static_cast<Eigen::Index>(j - 1)) - u[row] - v[j];
        if (reduced < slack[j]) {
          slack[j] = reduced;
          previous[j] = column;
        }
        if (slack[j] < delta) {
          delta = slack[j];
          next = j;
        }
      }
      for (std::size_t j = 0; j <= m; ++j) {
        if (used[j]) {
          u[row_of[j]] += delta;
          v[j] -= delta;
        } else {
          slack[j] -= delta;
        }
      }
      column = next;
    } while (row_of[column] != 0);
    while (column != 0) {  // flip the path
      row_of[column] = row_of[previous[column]];
      column = previous[column];
    }
  }
  std::vector<int> column_of(n, -1);
  for (std::size_t j = 1; j <= m; ++j) {
    if (row_of[j] != 0) column_of[row_of[j] - 1] = static_cast<int>(j - 1);
  }
  return column_of;
}

}  // namespace klang::fit
