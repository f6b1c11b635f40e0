#include "fit/elastic/joint_match.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "fit/elastic/identifiability.hpp"
#include "fit/elastic/match_evidence.hpp"
#include "fit/elastic/match_search.hpp"

namespace klang::fit {
namespace {

constexpr double kCentsPerLog = 1200.0 / 0.693147180559945309417;
constexpr double kClusterCents = 3.0;

/// What a search needs to know all the time.
struct Context {
  const ParameterSpace& space;
  const SpectrumModels& models;
  const std::vector<PartialTable>& tables;
  const JointMatchOptions& options;
};

MatchOptions evidence_options(const Context& c) { return {6.0, c.options.gate_cents, 40.0}; }

/// First modes of the lines of all partials, one specimen after the other: what tells one match from another.
std::vector<int> assignment(const SpecimenLines& lines, const std::vector<TableMatch>& matches) {
  std::vector<int> modes;
  for (std::size_t s = 0; s < matches.size(); ++s) {
    for (const int line : matches[s].line_of_partial)
      modes.push_back(line < 0 ? -1 : item(lines[s], line).modes.front());
  }
  return modes;
}

void count_matched(JointMatch& joint) {
  joint.n_matched = 0;
  for (TableMatch& match : joint.matches) {
    match.n_matched = static_cast<int>(
        std::count_if(match.line_of_partial.begin(), match.line_of_partial.end(), [](int line) { return line >= 0; }));
    joint.n_matched += match.n_matched;
  }
}

/// Whether modes that a partial takes as one line have come apart at the solution: their mean is then no ring's frequency.
bool has_torn_line(const Context& c, const JointMatch& joint) {
  for (std::size_t s = 0; s < c.tables.size(); ++s) {
    if (c.tables[s].partials.empty()) continue;
    const Eigen::VectorXd frequency_hz = model_frequencies(c.space, c.models, s, joint.fit.x);
    for (const int line : joint.matches[s].line_of_partial) {
      if (line < 0) continue;
      const std::vector<int>& modes = item(joint.lines[s], line).modes;
      for (const int mode : modes) {
        if (std::abs(cents(item(frequency_hz, mode), item(frequency_hz, modes.front()))) > 1.5 * kClusterCents)
          return true;
      }
    }
  }
  return false;
}

void weigh(const Context& c, JointMatch& joint) {
  constexpr double kTorn = 100.0;  // log odds: such a match is taken only where there is no other
  const auto data = elastic_data(c.tables, joint.lines, joint.matches);
  joint.evidence = match_evidence(c.space, {c.tables, joint.lines, joint.matches, data, joint.fit}, c.options.elastic,
                                  evidence_options(c));
  if (has_torn_line(c, joint)) joint.evidence -= kTorn;
}

/// Matches and fits in turns until both stay. Rounds before the third match widely; a later first_round keeps near what
/// joint.fit has found.
void settle(const Context& c, JointMatch& joint, int first_round) {
  const double model_cents = c.options.elastic.model_std * kCentsPerLog;
  const auto fitted_tolerance = [&] { return std::clamp(1.5 * joint.fit.scatter * kCentsPerLog, 3.0, 15.0); };
  const auto fitted_cluster = [&] { return std::clamp(0.2 * joint.fit.scatter * kCentsPerLog, 0.1, kClusterCents); };
  double tolerance = first_round > 0 ? fitted_tolerance() : std::max(25.0, 2.0 * model_cents);
  double cluster = first_round > 0 ? fitted_cluster() : kClusterCents;
  std::vector<int> before;
  for (int round = first_round; round < first_round + 12; ++round) {
    joint.lines = lines_at(c.space, c.models, joint.fit.x, cluster);
    const double gate = round < 2 ? std::max(100.0, c.options.gate_cents)
                                  : std::min(c.options.gate_cents, std::max(6.0 * tolerance, 12.0));
    joint.matches.clear();
    for (std::size_t s = 0; s < c.tables.size(); ++s)
      joint.matches.push_back(match_partials(c.tables[s], joint.lines[s], 0.0, {tolerance, gate, 40.0}));
    count_matched(joint);
    if (joint.n_matched == 0) return;
    std::vector<int> now = assignment(joint.lines, joint.matches);
    const auto data = elastic_data(c.tables, joint.lines, joint.matches);
    const bool same = round > 2 && now == before;
    joint.fit = fit_elastic(c.space, c.models, data, joint.fit.x, joint.regularisation, c.options.elastic);
    if (same && joint.settled) break;
    joint.settled = same;
    before = std::move(now);
    const Eigen::VectorXd regularisation = regularisation_factors(c.space, joint.fit);
    if (round >= 2 && regularisation != joint.regularisation && !joint.settled) joint.regularisation = regularisation;
    tolerance = round < 1 ? 15.0 : fitted_tolerance();
    // Modes that only happen to lie close are told apart once the model is that good; equal ones stay together.
    if (round >= 1) cluster = fitted_cluster();
  }
  weigh(c, joint);
}

JointMatch refined(const Context& c, const Eigen::VectorXd& x0) {
  JointMatch joint;
  joint.fit.x = x0;
  joint.regularisation = Eigen::VectorXd::Ones(c.space.size());
  settle(c, joint, 0);
  return joint;
}

/// Another match of one specimen's partials.
struct Alternative {
  std::size_t specimen = 0;
  TableMatch match;
  double evidence = 0.0;  ///< to first order
};

/// What each partial could be instead: another line in reach, whose partial then takes the line that was left, or none.
std::vector<Alternative> alternatives(const Context& c, const JointMatch& joint) {
  const double reach_cents = std::max(100.0, c.options.gate_cents);
  std::vector<Alternative> list;
  for (std::size_t s = 0; s < c.tables.size(); ++s) {
    const auto& partials = c.tables[s].partials;
    const auto& lines = joint.lines[s];
    for (std::size_t i = 0; i < partials.size(); ++i) {
      const int own = joint.matches[s].line_of_partial[i];
      if (own >= 0) {
        list.push_back({s, joint.matches[s], 0.0});
        list.back().match.line_of_partial[i] = -1;
      }
      for (std::size_t k = 0; k < lines.size(); ++k) {
        const int line = static_cast<int>(k);
        if (line == own || std::abs(cents(partials[i].frequency_hz, lines[k].frequency_hz)) > reach_cents) continue;
        Alternative other{s, joint.matches[s], 0.0};
        for (std::size_t j = 0; j < partials.size(); ++j) {
          if (other.match.line_of_partial[j] != line) continue;
          const bool takes =
              own >= 0 && std::abs(cents(partials[j].frequency_hz, item(lines, own).frequency_hz)) <= 1.5 * reach_cents;
          other.match.line_of_partial[j] = takes ? own : -1;
        }
        other.match.line_of_partial[i] = line;
        list.push_back(std::move(other));
      }
    }
  }
  return list;
}

/// Evidence of each alternative with the parameters moved to first order.
void weigh_alternatives(const Context& c, const JointMatch& joint, std::vector<Alternative>& list) {
  std::vector<Eigen::VectorXd> log_frequency(c.models.size());
  std::vector<Eigen::MatrixXd> by_x(c.models.size());
  for (std::size_t s = 0; s < c.tables.size(); ++s) {
    if (c.tables[s].partials.empty()) continue;
    const ParameterSpace::Local local = c.space.local(s, joint.fit.x);
    const Spectrum spectrum = c.models[s]->spectrum(local.point);
    log_frequency[s] = 0.5 * spectrum.log_angular_frequency_sq.array() - std::log(2.0 * kPi);
    by_x[s] = 0.5 * spectrum.derivative * local.derivative;
  }
  parallel_for(list.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      std::vector<TableMatch> matches = joint.matches;
      matches[list[a].specimen] = list[a].match;
      const auto data = elastic_data(c.tables, joint.lines, matches);
      Eigen::VectorXd residual(static_cast<Eigen::Index>(data.size()));
      Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(residual.size(), c.space.size());
      for (Eigen::Index i = 0; i < residual.size(); ++i) {
        const ElasticDatum& datum = item(data, i);
        residual[i] = datum.log_frequency;
        const double share = 1.0 / static_cast<double>(datum.modes.size());
        for (const int mode : datum.modes) {
          residual[i] -= share * item(item(log_frequency, datum.specimen), mode);
          derivative.row(i) += share * item(by_x, datum.specimen).row(mode);
        }
      }
      const ElasticFit fit = linear_fit(c.space, joint.fit.x, residual, derivative, data, c.options.elastic);
      list[a].evidence =
          match_evidence(c.space, {c.tables, joint.lines, matches, data, fit}, c.options.elastic, evidence_options(c));
    }
  });
}

