#pragma once
#include <string>

#include "core/sound/audio/signal.hpp"

namespace klang::reports::detail {

/// One channel for a browser: 16-bit FLAC at 48 kHz or less (a higher rate is resampled, many players refuse
/// 384 kHz), at most max_duration_s long with a short fade where it was cut, times gain.
std::string flac_clip(const audio::Signal& sound, double max_duration_s, double gain);

/// The gain that brings the loudest sample of the part that is played to 0.9 of full scale; never below 1e-6
/// or above 1e6.
double clip_gain(const audio::Signal& sound, double max_duration_s);

}  // namespace klang::reports::detail
