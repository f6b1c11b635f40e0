#pragma once
#include <complex>
#include <cstdint>
#include <span>

#include "core/physics/bubble/bubble_ring.hpp"

namespace klang::stage {

/// A ringing bubble as one channel hears it: Re(G(t) Z(t - onset)), with the gain G straight in each block of the
/// track.
struct RingSound {
  const bubble::RingTrack* track = nullptr;
  double onset_s = 0.0;                              ///< birth and delay on the way
  std::span<const std::complex<double>> gain_start;  ///< of each block
  std::span<const std::complex<double>> gain_end;
  bool soft_attack = true;  ///< eq. (39) with the decay at birth
};

/// Frames at which the bubble sounds: first <= frame < end.
struct FrameRange {
  std::int64_t first = 0, end = 0;
};
FrameRange frames_of(const RingSound& ring, double sample_rate_hz);

/// Adds its sound to output, whose first sample is frame first_frame; what lies outside is left out. The last part of
/// the life (below 1/1000 of the first amplitude) is faded out by a raised cosine. Costs about 10 ns per sample.
void add_ring(const RingSound& ring, double sample_rate_hz, std::int64_t first_frame, std::span<double> output);

}  // namespace klang::stage
