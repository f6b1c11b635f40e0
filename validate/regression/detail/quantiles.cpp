#include "validate/regression/detail/quantiles.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"

namespace klang::validate::detail {
namespace {

/// Regularised incomplete beta function by Lentz's continued fraction; x < (a + 1) / (a + b + 2).
/// Source: Abramowitz and Stegun 1964, 26.5.8.
double incomplete_beta(double a, double b, double x) {
  if (!(x > 0.0)) return 0.0;
  const double front =
      std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x)) / a;
  constexpr double kTiny = 1e-300;
  double c = 1.0, d = 1.0 - (a + b) * x / (a + 1.0);
  d = 1.0 / (std::abs(d) > kTiny ? d : kTiny);
  double sum = d;
  for (int m = 1; m < 500; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    for (const double numerator : {even, odd}) {
      d = 1.0 + numerator * d;
      d = 1.0 / (std::abs(d) > kTiny ? d : kTiny);
      c = 1.0 + numerator / c;
      if (!(std::abs(c) > kTiny)) c = kTiny;
      sum *= c * d;
    }
    if (std::abs(c * d - 1.0) < 1e-15) break;
  }
  return front * sum;
}

double any_incomplete_beta(double a, double b, double x) {
  return x < (a + 1.0) / (a + b + 2.0) ? incomplete_beta(a, b, x) : 1.0 - incomplete_beta(b, a, 1.0 - x);
}

/// P(|T| > t).
double student_tail(double t, double dof) { return any_incomplete_beta(0.5 * dof, 0.5, dof / (dof + t * t)); }

/// Where a falling tail passes a probability; in log t, so that heavy tails are reached.
template <class Tail>
double crossing(double probability, Tail&& tail) {
  KLANG_CHECK(probability > 0.0 && probability < 1.0, "a probability between 0 and 1");
  double low = std::log(1e-12), high = std::log(1e12);
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (tail(std::exp(middle)) > probability ? low : high) = middle;
  }
  return std::exp(0.5 * (low + high));
}

}  // namespace

double fisher_tail(double f, double d1, double d2) {
  return any_incomplete_beta(0.5 * d2, 0.5 * d1, d2 / (d2 + d1 * f));
}

double normal_two_sided(double probability) {
  return crossing(probability, [](double z) { return std::erfc(z / std::sqrt(2.0)); });
}

double student_two_sided(double probability, double degrees_of_freedom) {
  KLANG_CHECK(degrees_of_freedom > 0.0, "degrees of freedom above 0");
  if (degrees_of_freedom > 1e6) return normal_two_sided(probability);
  return crossing(probability, [&](double t) { return student_tail(t, degrees_of_freedom); });
}

}  // namespace klang::validate::detail
