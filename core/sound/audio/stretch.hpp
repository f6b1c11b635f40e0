#pragma once
#include "core/sound/audio/signal.hpp"

namespace klang::audio {

/// Frames [begin, end) of a signal.
struct Stretch {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index size() const { return end - begin; }
};

/// From the first to the last frame in which a channel is not exactly zero: without the digital silence that editors and coders put
/// at the ends. Empty where every sample is zero.
inline Stretch sounding_stretch(const Signal& signal) {
  Stretch stretch{0, signal.n_frames()};
  const auto silent = [&](Eigen::Index frame) { return (signal.samples.row(frame).array() == 0.0).all(); };
  while (stretch.begin < stretch.end && silent(stretch.begin)) ++stretch.begin;
  while (stretch.end > stretch.begin && silent(stretch.end - 1)) --stretch.end;
  return stretch;
}

}  // namespace klang::audio
