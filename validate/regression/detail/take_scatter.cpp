#include "validate/regression/detail/take_scatter.hpp"

#include <algorithm>
#include <cmath>

#include "validate/regression/detail/quantiles.hpp"

namespace klang::validate::detail {
namespace {

constexpr double kManyDof = 1e6;  // as good as infinite
// Of the test for a common shift: takes without one that it finds are held by as many degrees of freedom as there are takes less one, with
// three takes by tolerances that judge nothing.
constexpr double kCommonLevel = 0.002;

/// psi(x) and psi'(x), x > 0: recurrence to x > 8, then the asymptotic series (Abramowitz and Stegun 1964, 6.3.18 and 6.4.12).
double digamma(double x) {
  double sum = 0.0;
  for (; x < 8.0; x += 1.0) sum -= 1.0 / x;
  const double y = 1.0 / (x * x);
  return sum + std::log(x) - 0.5 / x - y * (1.0 / 12 - y * (1.0 / 120 - y / 252));
}
double trigamma(double x) {
  double sum = 0.0;
  for (; x < 8.0; x += 1.0) sum += 1.0 / (x * x);
  const double y = 1.0 / (x * x);
  return sum + 1.0 / x + 0.5 * y + y / x * (1.0 / 6 - y * (1.0 / 30 - y / 42));
}

/// x with trigamma(x) = value; trigamma falls.
double inverse_trigamma(double value) {
  double low = std::log(1e-6), high = std::log(kManyDof);
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (trigamma(std::exp(middle)) > value ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

/// The variance over their own that all quantities have in common, each weighted by how well it is known: sum d s^2 / (own + excess) = sum d
/// (Paule and Mandel 1982). A mean of s^2 - own would be what the least certain quantity makes of it.
double common_excess(const std::vector<Samples>& quantities, double all_dof) {
  double high = 0.0;
  for (const Samples& q : quantities) high = std::max(high, q.variance());
  const auto is_too_small = [&](double excess) {
    double sum = 0.0;
    for (const Samples& q : quantities) {
      const double expected = q.own_variance() + excess;
      if (q.value.size() >= 2 && expected > 0.0)
        sum += static_cast<double>(q.value.size() - 1) * q.variance() / expected;
      if (q.value.size() >= 2 && !(expected > 0.0) && q.variance() > 0.0) return true;
    }
    return sum > all_dof;
  };
  high *= static_cast<double>(quantities.size());
  double low = 0.0;
  if (!is_too_small(low)) return 0.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (is_too_small(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

struct Prior {
  double dof = kManyDof, variance = 1.0;
};

/// Of ratios with dof degrees of freedom each.
Prior prior_of(const std::vector<double>& ratio, const std::vector<double>& dof) {
  const auto n = static_cast<double>(ratio.size());
  double mean = 0.0, square = 0.0, by_chance = 0.0;
  std::vector<double> e;
  for (std::size_t i = 0; i < ratio.size(); ++i) {
    e.push_back(std::log(std::max(ratio[i], 1e-12)) - digamma(0.5 * dof[i]) + std::log(0.5 * dof[i]));
    mean += e.back() / n;
    by_chance += trigamma(0.5 * dof[i]) / n;
  }
  for (const double x : e) square += (x - mean) * (x - mean) / (n - 1.0);
  if (!(square > by_chance)) return {};
  const double d0 = 2.0 * inverse_trigamma(square - by_chance);
  return {d0, std::exp(mean + digamma(0.5 * d0) - std::log(0.5 * d0))};
}

}  // namespace

void Samples::add(double v, double s, std::size_t from_take) {
  value.push_back(v);
  std.push_back(s);
  take.push_back(from_take);
}

double Samples::mean() const {
  double sum = 0.0;
  for (const double x : value) sum += x / static_cast<double>(value.size());
  return sum;
}

double Samples::variance() const {
  if (value.size() < 2) return 0.0;
  const double centre = mean();
  double sum = 0.0;
  for (const double x : value) sum += (x - centre) * (x - centre);
  return sum / static_cast<double>(value.size() - 1);
}

double Samples::own_variance() const {
  double sum = 0.0;
  for (const double s : std) sum += s * s / static_cast<double>(std.size());
  return sum;
}

Scatter moderated_scatter(const std::vector<Samples>& quantities) {
  Scatter result;
  result.std.assign(quantities.size(), 0.0);
  double all_dof = 0.0, pooled = 0.0;
  for (const Samples& q : quantities) all_dof += q.value.size() < 2 ? 0.0 : static_cast<double>(q.value.size() - 1);
  if (!(all_dof > 0.0)) return result;
  const double excess = common_excess(quantities, all_dof);
  std::vector<double> ratio, dof;
  for (const Samples& q : quantities) {
    if (q.value.size() < 2) continue;
    dof.push_back(static_cast<double>(q.value.size() - 1));
    const double expected = q.own_variance() + excess;
    ratio.push_back(expected > 0.0 ? q.variance() / expected : 1.0);
    pooled += dof.back() * ratio.back() / all_dof;
  }
  const bool few = ratio.size() < 3;
  Prior prior{kManyDof, pooled};
  if (!few) {
    const Prior found = prior_of(ratio, dof);
    if (found.dof < kManyDof) prior = found;
  }
  double least_dof = all_dof;
  std::size_t k = 0;
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const Samples& q = quantities[i];
    const bool known = q.value.size() >= 2;
    const double own = q.own_variance(), d = known ? dof[k] : 0.0, r = known ? ratio[k] : 0.0;
    if (known) ++k;
    double moderated = (prior.dof * prior.variance + d * r) / (prior.dof + d);
    if (few) moderated = std::max(prior.variance, r);
    // Values that lie together by luck, nearer than the analyses' own deviations, are no proof of a smaller scatter.
    result.std[i] = std::sqrt(std::max(moderated * excess, moderated * (own + excess) - own));
    if (known) least_dof = std::min(least_dof, prior.dof + d);
  }
  result.dof = least_dof;
  return result;
}

double common_scatter(const std::vector<Samples>& quantities, std::size_t n_takes) {
  std::vector<double> shift(n_takes, 0.0);
  std::vector<const Samples*> whole;
  for (const Samples& q : quantities)
    if (q.value.size() == n_takes) whole.push_back(&q);
  if (n_takes < 2 || whole.size() < 2) return 0.0;
  const auto m = static_cast<double>(whole.size()), n = static_cast<double>(n_takes);
  for (const Samples* q : whole) {
    const double centre = q->mean();
    for (std::size_t i = 0; i < n_takes; ++i) shift[q->take[i]] += (q->value[i] - centre) / m;
  }
  double between = 0.0, residual = 0.0;
  for (const double s : shift) between += s * s / (n - 1.0);
  for (const Samples* q : whole) {
    const double centre = q->mean();
    for (std::size_t i = 0; i < n_takes; ++i) {
      const double left = q->value[i] - centre - shift[q->take[i]];
      residual += left * left / ((m - 1.0) * (n - 1.0));
    }
  }
  if (!(between > 0.0)) return 0.0;
  const double f = m * between / std::max(residual, 1e-300);
  return fisher_tail(f, n - 1.0, (m - 1.0) * (n - 1.0)) < kCommonLevel ? std::sqrt(between) : 0.0;
}

}  // namespace klang::validate::detail
