#include "core/sound/soundbank/detail/octant.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/math/quadrature.hpp"

namespace klang::soundbank::detail {
namespace {

const QuadratureRule& cached_gauss_rule(int n) {
  thread_local std::vector<QuadratureRule> rules(201);
  if (rules[static_cast<std::size_t>(n)].points.size() == 0) rules[static_cast<std::size_t>(n)] = gauss_rule(n);
  return rules[static_cast<std::size_t>(n)];
}

}  // namespace

Eigen::Vector3d Octant::direction(Eigen::Index i) const {
  const double t = theta[i / phi.size()], p = phi[i % phi.size()];
  return {std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
}

Octant even_octant(int n_theta, int n_phi) {
  const QuadratureRule rule = gauss_rule(2 * n_theta);
  Octant octant{rule.points.tail(n_theta).array().acos(), Eigen::VectorXd(n_phi), rule.weights.tail(n_theta),
                Eigen::VectorXd::Constant(n_phi, 0.5 * kPi / n_phi)};
  for (int j = 0; j < n_phi; ++j) octant.phi[j] = (j + 0.5) * 0.5 * kPi / n_phi;
  return octant;
}

void crowded_rule(double centre, double near, double far, double density, Eigen::VectorXd& points,
                  Eigen::VectorXd& weights) {
  const auto s_of = [&](double x) { return std::asinh((x - centre) / near) + (x - centre) / far; };
  const auto slope = [&](double x) { return 1.0 / std::sqrt((x - centre) * (x - centre) + near * near) + 1.0 / far; };
  const double first = s_of(0.0), last = s_of(0.5 * kPi);
  const int n = std::clamp(static_cast<int>(std::ceil(density * (last - first))), 4, 200);
  const QuadratureRule& rule = cached_gauss_rule(n);
  points.resize(n);
  weights.resize(n);
  double low = 0.0, s_low = first;
  for (int i = 0; i < n; ++i) {
    const double s = first + 0.5 * (1.0 + rule.points[i]) * (last - first);
    double high = 0.5 * kPi, x = std::min(low + (s - s_low) / slope(low), high);
    for (int step = 0; step < 100; ++step) {  // Newton between bounds
      const double wrong = s_of(x) - s;
      (wrong > 0.0 ? high : low) = x;
      double next = x - wrong / slope(x);
      if (!(next >= low && next <= high)) next = 0.5 * (low + high);
      const double moved = std::abs(next - x);
      x = next;
      if (moved <= 1e-9 * near) break;  // the error left is of second order
    }
    points[i] = low = x;
    s_low = s;
    weights[i] = rule.weights[i] * 0.5 * (last - first) / slope(x);
  }
}

ClassHarmonics::ClassHarmonics(int mode_class, int degree)
    : degree_(degree), step_(mode_class >> 2 & 1), sine_((mode_class & 2) != 0) {
  const int m_parity = (mode_class & 1) ^ (mode_class >> 1 & 1);
  Eigen::Index columns = 0;
  for (int m = m_parity; m + step_ <= degree; m += 2) {
    if (sine_ && m == 0) continue;
    orders_.push_back(m);
    first_.push_back(columns);
    columns += (degree - m - step_) / 2 + 1;
  }
  first_.push_back(columns);
  for (const int m : orders_)
    for (int n = m; n <= degree; ++n) {
      const double square = static_cast<double>(n + 1) * (n + 1) - static_cast<double>(m) * m;
      const double up = std::sqrt((4.0 * (n + 1) * (n + 1) - 1.0) / square);
      const double down =
          n > m ? std::sqrt((static_cast<double>(n) * n - static_cast<double>(m) * m) / (4.0 * n * n - 1.0)) : 0.0;
      recurrence_.push_back({up, up * down});
    }
}

void ClassHarmonics::legendre(double theta, double* values) const {
  const double z = std::cos(theta), s = std::sin(theta);
  double diagonal = std::sqrt(0.25 / kPi);  // of m = 0
  const std::pair<double, double>* coefficient = recurrence_.data();
  int m = 0;
  for (std::size_t i = 0; i < orders_.size(); ++i) {
    for (; m < orders_[i]; ++m) diagonal *= s * std::sqrt((2.0 * m + 3.0) / (2.0 * m + 2.0));
    double before = 0.0, now = diagonal;
    Eigen::Index at = first_[i];
    for (int n = m; n <= degree_; ++n) {
      if ((n - m) % 2 == step_) values[at++] = now;
      const double next = coefficient->first * z * now - coefficient->second * before;
      ++coefficient;
      before = now;
      now = next;
    }
  }
}

void ClassHarmonics::around(double phi, double* values) const {
  if (orders_.empty()) return;
  const std::complex<double> step = std::polar(1.0, 2.0 * phi);
  std::complex<double> turn = std::polar(1.0, orders_[0] * phi);
  for (std::size_t i = 0; i < orders_.size(); ++i, turn *= step) values[i] = sine_ ? turn.imag() : turn.real();
}

}  // namespace klang::soundbank::detail
