#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "fit/ringdown/detail/exponential_bins.hpp"

namespace ceres {
class CostFunction;
}

namespace klang::fit::detail {

/// Frequency and decay of one exponential.
struct Pole {
  double frequency_hz = 0.0;
  double decay_per_s = 0.0;
};

/// Complex polynomial terms that stand for what leaks into the band from outside (rumble, clicks at the
/// window's ends, partials far away): all of it is smooth over the bins, because both ends of the window have
/// phase 0 there.
inline constexpr Eigen::Index kBackgroundTerms = 3;

/// All windows of one sub-band: the same poles in each block, amplitudes and background of its own in each.
struct SubBand {
  std::vector<BinBlock> blocks;
  double time_scale_s = 0.0;  ///< longest window; the fit's parameters are 2 pi (f - f0) * this and decay * this

  Eigen::Index n_real_data() const;  ///< 2 per bin
};

/// Least squares over amplitudes and background with the poles held.
struct LinearFit {
  std::vector<Eigen::VectorXd> coefficients;  ///< per block: (ar, ai) of each pole, then the background
  std::vector<Eigen::VectorXcd> residuals;    ///< per block
  double residual_sum_sq = 0.0;
};
LinearFit linear_fit(const SubBand& band, const std::vector<Pole>& poles);

/// The variable-projection residual of one block as a Ceres cost with the exact (Golub-Pereyra) Jacobian.
/// Parameters: for each pole (2 pi (f - start f) T, decay T), T = band.time_scale_s. Residuals: sqrt(2) (Re,
/// Im) of every bin / noise_rms, so that each has unit variance.
std::unique_ptr<ceres::CostFunction> make_projected_cost(const BinBlock& block, const std::vector<Pole>& start,
                                                         double time_scale_s, double noise_rms);

/// Maximum-likelihood poles from a start (white noise inside the band).
struct RefinedFit {
  bool ok = false;  ///< finite, converged, poles inside the band
  std::vector<Pole> poles;
  LinearFit linear;
};
/// @param precise  false: stops at 1e-5 of the cost, enough to compare orders
RefinedFit refine(const SubBand& band, const std::vector<Pole>& start, bool precise = true);

/// Covariances at the optimum for a noise variance per bin (E|noise|^2).
struct FitCovariance {
  Eigen::MatrixXd poles;                         ///< 2p x 2p: (f [Hz], decay [1/s]) of each pole
  std::vector<Eigen::MatrixXd> amplitudes;       ///< per block 2p x 2p of (ar, ai), pole uncertainty included
  std::vector<Eigen::MatrixXd> amplitudes_held;  ///< per block, as if the poles were known
  std::vector<Eigen::MatrixXd> cross;            ///< per block 2p x 2p: (ar, ai) with (f, decay)
  bool ok = false;
};
FitCovariance covariance(const SubBand& band, const std::vector<Pole>& poles, const LinearFit& linear,
                         double noise_variance);

}  // namespace klang::fit::detail
