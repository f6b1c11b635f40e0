#include "core/foundation/math/spline.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang {
namespace {

// Slope at times[0] of the polynomial through the first n points (n <= 4), by Lagrange; step -1 walks from the end.
double end_slope(const double* times, const double* values, std::ptrdiff_t step, std::size_t n) {
  const auto t = [&](std::size_t i) { return times[static_cast<std::ptrdiff_t>(i) * step]; };
  double slope = 0.0;
  for (std::size_t i = 1; i < n; ++i) {  // derivative at t0 of the i-th Lagrange polynomial
    double weight = 1.0 / (t(i) - t(0));
    for (std::size_t j = 1; j < n; ++j) {
      if (j != i) weight *= (t(0) - t(j)) / (t(i) - t(j));
    }
    slope += weight * (values[static_cast<std::ptrdiff_t>(i) * step] - values[0]);
  }
  return slope;
}

}  // namespace

CubicSpline::CubicSpline(std::vector<double> times_s, std::vector<double> values)
    : times_(std::move(times_s)), values_(std::move(values)), slopes_(values_.size(), 0.0) {
  const std::size_t n = times_.size();
  KLANG_CHECK(n >= 1 && values_.size() == n, "one value a time");
  if (n == 1) return;
  const std::size_t order = std::min<std::size_t>(n, 4);
  slopes_.front() = end_slope(times_.data(), values_.data(), 1, order);
  slopes_.back() = end_slope(&times_.back(), &values_.back(), -1, order);
  // Continuity of the second derivative inside: a tridiagonal system for the slopes, swept once each way.
  std::vector<double> upper(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double left = times_[i] - times_[i - 1], right = times_[i + 1] - times_[i];
    const double rhs =
        3.0 * ((values_[i] - values_[i - 1]) / left * right + (values_[i + 1] - values_[i]) / right * left);
    const double pivot = 2.0 * (left + right) - right * upper[i - 1];
    upper[i] = left / pivot;
    slopes_[i] = (rhs - right * slopes_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i >= 1; --i) slopes_[i] -= upper[i] * slopes_[i + 1];
}

Taylor CubicSpline::at(double time_s) const {
  if (!(time_s >= times_.front())) return values_.front();
  if (!(time_s <= times_.back()) || times_.size() == 1) return values_.back();
  const auto next = std::lower_bound(times_.begin() + 1, times_.end(), time_s);
  const auto i = static_cast<std::size_t>(next - times_.begin()) - 1;
  const double width = times_[i + 1] - times_[i], x = time_s - times_[i];
  const double secant = (values_[i + 1] - values_[i]) / width;
  const double c2 = (3.0 * secant - 2.0 * slopes_[i] - slopes_[i + 1]) / width;
  const double c3 = (slopes_[i] + slopes_[i + 1] - 2.0 * secant) / (width * width);
  return {values_[i] + x * (slopes_[i] + x * (c2 + x * c3)), slopes_[i] + x * (2.0 * c2 + 3.0 * x * c3),
          2.0 * c2 + 6.0 * x * c3};
}

std::vector<double> low_passed(const std::vector<double>& times_s, const std::vector<double>& values,
                               double cutoff_hz) {
  if (!std::isfinite(cutoff_hz)) return values;
  const double sigma_s =
      std::sqrt(std::log(2.0)) / (2.0 * kPi * cutoff_hz);  // the Gaussian's response is -3 dB at the cut-off
  std::vector<double> smooth(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    double w0 = 0.0, w1 = 0.0, w2 = 0.0, y0 = 0.0, y1 = 0.0;
    const auto add = [&](std::size_t j) {
      const double x = (times_s[j] - times_s[i]) / sigma_s, w = std::exp(-0.5 * x * x);
      w0 += w;
      w1 += w * x;
      w2 += w * x * x;
      y0 += w * values[j];
      y1 += w * x * values[j];
      return std::abs(x) < 6.0;
    };
    add(i);
    for (std::size_t j = i; j-- > 0 && add(j);) {
    }
    for (std::size_t j = i + 1; j < values.size() && add(j); ++j) {
    }
    const double det = w0 * w2 - w1 * w1;
    smooth[i] = det > 1e-9 * w0 * w0 ? (w2 * y0 - w1 * y1) / det : values[i];
  }
  return smooth;
}

}  // namespace klang
