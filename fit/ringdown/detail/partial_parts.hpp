#pragma once
#include <vector>

#include "fit/ringdown/detail/partial_search.hpp"

namespace klang::fit::detail {

// What the search for partials and their polishing share.

inline constexpr double kHalfBandCells = 20;   ///< half width of a sub-band beyond its outermost partial, in 1 / window
inline constexpr double kDecaysPerWindow = 5;  ///< a window ends when its partial has fallen to exp(-5)
/// Of a neighbour's decay: what falls slower is still there when the other is gone, a line of its own and not the other's shape.
inline constexpr double kOutlasts = 0.3;
inline constexpr double kShortestWindowS = 0.006;

/// Length of the window in which a partial is fitted [s].
double window_of(const Pole& pole, const RingData& data);
/// Variance a bin that a fit leaves, in the scale of BinBlock.
double residual_variance(const SubBand& band, const RefinedFit& fit);
/// Amplitude of one of a fit's partials in every segment (rows) and channel.
Eigen::MatrixXcd amplitudes_of(const RingData& data, const SubBand& band, const LinearFit& linear, std::size_t index);

/// How groups are fitted again.
struct Polishing {
  const TailNoise* noise = nullptr;  ///< null while the search goes on: no disturbance is measured
  bool later_starts = false;         ///< try them where the residual stands above the noise (needs noise)
};

/// Fits the groups again that lie within 8 cells of one of the frequencies.
void polish_near(const RingData& data, std::vector<FittedPartial>& partials, const Polishing& how,
                 const std::vector<double>& changed_hz);

}  // namespace klang::fit::detail
