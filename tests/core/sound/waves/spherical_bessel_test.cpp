#include "core/sound/waves/spherical_bessel.hpp"

#include <gtest/gtest.h>

#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/bessel_prime.hpp>
#include <cmath>
#include <vector>

namespace klang::acoustics {
namespace {

constexpr int kOrder = 60;

std::vector<double> arguments() {
  std::vector<double> x = {
      1e-3,   1e-2, 0.1,    0.5,  0.999999, 1.0,   2.0,  3.141592653589793, 4.493409457909064, 10.0, 20.0, 20.5, 59.0,
      59.999, 60.0, 60.001, 61.0, 100.0,    199.9, 200.0};
  for (int i = 1; i < 60; ++i) x.push_back(200.0 * i / 60.0 + 0.0173 * i);
  return x;
}

TEST(SphericalBessel, JMatchesBoostToOrder60FromArgument1e3To200) {
  for (double x : arguments()) {
    std::vector<double> j(kOrder + 1);
    spherical_bessel_j(x, j);
    for (unsigned n = 0; n <= kOrder; ++n) {
      const double exact = boost::math::sph_bessel(n, x);
      // Below the turning point j passes through zero: its scale there is the modulus |h_n|.
      const double scale = n > x ? std::abs(exact) : std::hypot(exact, boost::math::sph_neumann(n, x));
      EXPECT_LE(std::abs(j[n] - exact), 2e-13 * scale) << "n " << n << " x " << x;
    }
  }
}

TEST(SphericalBessel, YMatchesBoostToOrder60FromArgument1e3To200) {
  for (double x : arguments()) {
    std::vector<double> y(kOrder + 1);
    spherical_bessel_y(x, y);
    for (unsigned n = 0; n <= kOrder; ++n) {
      const double exact = boost::math::sph_neumann(n, x);
      EXPECT_TRUE(std::isfinite(y[n]));
      EXPECT_LE(std::abs(y[n] - exact), 2e-13 * std::hypot(exact, boost::math::sph_bessel(n, x)))
          << "n " << n << " x " << x;
    }
  }
}

TEST(SphericalBessel, DerivativesMatchBoost) {
  for (double x : arguments()) {
    std::vector<double> j(kOrder + 1), slope(kOrder + 1);
    spherical_bessel_j(x, j);
    spherical_derivatives<double>(x, j, slope);
    for (unsigned n = 0; n <= kOrder; ++n) {
      const double exact = boost::math::sph_bessel_prime(n, x);
      const double scale = n > x ? std::abs(exact) : std::hypot(exact, boost::math::sph_neumann_prime(n, x));
      EXPECT_LE(std::abs(slope[n] - exact), 5e-13 * scale) << "n " << n << " x " << x;
    }
  }
}

TEST(SphericalBessel, HankelHasTheWronskianOfAnOutgoingWave) {
  // j_n y_n' - j_n' y_n = 1 / x^2, that is Im(conj(h) h') = -1 / x^2 for h = j - i y.
  for (double x : arguments()) {
    std::vector<std::complex<double>> h(kOrder + 1), slope(kOrder + 1);
    spherical_hankel2(x, h);
    spherical_derivatives<std::complex<double>>(x, h, slope);
    for (std::size_t n = 0; n <= kOrder; ++n) {
      const double w = h[n].real() * -slope[n].imag() + slope[n].real() * h[n].imag();
      EXPECT_LE(std::abs(w * x * x - 1.0), 1e-12) << "n " << n << " x " << x;
    }
  }
}

TEST(SphericalBessel, JAtZeroIsTheLimit) {
  std::vector<double> j(4);
  spherical_bessel_j(0.0, j);
  EXPECT_EQ(j, (std::vector<double>{1.0, 0.0, 0.0, 0.0}));
}

}  // namespace
}  // namespace klang::acoustics
