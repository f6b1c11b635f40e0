#include "fit/proxy/proxy_frequencies.hpp"

#include <algorithm>
#include <cmath>

namespace klang::fit {

using soundbank::kModeClasses;

ProxyFrequencies::ProxyFrequencies(const soundbank::Soundbank& bank, int count)
    : bank_(bank), count_(static_cast<std::size_t>(count)) {
  Eigen::Index rows = 0;
  for (int c = 0; c < kModeClasses; ++c) {
    const Eigen::Index kept = bank.node_frequencies.front()[c].size();
    begin_[c] = rows;
    size_[c] = std::min<Eigen::Index>(kept, count);
    may_hide_[c] = kept < count;
    rows += size_[c];
  }
  ln_frequency_.resize(rows, static_cast<Eigen::Index>(bank.nodes.size()));
  for (std::size_t n = 0; n < bank.nodes.size(); ++n)
    for (int c = 0; c < kModeClasses; ++c)
      ln_frequency_.col(static_cast<Eigen::Index>(n)).segment(begin_[c], size_[c]) =
          bank.node_frequencies[n][c].head(size_[c]).array().log();
}

void ProxyFrequencies::lowest(const soundbank::ShapePlace& place, std::vector<Line>& lines) const {
  const auto& nodes = bank_.triangles[static_cast<std::size_t>(place.triangle)].nodes;
  const auto weights = soundbank::node_weights(place.weights);
  thread_local Eigen::VectorXd values;
  values = weights[0] * ln_frequency_.col(nodes[0]);
  for (int i = 1; i < 6; ++i) values += weights[i] * ln_frequency_.col(nodes[i]);
  const auto before = [](const Line& a, const Line& b) {
    return a.ln_frequency != b.ln_frequency ? a.ln_frequency < b.ln_frequency : a.row < b.row;
  };
  lines.clear();
  double known = HUGE_VAL;
  for (int c = 0; c < kModeClasses; ++c) {
    const std::size_t first = lines.size();
    for (Eigen::Index k = 0; k < size_[c]; ++k) lines.push_back({values[begin_[c] + k], {c, 0}, begin_[c] + k});
    // Where two of a class nearly meet the parabolas may cross: rank by value.
    std::sort(lines.begin() + static_cast<std::ptrdiff_t>(first), lines.end(), before);
    for (std::size_t k = first; k < lines.size(); ++k) lines[k].id.index = static_cast<int>(k - first);
    if (may_hide_[c]) known = std::min(known, size_[c] > 0 ? lines.back().ln_frequency : -HUGE_VAL);
  }
  const std::size_t n = std::min(count_, lines.size());
  std::partial_sort(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(n), lines.end(), before);
  lines.resize(n);
  while (!lines.empty() && lines.back().ln_frequency > known) lines.pop_back();
}

void ProxyFrequencies::slopes(const soundbank::ShapePlace& place, const std::vector<Line>& lines,
                              std::vector<std::array<double, 2>>& slopes) const {
  const auto& nodes = bank_.triangles[static_cast<std::size_t>(place.triangle)].nodes;
  const auto by_shape = soundbank::node_weight_slopes(bank_, place);
  slopes.assign(lines.size(), {0.0, 0.0});
  for (std::size_t k = 0; k < lines.size(); ++k)
    for (int i = 0; i < 6; ++i) {
      const double value = ln_frequency_(lines[k].row, nodes[i]);
      slopes[k][0] += by_shape(i, 0) * value;
      slopes[k][1] += by_shape(i, 1) * value;
    }
}

}  // namespace klang::fit
