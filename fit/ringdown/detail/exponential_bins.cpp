#include "fit/ringdown/detail/exponential_bins.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

/// exp(z) - 1 without cancellation for small z.
Complex expm1(Complex z) {
  const double grow = std::expm1(z.real());
  const double half = std::sin(0.5 * z.imag());
  return {grow * std::cos(z.imag()) - 2 * half * half, (grow + 1) * std::sin(z.imag())};
}

}  // namespace

ExponentialBin exponential_bin(Complex sigma, Eigen::Index k, Eigen::Index n) {
  const auto count = static_cast<double>(n);
  const Complex u(sigma.real(), std::remainder(sigma.imag() - 2 * kPi * static_cast<double>(k) / count, 2 * kPi));
  if (std::norm(u) * count * count < 1e-8) {
    const double pairs = 0.5 * count * (count - 1);
    const double triples = pairs * (2 * count - 1) / 3;  // sum of m^2
    return {0.5 * (count + u * pairs + 0.5 * u * u * triples), 0.5 * (pairs + u * triples)};
  }
  const Complex whole = expm1(u * count);
  const Complex one = expm1(u);
  const Complex inverse = 1.0 / one;
  return {0.5 * whole * inverse, 0.5 * (count * (whole + 1.0) - (one + 1.0) * whole * inverse) * inverse};
}

namespace {

/// What all bins of one exponential share, so that a bin costs no transcendental function.
class BinRow {
 public:
  BinRow(Complex sigma, Eigen::Index first, Eigen::Index n)
      : sigma_(sigma),
        first_(first),
        n_(n),
        count_(static_cast<double>(n)),
        step_rad_(2 * kPi / count_),
        whole_(expm1(Complex(sigma.real() * count_, std::remainder(sigma.imag() * count_, 2 * kPi)))),
        turn_(std::polar(1.0, -step_rad_)),
        e_u_(std::exp(sigma) * std::polar(1.0, -step_rad_ * static_cast<double>(first))),
        angle_(std::remainder(sigma.imag() - step_rad_ * static_cast<double>(first), 2 * kPi)) {}

  /// Bin first + j, to be asked for j = 0, 1, 2, ...
  ExponentialBin next(Eigen::Index j) {
    const Complex u(sigma_.real(), angle_ - step_rad_ * static_cast<double>(j));
    const double size = std::norm(u);
    Complex e_u = e_u_;
    e_u_ = times(e_u_, turn_);
    Complex one;
    if (size < 2.5e-3) {  // |u| < 0.05: e^u - 1 by its series, which keeps all digits
      if (size * count_ * count_ < 1e-8) return exponential_bin(sigma_, first_ + j, n_);
      one = 1.0 + u * (1.0 / 7);
      for (const double k : {6.0, 5.0, 4.0, 3.0, 2.0}) one = 1.0 + times(u, one) * (1 / k);
      one = times(u, one);
      e_u = one + 1.0;
    } else {
      one = e_u - 1.0;
      if (std::norm(one) < 1e-3) return exponential_bin(sigma_, first_ + j, n_);
    }
    const Complex inverse = std::conj(one) * (1 / std::norm(one));
    const Complex ratio = times(whole_, inverse);
    return {0.5 * ratio, 0.5 * times(count_ * (whole_ + 1.0) - times(e_u, ratio), inverse)};
  }

 private:
  /// Product without the check for infinities that the language asks for.
  static Complex times(Complex a, Complex b) {
    return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
  }
  Complex sigma_;
  Eigen::Index first_, n_;
  double count_, step_rad_;
  Complex whole_, turn_, e_u_;
  double angle_;
};

}  // namespace

Eigen::VectorXcd exponential_bins(const BinBlock& block, double frequency_hz, double decay_per_s, Complex amplitude) {
  const double per_sample = 1.0 / block.sample_rate_hz;
  const Complex sigma(-decay_per_s * per_sample, 2 * kPi * frequency_hz * per_sample);
  BinRow line(sigma, block.first_bin, block.n), image(std::conj(sigma), block.first_bin, block.n);
  const Complex a = amplitude / std::sqrt(static_cast<double>(block.n));
  Eigen::VectorXcd bins(block.y.size());
  for (Eigen::Index j = 0; j < bins.size(); ++j) bins[j] = a * line.next(j).value + std::conj(a) * image.next(j).value;
  return bins;
}

Eigen::VectorXcd one_sided_bins(const BinBlock& block, double frequency_hz, double decay_per_s) {
  const double per_sample = 1.0 / block.sample_rate_hz;
  BinRow line(Complex(-decay_per_s * per_sample, 2 * kPi * frequency_hz * per_sample), block.first_bin, block.n);
  Eigen::VectorXcd bins(block.y.size());
  for (Eigen::Index j = 0; j < bins.size(); ++j) bins[j] = line.next(j).value;
  return bins;
}

ExponentialColumns exponential_columns(const BinBlock& block, double frequency_hz, double decay_per_s,
                                       bool with_derivatives) {
  const Eigen::Index n_bins = block.y.size();
  const double scale = 1.0 / std::sqrt(static_cast<double>(block.n));
  const double per_sample = 1.0 / block.sample_rate_hz;
  const Complex sigma(-decay_per_s * per_sample, 2 * kPi * frequency_hz * per_sample);
  const Complex i(0, 1);
  BinRow line_row(sigma, block.first_bin, block.n), image_row(std::conj(sigma), block.first_bin, block.n);
  ExponentialColumns columns;
  columns.value.resize(n_bins, 2);
  if (with_derivatives) {
    columns.by_frequency.resize(n_bins, 2);
    columns.by_decay.resize(n_bins, 2);
  }
  for (Eigen::Index j = 0; j < n_bins; ++j) {
    const ExponentialBin line = line_row.next(j);
    const ExponentialBin image = image_row.next(j);
    columns.value(j, 0) = scale * (line.value + image.value);
    columns.value(j, 1) = scale * i * (line.value - image.value);
    if (!with_derivatives) continue;
    const Complex line_slope = scale * per_sample * line.slope;
    const Complex image_slope = scale * per_sample * image.slope;
    columns.by_decay(j, 0) = -(line_slope + image_slope);
    columns.by_decay(j, 1) = -i * (line_slope - image_slope);
    columns.by_frequency(j, 0) = 2 * kPi * i * (line_slope - image_slope);
    columns.by_frequency(j, 1) = -2 * kPi * (line_slope + image_slope);
  }
  return columns;
}

}  // namespace klang::fit::detail
