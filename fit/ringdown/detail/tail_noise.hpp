#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "fit/ringdown/detail/ring_data.hpp"

namespace klang::fit::detail {

/// Local noise of a power spectrum (mean over n_averaged exponentially distributed powers): a low quantile
/// over a neighbourhood that grows with frequency, brought to the mean. Sharp peaks do not move it.
Eigen::VectorXd noise_floor(const Eigen::VectorXd& power, Eigen::Index n_averaged);

/// Four-term Blackman-Harris window (side lobes below -92 dB), unit power.
Eigen::VectorXd blackman_harris(Eigen::Index n);

/// Noise of the recording's quietest stretches by frequency: the last half of the longest segment (at most 2
/// s), channels averaged. Variance per bin in the scale of BinBlock.
class TailNoise {
 public:
  explicit TailNoise(const RingData& data);
  double at(double frequency_hz) const {
    const auto k = static_cast<Eigen::Index>(std::llround(frequency_hz / per_bin_hz_));
    return floor_[std::clamp<Eigen::Index>(k, 0, floor_.size() - 1)];
  }
  /// How many of the segments say the same: 1 where each has noise of its own; their number where the noise of all is the same
  /// (one take pasted again and again). Their mean is no surer than that of n / repeats segments.
  double repeats() const { return repeats_; }

 private:
  double per_bin_hz_ = 1.0, repeats_ = 1.0;
  Eigen::VectorXd floor_;
};

}  // namespace klang::fit::detail
