#include "core/foundation/math/triangle_rules.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang {
namespace {

/// Gauss-Legendre points on [0, 1], by Newton steps on the Legendre polynomial.
std::vector<std::array<double, 2>> gauss(int n) {
  std::vector<std::array<double, 2>> rule;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int step = 0; step < 50; ++step) {
      double previous = 1.0, value = x;
      for (int j = 2; j <= n; ++j) {
        const double next = ((2 * j - 1) * x * value - (j - 1) * previous) / j;
        previous = value;
        value = next;
      }
      slope = n * (x * value - previous) / (x * x - 1.0);
      x -= value / slope;
    }
    rule.push_back({0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)});
  }
  return rule;
}

/// Centre 1 - u, the ends of the edge u (1 - v) and u v; area element 2 u du dv.
std::vector<TrianglePoint> make_boundary() {
  std::vector<TrianglePoint> rule;
  for (int corner = 0; corner < 3; ++corner)
    for (const auto& [s, ws] : gauss(5))
      for (const auto& [v, wv] : gauss(6)) {
        const double u = 1.0 - s * s, centre = (1.0 - u) / 3.0;
        TrianglePoint point{{centre, centre, centre}, 2.0 * u * 2.0 * s * ws * wv / 3.0};
        point.at[corner] += u * (1.0 - v);
        point.at[(corner + 1) % 3] += u * v;
        rule.push_back(point);
      }
  return rule;
}

std::vector<TrianglePoint> make_seven() {
  const double root = std::sqrt(15.0);
  std::vector<TrianglePoint> rule{{{1.0 / 3, 1.0 / 3, 1.0 / 3}, 9.0 / 40}};
  for (const double sign : {1.0, -1.0}) {
    const double a = (6.0 + sign * root) / 21.0, w = (155.0 + sign * root) / 1200.0;
    for (int corner = 0; corner < 3; ++corner) {
      TrianglePoint point{{a, a, a}, w};
      point.at[corner] = 1.0 - 2.0 * a;
      rule.push_back(point);
    }
  }
  return rule;
}

}  // namespace

std::span<const TrianglePoint> three_points() {
  static const std::array<TrianglePoint, 3> kRule{{{{2.0 / 3, 1.0 / 6, 1.0 / 6}, 1.0 / 3},
                                                   {{1.0 / 6, 2.0 / 3, 1.0 / 6}, 1.0 / 3},
                                                   {{1.0 / 6, 1.0 / 6, 2.0 / 3}, 1.0 / 3}}};
  return kRule;
}

std::span<const TrianglePoint> seven_points() {
  static const std::vector<TrianglePoint> kRule = make_seven();
  return kRule;
}

std::span<const TrianglePoint> boundary_points() {
  static const std::vector<TrianglePoint> kRule = make_boundary();
  return kRule;
}

}  // namespace klang
