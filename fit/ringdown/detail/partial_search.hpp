#pragma once
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/ringdown/detail/ring_data.hpp"
#include "fit/ringdown/detail/tail_noise.hpp"

namespace klang::fit::detail {

struct SearchOptions {
  double min_snr_db = 10.0;
  int max_partials = 200;
};

/// A found partial with its statistics.
struct FittedPartial {
  RingPartial ring;
  Eigen::Matrix2d pole_covariance = Eigen::Matrix2d::Zero();  ///< (f [Hz], decay [1/s])
  /// Per segment and channel (row segment * n_channels + channel): covariance of (Re a, Im a) and with (f,
  /// decay).
  std::vector<Eigen::Matrix2d> amplitude_covariance, cross_covariance;
  double snr_db = 0.0;       ///< |a|^2 over its variance with the poles known, best segment and channel
  double window_s = 0.0;     ///< of its last fit
  double disturbance = 0.0;  ///< residual around it over the recording's own noise; about 1 for clean exponentials
};

/// Finds the exponentials of the data: for window lengths from the longest segment down to 6 ms, peaks of the
/// residual above its local noise; each cluster of peaks becomes a sub-band whose order grows while a
/// likelihood-ratio test says so; what was found is refined jointly with its neighbours and subtracted before
/// the next length.
std::vector<FittedPartial> search_partials(const RingData& data, const SearchOptions& options, Monitor& monitor);

/// Refines all partials, each in a window of 5 / decay, close ones jointly. Where the residual stands above
/// the noise and a later start gives a much surer frequency, the window starts later: something disturbed the
/// ringing before.
void polish(const RingData& data, std::vector<FittedPartial>& partials);

/// False for exponentials that should be well above the noise later on (after 1 / decay) and are not there:
/// they only mended a disturbed beginning. The strongest of close partials always stays.
std::vector<bool> persistent(const RingData& data, const std::vector<FittedPartial>& partials);

}  // namespace klang::fit::detail
