#include "fit/detail/exponential_bins.hpp"

#include <cmath>

#include "core/base/conventions.hpp"

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

ExponentialColumns exponential_columns(const BinBlock& block, double frequency_hz, double decay_per_s,
                                       bool with_derivatives) {
  const Eigen::Index n_bins = block.y.size();
  const double scale = 1.0 / std::sqrt(static_cast<double>(block.n));
  const double per_sample = 1.0 / block.sample_rate_hz;
  const Complex sigma(-decay_per_s * per_sample, 2 * kPi * frequency_hz * per_sample);
  const Complex i(0, 1);
  ExponentialColumns columns;
  columns.value.resize(n_bins, 2);
  if (with_derivatives) {
    columns.by_frequency.resize(n_bins, 2);
    columns.by_decay.resize(n_bins, 2);
  }
  for (Eigen::Index j = 0; j < n_bins; ++j) {
    const ExponentialBin line = exponential_bin(sigma, block.first_bin + j, block.n);
    const ExponentialBin image = exponential_bin(std::conj(sigma), block.first_bin + j, block.n);
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
