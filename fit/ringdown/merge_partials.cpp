#include "fit/ringdown/merge_partials.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit {
namespace {

struct Mean {
  double value = 0.0;
  std::optional<double> std;
};

Mean mean_of(const std::vector<std::pair<double, std::optional<double>>>& values) {
  double weight_sum = 0.0, sum = 0.0;
  const bool all_known =
      std::all_of(values.begin(), values.end(), [](const auto& v) { return v.second && *v.second > 0; });
  for (const auto& [value, std] : values) {
    const double weight = all_known ? 1.0 / (*std * *std) : 1.0;
    weight_sum += weight;
    sum += weight * value;
  }
  Mean mean{sum / weight_sum, std::nullopt};
  double chi_squared = 0.0;
  for (const auto& [value, std] : values) {
    const double weight = all_known ? 1.0 / (*std * *std) : 1.0;
    chi_squared += weight * (value - mean.value) * (value - mean.value);
  }
  const double dof = static_cast<double>(values.size()) - 1.0;
  if (all_known) {
    mean.std = std::sqrt(std::max(1.0, dof > 0.0 ? chi_squared / dof : 1.0) / weight_sum);
  } else if (dof > 0.0) {
    mean.std = std::sqrt(chi_squared / dof / weight_sum);
  }
  return mean;
}

bool agree(const Partial& a, const Partial& b, double min_cents) {
  const double own = std::hypot(a.frequency_std_hz.value_or(0.0), b.frequency_std_hz.value_or(0.0));
  return std::abs(a.frequency_hz - b.frequency_hz) <=
         std::max(3.0 * own, b.frequency_hz * (std::exp2(min_cents / 1200.0) - 1.0));
}

struct Row {
  Partial partial;
  std::size_t table;
};

/// One partial as the takes have it: rows of one table at most once, ascending in frequency.
using Group = std::vector<Row>;

std::vector<Group> groups_of(const std::vector<PartialTable>& tables, double min_cents) {
  std::vector<Row> rows;
  for (std::size_t t = 0; t < tables.size(); ++t) {
    for (const Partial& partial : tables[t].partials) rows.push_back({partial, t});
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const Row& a, const Row& b) { return a.partial.frequency_hz < b.partial.frequency_hz; });
  std::vector<char> used(rows.size(), 0);
  std::vector<Group> groups;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (used[i]) continue;
    Group group = {rows[i]};
    std::vector<char> has(tables.size(), 0);
    has[rows[i].table] = 1;
    for (std::size_t j = i + 1; j < rows.size(); ++j) {  // one of each recording: a pair stays a pair
      if (used[j] || has[rows[j].table] || !agree(rows[i].partial, rows[j].partial, min_cents)) continue;
      group.push_back(rows[j]);
      used[j] = has[rows[j].table] = 1;
    }
    groups.push_back(std::move(group));
  }
  return groups;
}

/// Scatter of ln f between takes beyond the partials' own deviations, of all groups together.
double scatter_of(const std::vector<Group>& groups) {
  double sum = 0.0, own = 0.0, dof = 0.0;
  for (const Group& group : groups) {
    const auto n = static_cast<double>(group.size());
    if (n < 2.0) continue;
    double mean = 0.0, variance = 0.0;
    for (const Row& row : group) mean += std::log(row.partial.frequency_hz) / n;
    for (const Row& row : group) {
      sum += std::pow(std::log(row.partial.frequency_hz) - mean, 2);
      variance += std::pow(row.partial.frequency_std_hz.value_or(0.0) / row.partial.frequency_hz, 2) / n;
    }
    own += (n - 1.0) * variance;
    dof += n - 1.0;
  }
  return dof > 0.0 ? std::sqrt(std::max(0.0, (sum - own) / dof)) : 0.0;
}

}  // namespace

TakeAgreement take_agreement(const std::vector<PartialTable>& tables, double min_cents) {
  constexpr double kStrong = 0.05;  // of the take's loudest: -26 dB
  const std::vector<Group> groups = groups_of(tables, min_cents);
  TakeAgreement agreement{scatter_of(groups), 1.0};
  for (std::size_t t = 0; t < tables.size(); ++t) {
    double loudest = 0.0, n_strong = 0.0, n_shared = 0.0;
    for (const Partial& partial : tables[t].partials) loudest = std::max(loudest, partial.amplitude.value_or(0.0));
    for (const Group& group : groups) {
      for (const Row& row : group) {
        if (row.table != t || row.partial.amplitude.value_or(loudest) < kStrong * loudest) continue;
        n_strong += 1.0;
        n_shared += group.size() > 1 ? 1.0 : 0.0;
      }
    }
    if (n_strong > 0.0) agreement.least_share = std::min(agreement.least_share, n_shared / n_strong);
  }
  return agreement;
}

PartialTable merge_partials(const std::vector<PartialTable>& tables, double min_cents) {
  PartialTable merged;
  for (std::size_t t = 0; t < tables.size(); ++t) merged.origin += (t ? ", " : "") + tables[t].origin;
  const std::vector<Group> groups = groups_of(tables, min_cents);
  const double scatter = scatter_of(groups);
  for (const Group& group : groups) {
    Partial mean = group.front().partial;
    std::vector<std::pair<double, std::optional<double>>> frequencies, decays;
    for (const Row& row : group) {
      const Partial& partial = row.partial;
      std::optional<double> std = partial.frequency_std_hz;
      if (std) std = std::hypot(*std, scatter * partial.frequency_hz);
      frequencies.emplace_back(partial.frequency_hz, std);
      if (partial.decay_per_s) decays.emplace_back(*partial.decay_per_s, partial.decay_std_per_s);
      if (partial.amplitude.value_or(0.0) > mean.amplitude.value_or(0.0)) mean = partial;
    }
    mean.frequency_hz = frequencies.front().first;
    mean.frequency_std_hz = frequencies.front().second;
    if (group.size() > 1) {
      const Mean frequency = mean_of(frequencies);
      mean.frequency_hz = frequency.value;
      mean.frequency_std_hz = frequency.std;
      // One take that shows the decay is enough to tell that it decays.
      for (const Row& row : group) {
        if (row.partial.is_ring() && !mean.is_ring()) mean.kind = row.partial.kind;
      }
      if (!decays.empty()) {
        const Mean decay = mean_of(decays);
        mean.decay_per_s = decay.value;
        mean.decay_std_per_s = decay.std;
      }
    }
    merged.partials.push_back(mean);
  }
  std::stable_sort(merged.partials.begin(), merged.partials.end(),
                   [](const Partial& a, const Partial& b) { return a.frequency_hz < b.frequency_hz; });
  return merged;
}

}  // namespace klang::fit
