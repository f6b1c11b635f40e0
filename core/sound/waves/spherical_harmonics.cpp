#include "core/sound/waves/spherical_harmonics.hpp"

#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::acoustics {
namespace {
using Complex = std::complex<double>;
std::size_t half_index(int n, int m) {
  return static_cast<std::size_t>(n) * static_cast<std::size_t>(n + 1) / 2 + static_cast<std::size_t>(m);
}
}  // namespace

SphericalHarmonics::SphericalHarmonics(int order) : order_(order) {
  KLANG_CHECK(order >= 0, "order of spherical harmonics");
  diagonal_.resize(static_cast<std::size_t>(order) + 1);
  by_z_.resize(half_index(order, order) + 1);
  by_previous_.resize(by_z_.size());
  diagonal_[0] = 1.0 / std::sqrt(4.0 * kPi);
  for (int m = 1; m <= order; ++m) {
    diagonal_[static_cast<std::size_t>(m)] =
        -std::sqrt((2.0 * m + 1.0) / (2.0 * m)) * diagonal_[static_cast<std::size_t>(m) - 1];
  }
  for (int m = 0; m <= order; ++m) {
    for (int n = m + 1; n <= order; ++n) {
      const double span = static_cast<double>(n - m) * (n + m);
      by_z_[half_index(n, m)] = std::sqrt((2.0 * n - 1.0) * (2.0 * n + 1.0) / span);
      by_previous_[half_index(n, m)] =
          n == m + 1 ? 0.0 : std::sqrt((2.0 * n + 1.0) * (n - 1.0 - m) * (n - 1.0 + m) / ((2.0 * n - 3.0) * span));
    }
  }
}

void SphericalHarmonics::evaluate(const Eigen::Vector3d& direction, Complex* values) const {
  const double z = direction.z();
  Complex power = 1.0;  // (s_x + i s_y)^m
  for (int m = 0; m <= order_; ++m) {
    const double sign = m % 2 == 0 ? 1.0 : -1.0;
    double before = 0.0, now = diagonal_[static_cast<std::size_t>(m)];
    for (int n = m;; ++n) {
      const Complex y = now * power;
      values[basis_index(n, m)] = y;
      values[basis_index(n, -m)] = sign * std::conj(y);
      if (n == order_) break;
      const double next = by_z_[half_index(n + 1, m)] * z * now - by_previous_[half_index(n + 1, m)] * before;
      before = now;
      now = next;
    }
    power = {power.real() * direction.x() - power.imag() * direction.y(),
             power.real() * direction.y() + power.imag() * direction.x()};
  }
}

void SphericalHarmonics::evaluate(const Eigen::Vector3d& direction, Complex* values,
                                  Eigen::Ref<Eigen::MatrixXcd> gradients) const {
  KLANG_CHECK(gradients.rows() == basis_size(order_) && gradients.cols() == 3, "gradients are basis_size x 3");
  evaluate(direction, values);
  const double x = direction.x(), y = direction.y(), z = direction.z();
  Complex power = 1.0, power_below = 0.0;  // (s_x + i s_y)^m and m (s_x + i s_y)^(m-1)
  for (int m = 0; m <= order_; ++m) {
    const double sign = m % 2 == 0 ? 1.0 : -1.0;
    double before = 0.0, now = diagonal_[static_cast<std::size_t>(m)];
    double slope_before = 0.0, slope = 0.0;  // d q_n^m / d s_z
    for (int n = m;; ++n) {
      // Gradient of the polynomial q(s_z) (s_x + i s_y)^m in space, then its part tangent to the sphere.
      Eigen::Vector3cd g(now * power_below, now * power_below * Complex(0.0, 1.0), slope * power);
      g -= (x * g[0] + y * g[1] + z * g[2]) * direction.cast<Complex>();
      gradients.row(basis_index(n, m)) = g.transpose();
      gradients.row(basis_index(n, -m)) = sign * g.conjugate().transpose();
      if (n == order_) break;
      const double a = by_z_[half_index(n + 1, m)], b = by_previous_[half_index(n + 1, m)];
      const double next = a * z * now - b * before;
      const double slope_next = a * (now + z * slope) - b * slope_before;
      before = now;
      now = next;
      slope_before = slope;
      slope = slope_next;
    }
    power_below = static_cast<double>(m + 1) * power;
    power = {power.real() * x - power.imag() * y, power.real() * y + power.imag() * x};
  }
}

}  // namespace klang::acoustics
