#include "core/sound/waves/helmholtz_basis.hpp"

#include <gtest/gtest.h>

#include <boost/math/special_functions/spherical_harmonic.hpp>
#include <cmath>

#include "core/foundation/base/random.hpp"
#include "core/sound/waves/spherical_bessel.hpp"
#include "tests/core/sound/waves/sphere_field.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;

Eigen::Vector3d random_direction(RandomStream& random) {
  const double z = random.uniform(-1.0, 1.0), phi = random.uniform(0.0, 2.0 * kPi), s = std::sqrt(1.0 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

TEST(SphericalHarmonics, MatchBoostWithTheCondonShortleyPhaseToOrder20) {
  RandomStream random(11, 0);
  const SphericalHarmonics harmonics(20);
  Eigen::VectorXcd y(basis_size(20));
  for (int trial = 0; trial < 10; ++trial) {
    const Eigen::Vector3d s = random_direction(random);
    harmonics.evaluate(s, y.data());
    const double theta = std::acos(s.z()), phi = std::atan2(s.y(), s.x());
    for (int n = 0; n <= 20; ++n) {
      for (int m = -n; m <= n; ++m) {
        const Complex exact = boost::math::spherical_harmonic(static_cast<unsigned>(n), m, theta, phi);
        EXPECT_LE(std::abs(y[basis_index(n, m)] - exact), 1e-12) << n << " " << m;
      }
    }
  }
}

TEST(SphericalHarmonics, AreOrthonormalToOrder60) {
  constexpr int kOrder = 60;
  const SphericalHarmonics harmonics(kOrder);
  const SurfaceField sphere = ellipsoid_points(Eigen::Vector3d::Ones(), kOrder + 1);
  Eigen::VectorXcd y(basis_size(kOrder));
  // A few rows of the Gram matrix: the whole of it has 14 million entries.
  const std::pair<int, int> chosen[] = {{0, 0}, {1, -1}, {7, 3}, {30, 29}, {59, 0}, {60, 60}, {60, -60}, {60, 1}};
  Eigen::MatrixXcd rows = Eigen::MatrixXcd::Zero(y.size(), std::size(chosen));
  for (Eigen::Index i = 0; i < sphere.points_m.cols(); ++i) {
    harmonics.evaluate(sphere.points_m.col(i), y.data());
    for (std::size_t j = 0; j < std::size(chosen); ++j) {
      const auto [n, m] = chosen[j];
      rows.col(static_cast<Eigen::Index>(j)) += sphere.weights_m2[i] * std::conj(y[basis_index(n, m)]) * y;
    }
  }
  for (std::size_t j = 0; j < std::size(chosen); ++j)
    rows(basis_index(chosen[j].first, chosen[j].second), static_cast<Eigen::Index>(j)) -= 1.0;
  EXPECT_LE(rows.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SphericalHarmonics, AdditionTheoremHoldsAtThePolesAndBesideThem) {
  // sum_m |Y_n^m|^2 = (2 n + 1) / (4 pi) in every direction, and the gradients: sum_m |grad Y|^2 = n (n + 1) (2 n + 1) / (4 pi).
  constexpr int kOrder = 60;
  const SphericalHarmonics harmonics(kOrder);
  Eigen::VectorXcd y(basis_size(kOrder));
  Eigen::MatrixXcd gradients(basis_size(kOrder), 3);
  for (const Eigen::Vector3d& s :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1e-9, 0, 1).normalized(),
        Eigen::Vector3d(1e-4, 2e-4, -1).normalized(), Eigen::Vector3d(1, 0, 0),
        Eigen::Vector3d(0.3, -0.5, 0.2).normalized()}) {
    harmonics.evaluate(s, y.data(), gradients);
    for (int n = 0; n <= kOrder; ++n) {
      const auto part = y.segment(basis_index(n, -n), 2 * n + 1);
      const auto slope = gradients.middleRows(basis_index(n, -n), 2 * n + 1);
      const double expected = (2 * n + 1) / (4 * kPi);
      EXPECT_LE(std::abs(part.squaredNorm() - expected), 1e-11 * expected) << n;
      EXPECT_LE(std::abs(slope.squaredNorm() - n * (n + 1) * expected), 1e-10 * (n * (n + 1) + 1) * expected) << n;
      EXPECT_LE((slope * s.cast<Complex>()).cwiseAbs().maxCoeff(), 1e-10 * (n + 1)) << "tangent " << n;
    }
  }
}

class BasisGradient : public testing::TestWithParam<Wave> {};

TEST_P(BasisGradient, LadderEqualsProductRule) {
  // grad(f(kr) Y) = k f' s Y + f grad_s Y / r, from the derivative of f and the gradient on the sphere.
  constexpr int kOrder = 60;
  const HelmholtzBasis basis(kOrder);
  const SphericalHarmonics harmonics(kOrder);
  RandomStream random(12, 0);
  Eigen::VectorXcd values, y(basis_size(kOrder));
  Eigen::MatrixX3cd gradients;
  Eigen::MatrixXcd tangent(basis_size(kOrder), 3);
  for (const double r : {0.02, 0.3, 2.0, 7.0}) {
    for (Eigen::Vector3d s :
         {random_direction(random), random_direction(random), Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0, 0, -1)}) {
      const double k = 9.0, x = k * r;
      basis.values_and_gradients(GetParam(), k, r * s, values, gradients);
      harmonics.evaluate(s, y.data(), tangent);
      std::vector<Complex> f(kOrder + 1), slope(kOrder + 1);
      spherical_hankel2(x, f);
      if (GetParam() == Wave::kRegular) {
        for (auto& v : f) v = v.real();
      }
      spherical_derivatives<Complex>(x, f, slope);
      for (int n = 0; n <= kOrder; ++n) {
        const auto un = static_cast<std::size_t>(n);
        const double scale = k * (std::abs(slope[un]) + n * std::abs(f[un]) / x) * std::sqrt(2.0 * n + 1.0);
        for (int m = -n; m <= n; ++m) {
          const Eigen::Index i = basis_index(n, m);
          const Eigen::RowVector3cd exact =
              k * slope[un] * y[i] * s.transpose().cast<Complex>() + f[un] / r * tangent.row(i);
          EXPECT_LE((gradients.row(i) - exact).norm(), 1e-11 * scale) << n << " " << m << " r " << r;
          // scale / k: where f passes through zero, an error of x in its last place is felt through f'.
          EXPECT_LE(std::abs(values[i] - f[un] * y[i]), 1e-14 * (x + 1.0) * scale / k) << n << " " << m << " r " << r;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BothWaves, BasisGradient, testing::Values(Wave::kRegular, Wave::kSingular));

TEST(HelmholtzBasis, RegularGradientAtTheOriginIsThatOfOrderOne) {
  // R_1^0 ~ (k r / 3) sqrt(3 / (4 pi)) cos(theta) near 0.
  const HelmholtzBasis basis(5);
  Eigen::VectorXcd values;
  Eigen::MatrixX3cd gradients;
  basis.values_and_gradients(Wave::kRegular, 3.0, Eigen::Vector3d::Zero(), values, gradients);
  EXPECT_LE(std::abs(values[0] - 1.0 / std::sqrt(4 * kPi)), 1e-15);
  EXPECT_LE(values.tail(values.size() - 1).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LE((gradients.row(basis_index(1, 0)) - Eigen::RowVector3cd(0, 0, std::sqrt(3 / (4 * kPi)))).norm(), 1e-14);
}

TEST(HelmholtzBasis, ExpandsTheGreenFunctionWithMinusIkAndTheConjugate) {
  // Errata 38: G = e^{-ikR} / (4 pi R) = -ik sum S(x) conj(R(y)), not +ik, and not R^{-m} under Condon-Shortley.
  constexpr int kOrder = 60;
  const HelmholtzBasis basis(kOrder);
  const double k = 11.0;
  const Eigen::Vector3d x(0.4, -0.7, 0.9), y(0.1, 0.15, -0.3);
  Eigen::VectorXcd s, r;
  basis.values(Wave::kSingular, k, x, s);
  basis.values(Wave::kRegular, k, y, r);
  const double distance = (x - y).norm();
  const Complex green = std::exp(Complex(0, -k * distance)) / (4 * kPi * distance);
  EXPECT_LE(std::abs(Complex(0, -k) * s.cwiseProduct(r.conjugate()).sum() - green), 1e-12 * std::abs(green));
  Complex printed = 0.0;
  for (int n = 0; n <= kOrder; ++n) {
    for (int m = -n; m <= n; ++m) printed += s[basis_index(n, m)] * r[basis_index(n, -m)];
  }
  EXPECT_GT(std::abs(Complex(0, k) * printed - green), 0.1 * std::abs(green));
}

}  // namespace
}  // namespace klang::acoustics
