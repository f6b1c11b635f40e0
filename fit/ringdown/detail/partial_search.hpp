#pragma once
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/ringdown/detail/ring_data.hpp"
#include "fit/ringdown/detail/tail_noise.hpp"

namespace klang::fit::detail {

struct SearchOptions {
  double min_snr_db = 10.0;
  int max_partials = 400;
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
  double drift_hz = 0.0;     ///< how far its frequency moves with the window's start, beyond what noise does
  bool carries = false;  ///< with its group it explains most of its neighbourhood's energy, nothing stronger is near
  std::optional<bool> lasts;  ///< by check_persistence(); empty since its last fit
  bool fresh = true;          ///< found in the present round of the search
  bool unresolved = false;    ///< cannot be told from a stronger neighbour: no joint fit succeeds
};

/// Finds the exponentials of the data that `found` lacks and appends them: for window lengths from the longest segment
/// down to 6 ms, peaks of the residual above its local noise; each cluster of peaks becomes a sub-band whose order grows
/// while a likelihood-ratio test says so; what was found is refined jointly with its neighbours and subtracted before the
/// next length. Peaks at frequencies that were tried in vain before are left alone.
void search_partials(const RingData& data, const SearchOptions& options, const TailNoise& noise,
                     const std::vector<double>& tried_hz, std::vector<FittedPartial>& found, Monitor& monitor);

/// Refines all partials, each in a window of 5 / decay, close ones jointly. Where the residual stands above
/// the noise and a later start gives a much surer frequency, the window starts later: something disturbed the
/// ringing before.
void polish(const RingData& data, std::vector<FittedPartial>& partials, const TailNoise& noise);

/// Sets `lasts` where it is empty: false for exponentials that should be well above the noise later on (after 1 / decay)
/// and are not there: they only mended a disturbed beginning. The strongest of close partials always stays.
void check_persistence(const RingData& data, std::vector<FittedPartial>& partials);

}  // namespace klang::fit::detail
