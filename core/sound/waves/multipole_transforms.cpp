#include "core/sound/waves/multipole_transforms.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;

// sqrt((2 j)! / ((j + m)! (j - m)!)) cos^a(beta / 2) sin^b(beta / 2) with a + b = 2 j, by logarithms: the factors alone overflow.
double edge(int j, int m, double cosine, double sine, int a, int b) {
  if ((a > 0 && cosine == 0.0) || (b > 0 && sine == 0.0)) return 0.0;
  double log_value = 0.5 * (std::lgamma(2.0 * j + 1) - std::lgamma(j + m + 1.0) - std::lgamma(j - m + 1.0));
  double sign = 1.0;
  if (a > 0) log_value += a * std::log(cosine);
  if (b > 0) {
    log_value += b * std::log(std::abs(sine));
    if (sine < 0.0 && b % 2 != 0) sign = -1.0;
  }
  return sign * std::exp(log_value);
}

// d^j_{m' m}(beta) at the smallest degree j = max(|m'|, |m|).
double first_d(int row, int col, double c, double s) {
  const int j = std::max(std::abs(row), std::abs(col));
  if (row == j) return edge(j, col, c, -s, j + col, j - col);
  if (row == -j) return edge(j, col, c, s, j - col, j + col);
  if (col == j) return edge(j, row, c, s, j + row, j - row);
  return edge(j, row, c, -s, j - row, j + row);
}

}  // namespace

Eigen::VectorXcd rotated(const Eigen::VectorXcd& coefficients, const Eigen::Matrix3d& rotation) {
  const int order = static_cast<int>(std::lround(std::sqrt(static_cast<double>(coefficients.size())))) - 1;
  KLANG_CHECK(order >= 0 && basis_size(order) == coefficients.size(), "coefficients of a whole order");
  if (!((rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() <= 1e-9)) {
    throw InputError("rotation", "is not orthogonal", {}, "R R^T = 1 within 1e-9");
  }
  if (!(rotation.determinant() > 0.0))
    throw InputError("rotation", "is a reflection", "determinant -1", "determinant +1");
  // R = Rz(alpha) Ry(beta) Rz(gamma). With beta at 0 or pi only alpha +- gamma counts: gamma is then 0.
  const double sine = std::hypot(rotation(0, 2), rotation(1, 2)), cosine = rotation(2, 2);
  const double beta = std::atan2(sine, cosine);
  double alpha, gamma = 0.0;
  if (sine > 1e-14) {
    alpha = std::atan2(rotation(1, 2), rotation(0, 2));
    gamma = std::atan2(rotation(2, 1), -rotation(2, 0));
  } else {
    alpha = std::atan2(rotation(1, 0), rotation(1, 1));
  }
  const double c = std::cos(0.5 * beta), s = std::sin(0.5 * beta), cos_beta = std::cos(beta);
  Eigen::VectorXcd result = Eigen::VectorXcd::Zero(coefficients.size());
  for (int col = -order; col <= order; ++col) {
    const Complex by_gamma = std::polar(1.0, -col * gamma);
    for (int row = -order; row <= order; ++row) {
      const Complex phase = by_gamma * std::polar(1.0, -row * alpha);
      const double m = row, mm = col;
      double before = 0.0;
      int j = std::max(std::abs(row), std::abs(col));
      double d = first_d(row, col, c, s);
      for (;; ++j) {
        result[basis_index(j, row)] += phase * d * coefficients[basis_index(j, col)];
        if (j == order) break;
        const double up = j + 1.0;
        const double below = std::sqrt((double(j) * j - m * m) * (double(j) * j - mm * mm));
        const double above = std::sqrt((up * up - m * m) * (up * up - mm * mm));
        const double shift = j == 0 ? 0.0 : m * mm / (j * up);
        const double next =
            (up * (2.0 * j + 1.0) * (cos_beta - shift) * d - (j == 0 ? 0.0 : up / j * below * before)) / above;
        before = d;
        d = next;
      }
    }
  }
  return result;
}

Multipole rotated(const Multipole& multipole, const Eigen::Matrix3d& rotation) {
  Multipole result = multipole;
  result.coefficients_pa = rotated(multipole.coefficients_pa, rotation);
  result.centre_m = rotation * multipole.centre_m;
  return result;
}

Multipole with_size_factor(const Multipole& multipole, double gamma, ModalUnit unit) {
  checked_open("size", "gamma", gamma, 0.0, 1e6);
  Multipole result = multipole;
  result.centre_m *= gamma;
  result.wavenumber_per_m /= gamma;
  result.coefficients_pa *= std::pow(gamma, unit == ModalUnit::kVelocity ? -1.5 : -2.5);
  return result;
}

}  // namespace klang::acoustics
