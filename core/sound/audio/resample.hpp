#pragma once
#include "core/sound/audio/signal.hpp"

namespace klang::audio {

/// The signal at another rate by band-limited interpolation (libsamplerate, best quality: 97 dB, pass band to
/// 0.48 of the lower rate), round(n_frames * ratio) frames, at least 1; a sample keeps its time.
/// @param sample_rate_hz  new rate, 1/256 to 256 times the old one
/// @throws InputError when a rate is out of range or the signal is empty or has samples that are not finite.
Signal resample(const Signal& signal, double sample_rate_hz);

}  // namespace klang::audio