/// The best few alternatives to a match, each fitted, and settled from there on.
std::vector<JointMatch> tried_alternatives(const Context& c, const JointMatch& joint) {
  constexpr std::size_t kMostTried = 6;
  constexpr double kWorthATry = 5.0;  // log odds that a step of first order may be off
  std::vector<Alternative> list = alternatives(c, joint);
  weigh_alternatives(c, joint, list);
  std::stable_sort(list.begin(), list.end(),
                   [](const Alternative& a, const Alternative& b) { return a.evidence > b.evidence; });
  while (!list.empty() && (list.size() > kMostTried || list.back().evidence < joint.evidence - kWorthATry))
    list.pop_back();
  std::vector<JointMatch> tried(2 * list.size());
  parallel_for(list.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      JointMatch held = joint;
      held.matches[list[a].specimen] = list[a].match;
      count_matched(held);
      if (held.n_matched == 0) continue;
      const auto data = elastic_data(c.tables, held.lines, held.matches);
      held.fit = fit_elastic(c.space, c.models, data, joint.fit.x, joint.regularisation, c.options.elastic);
      held.settled = false;
      weigh(c, held);
      JointMatch settled = held;
      settle(c, settled, 3);
      tried[2 * a] = std::move(settled);
      tried[2 * a + 1] = std::move(held);
    }
  });
  return tried;
}

