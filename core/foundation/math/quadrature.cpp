#include "core/foundation/math/quadrature.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang {
namespace {

/// P_n and P_{n-1} at x.
struct LegendrePair {
  double top, below;
};

LegendrePair legendre(int n, double x) {
  double below = 1.0, top = x;
  for (int k = 2; k <= n; ++k) {
    const double next = ((2.0 * k - 1.0) * x * top - (k - 1.0) * below) / k;
    below = top;
    top = next;
  }
  return {top, below};
}

}  // namespace

QuadratureRule gauss_rule(int n) {
  KLANG_CHECK(n >= 1 && n <= 200, "gauss_rule: n from 1 to 200");
  QuadratureRule rule{Eigen::VectorXd::Zero(n), Eigen::VectorXd::Constant(n, 2.0)};
  if (n == 1) return rule;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 0.0;
    for (int step = 0; step < 50; ++step) {
      const LegendrePair p = legendre(n, x);
      slope = n * (x * p.top - p.below) / (x * x - 1.0);
      const double move = p.top / slope;
      x -= move;
      if (std::abs(move) <= 1e-16) break;
    }
    rule.points[i] = x;
    rule.weights[i] = 2.0 / ((1.0 - x * x) * slope * slope);
  }
  return rule;
}

QuadratureRule lobatto_rule(int n) {
  KLANG_CHECK(n >= 2 && n <= 200, "lobatto_rule: n from 2 to 200");
  QuadratureRule rule{Eigen::VectorXd(n), Eigen::VectorXd(n)};
  const int m = n - 1;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(kPi * i / m);
    for (int step = 0; step < 100 && i > 0 && i < m; ++step) {
      // Roots of (1 - x^2) P_m'(x) = m (P_{m-1} - x P_m), whose slope is -m (m + 1) P_m.
      const LegendrePair p = legendre(m, x);
      const double move = (x * p.top - p.below) / (n * p.top);
      x -= move;
      if (std::abs(move) <= 1e-16) break;
    }
    rule.points[i] = x;
    rule.weights[i] = 2.0 / (m * n * std::pow(legendre(m, x).top, 2));
  }
  return rule;
}

LagrangeTable lagrange_table(const Eigen::VectorXd& nodes, const Eigen::VectorXd& at) {
  const Eigen::Index n = nodes.size(), m = at.size();
  LagrangeTable table{Eigen::MatrixXd::Ones(m, n), Eigen::MatrixXd::Zero(m, n)};
  for (Eigen::Index q = 0; q < m; ++q) {
    for (Eigen::Index i = 0; i < n; ++i) {
      for (Eigen::Index j = 0; j < n; ++j) {
        if (j == i) continue;
        double product = 1.0 / (nodes[i] - nodes[j]);
        table.value(q, i) *= (at[q] - nodes[j]) / (nodes[i] - nodes[j]);
        for (Eigen::Index k = 0; k < n; ++k) {
          if (k != i && k != j) product *= (at[q] - nodes[k]) / (nodes[i] - nodes[k]);
        }
        table.slope(q, i) += product;
      }
    }
  }
  return table;
}

}  // namespace klang
