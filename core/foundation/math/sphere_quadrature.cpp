#include "core/foundation/math/sphere_quadrature.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang {

void gauss_legendre(int n, Eigen::VectorXd& abscissae, Eigen::VectorXd& weights) {
  KLANG_CHECK(n >= 1, "points of a Gauss rule");
  abscissae.resize(n);
  weights.resize(n);
  for (int i = 0; i < (n + 1) / 2; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 0.0;
    for (int step = 0; step < 100; ++step) {
      double before = 1.0, now = x;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * now - (k - 1) * before) / k;
        before = now;
        now = next;
      }
      slope = n * (x * now - before) / (x * x - 1.0);
      const double change = now / slope;
      x -= change;
      if (std::abs(change) <= 1e-16) break;
    }
    if (2 * i + 1 == n) x = 0.0;
    abscissae[i] = -x;
    abscissae[n - 1 - i] = x;
    weights[i] = weights[n - 1 - i] = 2.0 / ((1.0 - x * x) * slope * slope);
  }
}

SphereQuadrature sphere_quadrature(int degree) {
  KLANG_CHECK(degree >= 0, "degree of a sphere rule");
  const int n_theta = degree / 2 + 1, n_phi = degree + 1;
  Eigen::VectorXd z, w;
  gauss_legendre(n_theta, z, w);
  SphereQuadrature rule;
  rule.directions.resize(3, Eigen::Index{n_theta} * n_phi);
  rule.weights.resize(rule.directions.cols());
  Eigen::Index i = 0;
  for (int a = 0; a < n_theta; ++a) {
    const double s = std::sqrt(1.0 - z[a] * z[a]);
    for (int b = 0; b < n_phi; ++b, ++i) {
      const double phi = 2.0 * kPi * b / n_phi;
      rule.directions.col(i) << s * std::cos(phi), s * std::sin(phi), z[a];
      rule.weights[i] = w[a] * 2.0 * kPi / n_phi;
    }
  }
  return rule;
}

}  // namespace klang
