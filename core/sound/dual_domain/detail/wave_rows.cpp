#include "core/sound/dual_domain/detail/wave_rows.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <type_traits>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/waves/spherical_bessel.hpp"

namespace klang::bubble::detail {
namespace {

using acoustics::basis_index;
using Complex = std::complex<double>;

/// j_l(u) / u^l or h_l(u) / u^l for l = 0 ... 3.
template <class Scalar>
using Radial = std::array<Scalar, 4>;

/// j_0(z), j_1(z), ...: as acoustics::spherical_bessel_j, for complex z of small imaginary part.
void complex_bessel_j(Complex z, std::span<Complex> j) {
  const int top = static_cast<int>(j.size()) - 1;
  if (z == 0.0) {
    std::fill(j.begin(), j.end(), 0.0);
    j[0] = 1.0;
    return;
  }
  const double size = std::abs(z);
  const int turning = size < top ? static_cast<int>(size) : top;
  j[0] = std::sin(z) / z;
  if (turning >= 1) j[1] = (j[0] - std::cos(z)) / z;
  for (std::size_t n = 1; static_cast<int>(n) < turning; ++n)
    j[n + 1] = static_cast<double>(2 * n + 1) / z * j[n] - j[n - 1];
  Complex ratio = 0.0;
  for (int n = top + 15 + static_cast<int>(10.0 * std::cbrt(0.5 * size)); n > turning; --n) {
    ratio = 1.0 / (static_cast<double>(2 * n + 1) / z - ratio);
    if (n <= top) j[static_cast<std::size_t>(n)] = ratio;
  }
  for (int n = turning + 1; n <= top; ++n) j[static_cast<std::size_t>(n)] *= j[static_cast<std::size_t>(n) - 1];
}
void bessel_j(double u, Radial<double>& f) { acoustics::spherical_bessel_j(u, f); }
void bessel_j(Complex u, Radial<Complex>& f) { complex_bessel_j(u, f); }

template <class Scalar>
Radial<Scalar> regular_radial(Scalar u) {
  Radial<Scalar> f{};
  if (std::abs(u) < 0.5) {
    // j_l / u^l = sum (-u^2/2)^s / (s! (2l + 2s + 1)!!), which the recurrence would divide 0 by 0 for.
    double start = 1.0;
    for (int l = 0; l < 4; ++l) {
      start /= 2 * l + 1;
      Scalar term = start, sum = start;
      for (int s = 1; s < 9; ++s) {
        term *= -0.5 * u * u / static_cast<double>(s * (2 * l + 2 * s + 1));
        sum += term;
      }
      f[static_cast<std::size_t>(l)] = sum;
    }
    return f;
  }
  bessel_j(u, f);
  Scalar power = 1.0;
  for (Scalar& value : f) {
    value /= power;
    power *= u;
  }
  return f;
}

template <class Scalar>
Radial<Complex> singular_radial(Scalar u) {
  Complex wave;
  if constexpr (std::is_same_v<Scalar, double>) {
    wave = Complex(std::cos(u), -std::sin(u));
  } else {
    wave = std::exp(Complex(0.0, -1.0) * u);
  }
  const Scalar inverse = 1.0 / u;
  Complex before = wave * inverse, now = Complex(-wave.imag(), wave.real()) * inverse;  // h_{-1}, h_0
  Radial<Complex> f;
  Scalar power = 1.0;
  for (int l = 0; l < 4; ++l) {
    f[static_cast<std::size_t>(l)] = now * power;
    const Complex next = (2.0 * l + 1.0) * inverse * now - before;
    before = now;
    now = next;
    power *= inverse;
  }
  return f;
}

const double kMono = 1.0 / std::sqrt(4.0 * kPi), kDi = std::sqrt(3.0 / (4.0 * kPi)),
             kQuad = std::sqrt(15.0 / (4.0 * kPi));
const double kRoot3 = std::numbers::sqrt3;

template <class Number, class Scalar>
void quadrupole(Number k, const Eigen::Vector3d& r, const Radial<Scalar>& f, Scalar* out) {
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
template <class Number, class Scalar>
void quadrupole_slopes(Number k, const Eigen::Vector3d& r, const Eigen::Vector3d& n, const Radial<Scalar>& f,
                       Scalar* out) {
  const double x = r.x(), y = r.y(), z = r.z(), rn = r.dot(n);
  const Number ksq = k * k;
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

RegularRows::RegularRows(int order, Complex wavenumber_per_m)
    : order_(order),
      lossy_wavenumber_(wavenumber_per_m),
      wavenumber_per_m_(wavenumber_per_m.real()),
      harmonics_(order + 1) {
  for (int n = 0; n <= order; ++n)
    for (int m = 0; m <= n; ++m) ladders_.emplace_back(n, m);
}

RegularRows::Scratch RegularRows::scratch() const {
  const std::size_t n_radial = static_cast<std::size_t>(order_) + 2;
  return {Eigen::VectorXcd(acoustics::basis_size(order_ + 1)), std::vector<double>(n_radial),
          std::vector<Complex>(n_radial)};
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

void RegularRows::fill_lossy(const Eigen::Vector3d& r_m, Scratch& scratch) const {
  const double distance = r_m.norm();
  complex_bessel_j(lossy_wavenumber_ * distance, scratch.lossy_bessel);
  harmonics_.evaluate(distance > 0.0 ? Eigen::Vector3d(r_m / distance) : Eigen::Vector3d::UnitZ(),
                      scratch.harmonics.data());
}

void RegularRows::values(const Eigen::Vector3d& r_m, Scratch& scratch, Complex* row) const {
  fill_lossy(r_m, scratch);
  for (int n = 0; n <= order_; ++n) {
    const Complex j = scratch.lossy_bessel[static_cast<std::size_t>(n)];
    row[basis_index(n, 0)] = scratch.harmonics[basis_index(n, 0)].real() * j;
    for (int m = 1; m <= n; ++m) {
      const Complex f = std::numbers::sqrt2 * scratch.harmonics[basis_index(n, m)];
      row[basis_index(n, m)] = f.real() * j;
      row[basis_index(n, -m)] = f.imag() * j;
    }
  }
}

void RegularRows::slopes(const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal, Scratch& scratch,
                         Complex* row) const {
  fill_lossy(r_m, scratch);
  const Eigen::VectorXcd& f = scratch.harmonics;
  const Complex plus_factor(0.5 * normal.x(), -0.5 * normal.y()), minus_factor = std::conj(plus_factor);
  std::size_t at = 0;
  // The harmonics of the order above and below by themselves: each goes with its own radial function.
  for (int n = 0; n <= order_; ++n) {
    const Complex above = lossy_wavenumber_ * scratch.lossy_bessel[static_cast<std::size_t>(n) + 1],
                  below = n > 0 ? lossy_wavenumber_ * scratch.lossy_bessel[static_cast<std::size_t>(n) - 1] : 0.0;
    for (int m = 0; m <= n; ++m, ++at) {
      const acoustics::Ladder& ladder = ladders_[at];
      const Complex minus_above = m >= 1 ? -ladder.minus_up * f[basis_index(n + 1, m - 1)]
                                         : ladder.minus_up * std::conj(f[basis_index(n + 1, 1)]);
      const Complex up = plus_factor * (ladder.plus_up * f[basis_index(n + 1, m + 1)]) + minus_factor * minus_above -
                         normal.z() * ladder.z_up * f[basis_index(n + 1, m)];
      Complex down = 0.0;
      if (m <= n - 1) down += normal.z() * ladder.z_down * f[basis_index(n - 1, m)];
      if (m + 1 <= n - 1) down += plus_factor * (ladder.plus_down * f[basis_index(n - 1, m + 1)]);
      if (m >= 1 && m - 1 <= n - 1) down -= minus_factor * (ladder.minus_down * f[basis_index(n - 1, m - 1)]);
      if (m == 0 && n >= 2) down += minus_factor * (ladder.minus_down * std::conj(f[basis_index(n - 1, 1)]));
      if (m == 0) {
        row[basis_index(n, 0)] = up.real() * above + down.real() * below;
      } else {
        row[basis_index(n, m)] = std::numbers::sqrt2 * (up.real() * above + down.real() * below);
        row[basis_index(n, -m)] = std::numbers::sqrt2 * (up.imag() * above + down.imag() * below);
      }
    }
  }
}

void regular_quadrupole(Complex wavenumber_per_m, const Eigen::Vector3d& r_m, Complex* values) {
  quadrupole(wavenumber_per_m, r_m, regular_radial(wavenumber_per_m * r_m.norm()), values);
}

void regular_quadrupole_slopes(Complex wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal,
                               Complex* slopes) {
  quadrupole_slopes(wavenumber_per_m, r_m, normal, regular_radial(wavenumber_per_m * r_m.norm()), slopes);
}

void standing_quadrupole(Complex wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d* normal,
                         Complex* out) {
  const Complex u = wavenumber_per_m * r_m.norm();
  const Radial<Complex> regular = regular_radial(u), singular = singular_radial(u);
  Radial<Complex> standing;
  for (std::size_t l = 0; l < standing.size(); ++l)
    standing[l] = Complex(0.0, 1.0) * (singular[l] - regular[l]);  // h^(2) = j - i y
  if (normal == nullptr) {
    quadrupole(wavenumber_per_m, r_m, standing, out);
  } else {
    quadrupole_slopes(wavenumber_per_m, r_m, *normal, standing, out);
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

Complex monopole(Complex wavenumber_per_m, const Eigen::Vector3d& r_m) {
  const double r = r_m.norm();
  return -std::polar(std::exp(wavenumber_per_m.imag() * r) / (4.0 * kPi * r), -wavenumber_per_m.real() * r);
}

Complex monopole_slope(Complex wavenumber_per_m, const Eigen::Vector3d& r_m, const Eigen::Vector3d& normal) {
  const double r = r_m.norm();
  return monopole(wavenumber_per_m, r_m) * Complex(-1.0 / r + wavenumber_per_m.imag(), -wavenumber_per_m.real()) *
         (r_m.dot(normal) / r);
}

}  // namespace klang::bubble::detail