/// Whether a is to be preferred: it matches something and has the better evidence.
bool better(const JointMatch& a, const JointMatch& b) {
  if (a.n_matched == 0 || b.n_matched == 0) return a.n_matched > 0 && b.n_matched == 0;
  return a.evidence > b.evidence + 1e-9;
}

/// The end whose alternatives are to be tried next: the best of all, or of those that the starts led to, the first n_starts, one near enough to
/// it that an alternative may be better still: a right match with one pair of partials exchanged can look worse than a wrong one of few partials.
std::optional<std::size_t> most_promising(const std::vector<JointMatch>& ends, std::size_t n_starts,
                                          const std::set<std::vector<int>>& tried) {
  constexpr double kHorizon = 6.0;  // log odds
  std::size_t best = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) best = better(ends[i], ends[best]) ? i : best;
  const auto is_open = [&](std::size_t i) {
    return ends[i].n_matched > 0 && !tried.contains(assignment(ends[i].lines, ends[i].matches));
  };
  if (is_open(best)) return best;
  std::optional<std::size_t> next;
  for (std::size_t i = 0; i < n_starts; ++i) {
    if (!is_open(i) || !(ends[i].evidence >= ends[best].evidence - kHorizon)) continue;
    if (!next || better(ends[i], ends[*next])) next = i;
  }
  return next;
}

/// The best of the ends that put the partials on other modes than the chosen one does.
std::optional<RivalMatch> rival_of(const Context& c, const JointMatch& chosen, const std::vector<JointMatch>& ends) {
  const std::vector<int> own = assignment(chosen.lines, chosen.matches);
  std::optional<RivalMatch> rival;
  for (const JointMatch& end : ends) {
    if (end.n_matched == 0 || !end.fit.converged) continue;
    std::vector<int> modes = assignment(end.lines, end.matches);
    if (modes == own || (rival && end.evidence <= chosen.evidence - rival->log_odds)) continue;
    rival = RivalMatch{chosen.evidence - end.evidence,
                       end.n_matched,
                       end.fit.scatter,
                       c.space.quantity("youngs_modulus_pa", end.fit.x).value,
                       c.space.quantity("poissons_ratio", end.fit.x).value,
                       std::move(modes)};
  }
  return rival;
}

}  // namespace

SpecimenLines lines_at(const ParameterSpace& space, const SpectrumModels& models, const Eigen::VectorXd& x,
                       double cluster_cents) {
  SpecimenLines lines(models.size());
  parallel_for(models.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) {
      const SpectrumPoint point = space.local(s, x).point;
      const Spectrum spectrum = models[s]->spectrum(point);
      lines[s] = model_lines((0.5 * spectrum.log_angular_frequency_sq.array()).exp() / (2.0 * kPi),
                             models[s]->visibility(), cluster_cents, point.lame_mu_pa * spectrum.derivative.col(1));
    }
  });
  return lines;
}

Eigen::VectorXd model_frequencies(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                                  const Eigen::VectorXd& x) {
  const Spectrum spectrum = models[specimen]->spectrum(space.local(specimen, x).point);
  return (0.5 * spectrum.log_angular_frequency_sq.array()).exp() / (2.0 * kPi);
}

std::vector<ElasticDatum> elastic_data(const std::vector<PartialTable>& tables, const SpecimenLines& lines,
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
  const Context c{space, models, tables, options};
  std::vector<Eigen::VectorXd> starts = {space.start()};
  if (options.search) starts = match_starts(space, models, tables, options);
  std::vector<JointMatch> ends(starts.size());
  for_each_job(
      starts.size(), [&](std::size_t i) { ends[i] = refined(c, starts[i]); }, "matching", monitor);
  // Whether its alternatives were tried is known of each assignment, not of each end: many starts end alike.
  std::set<std::vector<int>> tried;
  constexpr int kMostSteps = 12;
  for (int step = 0; step < kMostSteps; ++step) {
    monitor.throw_if_stopped();
    const std::optional<std::size_t> next = most_promising(ends, starts.size(), tried);
    if (!next) break;
    tried.insert(assignment(ends[*next].lines, ends[*next].matches));
    for (JointMatch& other : tried_alternatives(c, ends[*next])) ends.push_back(std::move(other));
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) best = better(ends[i], ends[best]) ? i : best;
  JointMatch chosen = ends[best];
  if (chosen.n_matched == 0) return chosen;
  chosen.settled = tried.contains(assignment(chosen.lines, chosen.matches));
  chosen.rival = rival_of(c, chosen, ends);
  return chosen;
}

}  // namespace klang::fit
