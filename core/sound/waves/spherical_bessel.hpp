#pragma once
#include <complex>
#include <span>

namespace klang::acoustics {

/// Spherical Bessel functions j_0(x) ... j_{n-1}(x), n = j.size(), x >= 0 (the exact limit at 0). Upward recurrence up to
/// order x, above it the ratios j_n / j_{n-1} by downward recurrence (Miller), which the upward one would lose.
/// Relative error below 1e-13 of the modulus |h_n| for orders to 60 and x to 200.
void spherical_bessel_j(double x, std::span<double> j);

/// Spherical Neumann functions y_0(x) ... , x > 0, upward. Finite at order 60 down to x = 1e-3; smaller x at high order
/// overflows to -infinity.
void spherical_bessel_y(double x, std::span<double> y);

/// h_n^(2) = j_n - i y_n, outgoing for e^{+i omega t}; x > 0. Both parts are as accurate as j and y by themselves.
void spherical_hankel2(double x, std::span<std::complex<double>> h);

/// Derivatives with respect to x of any of the three families, from their values at orders 0 ... n - 1; x > 0, n >= 2:
///   f_0' = -f_1,  f_n' = f_{n-1} - (n + 1) / x f_n
template <typename Value>
void spherical_derivatives(double x, std::span<const Value> f, std::span<Value> derivative) {
  derivative[0] = -f[1];
  for (std::size_t n = 1; n < derivative.size(); ++n) {
    derivative[n] = f[n - 1] - static_cast<double>(n + 1) / x * f[n];
  }
}

}  // namespace klang::acoustics
