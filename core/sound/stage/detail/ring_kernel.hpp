#pragma once
#include <cstddef>

namespace klang::stage::detail {

inline constexpr std::size_t kRingLanes = 8;  ///< blocks of a voice that run side by side

/// For each lane: Z at a first sample, the ratio of the next sample to it, that ratio's own ratio, and so on: a
/// polynomial of degree 4 in the exponent needs four complex products per sample and no exponential. The gain changes in
/// even steps.
struct RingLanes {
  double z_re[kRingLanes], z_im[kRingLanes];
  double ratio_re[4][kRingLanes], ratio_im[4][kRingLanes];
  double gain_re[kRingLanes], gain_im[kRingLanes], gain_step_re[kRingLanes], gain_step_im[kRingLanes];
};

/// output[n][lane] = Re(gain Z) for n samples. Without fused multiply-add: same bits on every processor.
void ring_samples(const RingLanes& lanes, std::size_t n, double* output);

}  // namespace klang::stage::detail
