#include "core/sound/waves/spherical_bessel.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/check.hpp"

namespace klang::acoustics {

void spherical_bessel_j(double x, std::span<double> j) {
  KLANG_CHECK(x >= 0.0 && !j.empty(), "spherical_bessel_j needs x >= 0 and room for j_0");
  const auto n_values = static_cast<int>(j.size());
  if (x == 0.0) {
    std::fill(j.begin(), j.end(), 0.0);
    j[0] = 1.0;
    return;
  }
  // Up to order floor(x) the function oscillates and the upward recurrence keeps what it is given; j_floor(x) lies below
  // its first zero, so the ratios above can start from it.
  const int top = n_values - 1;
  const int turning = x < top ? static_cast<int>(x) : top;
  j[0] = std::sin(x) / x;
  if (turning >= 1) j[1] = (j[0] - std::cos(x)) / x;
  for (int n = 1; n < turning; ++n) {
    j[static_cast<std::size_t>(n) + 1] =
        (2 * n + 1) / x * j[static_cast<std::size_t>(n)] - j[static_cast<std::size_t>(n) - 1];
  }
  if (turning == top) return;
  // r_n = j_n / j_{n-1} = 1 / ((2 n + 1) / x - r_{n+1}); a wrong start is damped by r_n^2 per step, and 15 + 10 (x/2)^(1/3)
  // orders beyond the turning point j has fallen below 1e-9 (Airy).
  double ratio = 0.0;
  for (int n = top + 15 + static_cast<int>(10.0 * std::cbrt(0.5 * x)); n > turning; --n) {
    ratio = 1.0 / ((2 * n + 1) / x - ratio);
    if (n <= top) j[static_cast<std::size_t>(n)] = ratio;
  }
  for (int n = turning + 1; n <= top; ++n) j[static_cast<std::size_t>(n)] *= j[static_cast<std::size_t>(n) - 1];
}

void spherical_bessel_y(double x, std::span<double> y) {
  KLANG_CHECK(x > 0.0 && !y.empty(), "spherical_bessel_y needs x > 0 and room for y_0");
  y[0] = -std::cos(x) / x;
  if (y.size() > 1) y[1] = (y[0] - std::sin(x)) / x;
  for (std::size_t n = 1; n + 1 < y.size(); ++n) {
    y[n + 1] = static_cast<double>(2 * n + 1) / x * y[n] - y[n - 1];
    if (!std::isfinite(y[n + 1])) {  // infinity minus infinity would be NaN from here on
      std::fill(y.begin() + static_cast<std::ptrdiff_t>(n) + 1, y.end(), -HUGE_VAL);
      return;
    }
  }
}

void spherical_hankel2(double x, std::span<std::complex<double>> h) {
  constexpr std::size_t kOnStack = 128;
  double j_stack[kOnStack], y_stack[kOnStack];
  std::unique_ptr<double[]> heap;
  double *j = j_stack, *y = y_stack;
  if (h.size() > kOnStack) {
    heap = std::make_unique<double[]>(2 * h.size());
    j = heap.get();
    y = heap.get() + h.size();
  }
  spherical_bessel_j(x, {j, h.size()});
  spherical_bessel_y(x, {y, h.size()});
  for (std::size_t n = 0; n < h.size(); ++n) h[n] = {j[n], -y[n]};
}

}  // namespace klang::acoustics
