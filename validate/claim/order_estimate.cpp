#include "validate/claim/order_estimate.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/math/statistics.hpp"

namespace klang::validate {
namespace {

constexpr std::size_t kLeastAfterTrimming = 4;
constexpr double kPreAsymptotic = 0.25, kAsymptotic = 0.15;

double abscissa(double step, Convergence kind) { return kind == Convergence::kGeometric ? -step : std::log(step); }

struct Line {
  double slope = 0.0, slope_std = 0.0;
};

Line fitted(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double mean_x = 0.0, mean_y = 0.0, sxx = 0.0, sxy = 0.0, residual = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) mean_x += x[i] / n, mean_y += y[i] / n;
  for (std::size_t i = 0; i < x.size(); ++i) {
    sxx += (x[i] - mean_x) * (x[i] - mean_x);
    sxy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  Line line{sxy / sxx, 0.0};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double r = y[i] - mean_y - line.slope * (x[i] - mean_x);
    residual += r * r;
  }
  if (x.size() > 2) line.slope_std = std::sqrt(residual / (n - 2.0) / sxx);
  return line;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

}  // namespace

OrderEstimate estimate_order(const std::vector<double>& step, const std::vector<double>& error, Convergence kind,
                             double error_floor) {
  KLANG_CHECK(step.size() == error.size(), "one error per level");
  const std::size_t n = step.size();
  OrderEstimate result;
  result.excluded.resize(n);
  result.pairwise.resize(n);
  std::vector<std::size_t> used;
  bool at_floor = false;
  for (std::size_t i = 0; i < n; ++i) {
    const bool usable = std::isfinite(error[i]) && error[i] > 0.0;
    at_floor = at_floor || (usable && error[i] <= error_floor);
    if (!usable) {
      result.excluded[i] = "no error";
    } else if (at_floor) {
      result.excluded[i] = "floor";
    } else {
      used.push_back(i);
    }
  }
  const auto slope_between = [&](std::size_t a, std::size_t b) {
    return (std::log(error[b]) - std::log(error[a])) / (abscissa(step[b], kind) - abscissa(step[a], kind));
  };
  for (std::size_t k = 1; k < used.size(); ++k) result.pairwise[used[k]] = slope_between(used[k - 1], used[k]);
  while (used.size() > kLeastAfterTrimming) {
    std::vector<double> finer;
    for (std::size_t k = 2; k < used.size(); ++k) finer.push_back(*result.pairwise[used[k]]);
    const double middle = median(finer);
    if (std::abs(*result.pairwise[used[1]] - middle) <= kPreAsymptotic * std::abs(middle)) break;
    result.excluded[used.front()] = "pre-asymptotic";
    used.erase(used.begin());
  }
  result.n_used = static_cast<int>(used.size());
  if (used.size() < 2 || kind == Convergence::kRoundOff) {
    result.status = OrderStatus::kTooFewLevels;
    return result;
  }
  std::vector<double> x, y;
  for (const std::size_t i : used) x.push_back(abscissa(step[i], kind)), y.push_back(std::log(error[i]));
  const Line line = fitted(x, y);
  result.observed_order = line.slope;
  result.status = OrderStatus::kEstimated;
  if (used.size() >= 3) {
    const double half = student_t_975(static_cast<double>(used.size() - 2)) * line.slope_std;
    result.ci95 = {line.slope - half, line.slope + half};
    const double last = *result.pairwise[used.back()], before = *result.pairwise[used[used.size() - 2]];
    result.asymptotic = std::abs(last - before) <= kAsymptotic * std::abs(line.slope);
  }
  return result;
}

std::optional<GridConvergence> grid_convergence(const std::array<double, 3>& h, const std::array<double, 3>& value,
                                                double safety) {
  KLANG_CHECK(0.0 < h[0] && h[0] < h[1] && h[1] < h[2], "three different steps, the finest first");
  const double r21 = h[1] / h[0], r32 = h[2] / h[1];
  const double e21 = value[1] - value[0], e32 = value[2] - value[1];
  const double ratio = e32 / e21;
  if (!std::isfinite(ratio) || ratio == 0.0 || value[0] == 0.0 || value[1] == 0.0) return {};
  const double sign = ratio > 0.0 ? 1.0 : -1.0;
  // Celik's fixed point can wander for r21 far from r32; its equation f(p) = 0 is solved by bisection instead:
  //   f(p) = p ln r21 - ln|ratio| - ln((r21^p - s) / (r32^p - s))
  const auto excess = [&](double p) {
    return p * std::log(r21) - std::log(std::abs(ratio)) -
           std::log((std::pow(r21, p) - sign) / (std::pow(r32, p) - sign));
  };
  double low = 1e-3, high = 20.0;
  const double at_low = excess(low), at_high = excess(high);
  if (!(at_low * at_high <= 0.0)) return {};
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    ((excess(middle) <= 0.0) == (at_low <= 0.0) ? low : high) = middle;
  }
  GridConvergence result;
  result.oscillating = sign < 0.0;
  result.order = 0.5 * (low + high);
  const double gain21 = std::pow(r21, result.order), gain32 = std::pow(r32, result.order);
  result.extrapolated = (gain21 * value[0] - value[1]) / (gain21 - 1.0);
  result.gci_fine = safety * std::abs(e21 / value[0]) / (gain21 - 1.0);
  result.gci_coarse = safety * std::abs(e32 / value[1]) / (gain32 - 1.0);
  result.asymptotic_ratio = result.gci_coarse / (gain21 * result.gci_fine);
  return result;
}

std::optional<RichardsonLimit> richardson_limit(const std::vector<double>& h, const std::vector<double>& value) {
  KLANG_CHECK(h.size() == value.size(), "one value per level");
  const std::size_t n = h.size();
  if (n < 3) return {};
  const double h0 = *std::max_element(h.begin(), h.end());
  double limit = 0.0;
  // Sum of squared residuals of value = limit + C (h/h0)^p.
  const auto misfit = [&](double p) {
    double mean_x = 0.0, mean_y = 0.0, sxx = 0.0, sxy = 0.0, sum = 0.0;
    std::vector<double> x(n);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] = std::pow(h[i] / h0, p);
      mean_x += x[i] / static_cast<double>(n), mean_y += value[i] / static_cast<double>(n);
    }
    for (std::size_t i = 0; i < n; ++i) {
      sxx += (x[i] - mean_x) * (x[i] - mean_x);
      sxy += (x[i] - mean_x) * (value[i] - mean_y);
    }
    const double slope = sxy / sxx;
    limit = mean_y - slope * mean_x;
    for (std::size_t i = 0; i < n; ++i) {
      const double r = value[i] - limit - slope * x[i];
      sum += r * r;
    }
    return sum;
  };
  constexpr double kLow = 0.2, kHigh = 12.0;
  constexpr int kSteps = 236;
  double best = kLow, least = misfit(kLow);
  for (int i = 1; i <= kSteps; ++i) {
    const double p = kLow + (kHigh - kLow) * i / kSteps;
    if (const double m = misfit(p); m < least) least = m, best = p;
  }
  const double width = (kHigh - kLow) / kSteps;
  if (best <= kLow || best >= kHigh - 0.5 * width) return {};
  double low = best - width, high = best + width;
  for (int i = 0; i < 100; ++i) {
    const double a = low + (high - low) / 3.0, b = high - (high - low) / 3.0;
    if (misfit(a) < misfit(b)) {
      high = b;
    } else {
      low = a;
    }
  }
  const double order = 0.5 * (low + high);
  misfit(order);
  return RichardsonLimit{limit, order};
}

}  // namespace klang::validate
