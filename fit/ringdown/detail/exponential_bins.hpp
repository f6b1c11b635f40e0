#pragma once
#include <Eigen/Core>
#include <complex>

namespace klang::fit::detail {

/// One DFT bin of half a truncated complex exponential and its derivative:
///   g = 1/2 sum_{m=0}^{n-1} exp(sigma m) exp(-2 pi i k m / n) = 1/2 (e^{sigma n} - 1) / (e^{u} - 1),
///   u = sigma - 2 pi i k / n,   slope = dg/dsigma.
/// The sum is exact, not the line shape of an endless exponential: truncation needs no window. Series near u
/// = 0.
/// @param sigma  (-decay_per_s + 2 pi i frequency_hz) / sample_rate_hz
/// @param k      bin, @param n samples in the window
struct ExponentialBin {
  std::complex<double> value, slope;
};
ExponentialBin exponential_bin(std::complex<double> sigma, Eigen::Index k, Eigen::Index n);

/// The bins [first_bin, first_bin + n_bins) of a real window of n samples, divided by sqrt(n) so that white
/// noise of variance v has E|y|^2 = v in every bin.
struct BinBlock {
  Eigen::Index segment = 0, channel = 0;
  Eigen::Index n = 0, first_bin = 0;
  double sample_rate_hz = 0.0;
  Eigen::VectorXcd y;

  double duration_s() const { return static_cast<double>(n) / sample_rate_hz; }
  double frequency_hz(Eigen::Index i) const { return static_cast<double>(first_bin + i) / duration_s(); }
};

/// What the real exponential Re(a exp((-decay + i omega) t)) puts into the block's bins, a = ar + i ai:
///   y = ar * columns.col(0) + ai * columns.col(1), both with the mirror image at negative frequency.
/// The derivatives with respect to frequency [1/Hz] and decay [s] have the same form.
struct ExponentialColumns {
  Eigen::MatrixXcd value, by_frequency, by_decay;  ///< n_bins x 2
};
ExponentialColumns exponential_columns(const BinBlock& block, double frequency_hz, double decay_per_s,
                                       bool with_derivatives);

/// What a real exponential of complex amplitude `amplitude` puts into the block's bins.
Eigen::VectorXcd exponential_bins(const BinBlock& block, double frequency_hz, double decay_per_s,
                                  std::complex<double> amplitude);
/// exponential_bin of every bin of the block: no mirror image, no scale.
Eigen::VectorXcd one_sided_bins(const BinBlock& block, double frequency_hz, double decay_per_s);

}  // namespace klang::fit::detail
