#include "core/sound/dual_domain/detail/wave_rows.hpp"

#include <cmath>
#include <numbers>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/waves/spherical_bessel.hpp"

namespace klang::bubble::detail {
namespace {

using acoustics::basis_index;
using Complex = std::complex<double>;

/// j_l(u) / u^l or h_l(u) / u^l for l = 0 ... 3.
template <class Scalar>
using Radial = std::array<Scalar, 4>;

Radial<double> regular_radial(double u) {
  Radial<double> f{};
  if (u < 0.5) {
    // j_l / u^l = sum (-u^2/2)^s / (s! (2l + 2s + 1)!!), which the recurrence would divide 0 by 0 for.
    double start = 1.0;
    for (int l = 0; l < 4; ++l) {
      start /= 2 * l + 1;
      double term = start, sum = start;
      for (int s = 1; s < 9; ++s) {
        term *= -0.5 * u * u / (s * (2 * l + 2 * s + 1));
        sum += term;
      }
      f[static_cast<std::size_t>(l)] = sum;
    }
    return f;
  }
  acoustics::spherical_bessel_j(u, f);
  double power = 1.0;
  for (double& value : f) {
    value /= power;
    power *= u;
  }
  return f;
}

Radial<Complex> singular_radial(double u) {
  const Complex wave(std::cos(u), -std::sin(u));
  const double inverse = 1.0 / u;
  Complex before = wave * inverse, now = Complex(-wave.imag(), wave.real()) * inverse;  // h_{-1}, h_0
  Radial<Complex> f;
  double power = 1.0;
  for (int l = 0; l < 4; ++l) {
    f[static_cast<std::size_t>(l)] = now * power;
    const Complex next = (2 * l + 1) * inverse * now - before;
    before = now;
    now = next;
    power *= inverse;
  }
  return f;
}

const double kMono = 1.0 / std::sqrt(4.0 * kPi), kDi = std::sqrt(3.0 / (4.0 * kPi)),
             kQuad = std::sqrt(15.0 / (4.0 * kPi));
const double kRoot3 = std::numbers::sqrt3;

template <class Scalar>
void quadrupole(double k, const Eigen::Vector3d& r, const Radial<Scalar>& f, Scalar* out) {
  const double x = r.x(), y = r.y(), z = r.z();
  out[0] = kMono * f[0];
  const Scalar di = kDi * k * f[1], quad = kQuad * k * k * f[2];
  out[1] = di * x;
  out[2] = di * y;
  out[3] = di * z;
  out[4] = quad * (x * y);
  out[5] = quad * (y * z);
  out[6] = quad * (z * x);
  out[7] = quad * (0.5 * (x * x - y * y));
  out[8] = quad * ((2.0 * z * z - x * x - y * y) / (2.0 * kRoot3));
}

/// The gradient of f_l = F_l(u) / u^l is -k^2 r f_{l+1}.
template <class Scalar>
void quadrupole_slopes(double k, const Eigen::Vector3d& r, const Eigen::Vector3d& n, const Radial<Scalar>& f,
                       Scalar* out) {
  const double x = r.x(), y = r.y(), z = r.z(), rn = r.dot(n), ksq = k * k;
  out[0] = -kMono * ksq * rn * f[1];
  const Scalar di = kDi * k * f[1], di_down = kDi * k * ksq * rn * f[2];
  out[1] = di * n.x() - di_down * x;
  out[2] = di * n.y() - di_down * y;
  out[3] = di * n.z() - di_down * z;
  const Scalar quad = kQuad * ksq * f[2], quad_down = kQuad * ksq * ksq * rn * f[3];
  out[4] = quad * (x * n.y() + y * n.x()) - quad_down * (x * y);
  out[5] = quad * (y * n.z() + z * n.y()) - quad_down * (y * z);
  out[6] = quad * (z * n.x() + x * n.z()) - quad_down * (z * x);
  out[7] = quad * (x * n.x() - y * n.y()) - quad_down * (0.5 * (x * x - y * y));
  out[8] = quad * ((2.0 * z * n.z() - x * n.x() - y * n.y()) / kRoot3) -
           quad_down * ((2.0 * z * z - x * x - y * y) / (2.0 * kRoot3));
}

}  // namespace

RegularRows::RegularRows(int order, double wavenumber_per_m)
    : order_(order), wavenumber_per_m_(wavenumber_per_m), harmonics_(order + 1) {
  for (int n = 0; n <= order; ++n)
    for (int m = 0; m <= n; ++m) ladders_.emplace_back(n, m);
}

RegularRows::Scratch RegularRows::scratch() const {
  return {Eigen::VectorXcd(acoustics::basis_size(order_ + 1)),
          std::vector<double>(static_cast<std::size_t>(order_) + 2)};
}

void RegularRows::fill(const Eigen::Vector3d& r_m, Scratch& scratch) const {
  const double distance = r_m.norm();
  acoustics::spherical_bessel_j(wavenumber_per_m_ * distance, scratch.bessel);
  harmonics_.evaluate(distance > 0.0 ? Eigen::Vector3d(r_m / distance) : Eigen::Vector3d::UnitZ(),
                      scratch.harmonics.data());
  for (int n = 0; n <= order_ + 1; ++n)
    for (int m = 0; m <= n; ++m) scratch.harmonics[basis_index(n, m)] *= scratch.bessel[static_cast<std::size_t>(n)];
}

void RegularRows::values(const Eigen::Vector3d& r_m, Scratch& scratch, double* row) const {
  fill(r_m, scratch);
  for (int n = 0; n <= order_; ++n) {
    row[basis_index(n, 0)] = scratch.harmonics[basis_index(n, 0)].real();
    for (int m = 1; m <= n; ++m) {
      const Complex f = std::numbers::sqrt2 * scratch.harmonics[basis_index(n, m)];
      row[basis_index(n, m)] = f.real();
      row[basis_index(n, -m)] = f.imag();
    }
  }
}

void RegularRows::slopes(const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal, Scratch& scratch,
                         double* row) const {
  fill(r_m, scratch);
  const Eigen::VectorXcd& f = scratch.harmonics;
  const double k = wavenumber_per_m_, nz = k * normal.z();
  const Complex plus_factor(0.5 * k * normal.x(), -0.5 * k * normal.y()), minus_factor = std::conj(plus_factor);
  const auto times = [](const Complex& a, const Complex& b) {  // without the checks for infinities
    return Complex(a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real());
  };
  std::size_t at = 0;
  for (int n = 0; n <= order_; ++n) {
    for (int m = 0; m <= n; ++m, ++at) {
      const acoustics::Ladder& ladder = ladders_[at];
      Complex dz = -ladder.z_up * f[basis_index(n + 1, m)];
      if (m <= n - 1) dz += ladder.z_down * f[basis_index(n - 1, m)];
      Complex plus = ladder.plus_up * f[basis_index(n + 1, m + 1)];
      if (m + 1 <= n - 1) plus += ladder.plus_down * f[basis_index(n - 1, m + 1)];
      Complex minus;
      if (m >= 1) {
        minus = -ladder.minus_up * f[basis_index(n + 1, m - 1)];
        if (n >= 1 && m - 1 <= n - 1) minus -= ladder.minus_down * f[basis_index(n - 1, m - 1)];
      } else {  // F^{-1} = -conj(F^1) where the radial part is real
        minus = ladder.minus_up * std::conj(f[basis_index(n + 1, 1)]);
        if (n >= 2) minus += ladder.minus_down * std::conj(f[basis_index(n - 1, 1)]);
      }
      const Complex slope = times(plus_factor, plus) + times(minus_factor, minus) + nz * dz;
      if (m == 0) {
        row[basis_index(n, 0)] = slope.real();
      } else {
        row[basis_index(n, m)] = std::numbers::sqrt2 * slope.real();
        row[basis_index(n, -m)] = std::numbers::sqrt2 * slope.imag();
      }
    }
  }
}

void regular_quadrupole(double wavenumber_per_m, const Eigen::Vector3d& r_m, double* values) {
  quadrupole(wavenumber_per_m, r_m, regular_radial(wavenumber_per_m * r_m.norm()), values);
}

void regular_quadrupole_slopes(double wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal,
                               double* slopes) {
  quadrupole_slopes(wavenumber_per_m, r_m, normal, regular_radial(wavenumber_per_m * r_m.norm()), slopes);
}

void singular_quadrupole(double wavenumber_per_m, const Eigen::Vector3d& r_m, Complex* values) {
  quadrupole(wavenumber_per_m, r_m, singular_radial(wavenumber_per_m * r_m.norm()), values);
}

void singular_quadrupole_slopes(double wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal,
                                Complex* slopes) {
  quadrupole_slopes(wavenumber_per_m, r_m, normal, singular_radial(wavenumber_per_m * r_m.norm()), slopes);
}

Complex monopole(double wavenumber_per_m, const Eigen::Vector3d& r_m) {
  const double r = r_m.norm();
  return -std::polar(1.0 / (4.0 * kPi * r), -wavenumber_per_m * r);
}

Complex monopole_slope(double wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal) {
  const double r = r_m.norm();
  return monopole(wavenumber_per_m, r_m) * Complex(-1.0 / r, -wavenumber_per_m) * (r_m.dot(normal) / r);
}

}  // namespace klang::bubble::detail
