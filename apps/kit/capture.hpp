#pragma once
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::apps {

/// Records from an input device (PortAudio, one channel at its own rate) until n_takes taps have rung for a second, for longest_s, or
/// until the monitor says stop.
/// @param device  its number, part of its name, or "default"
/// @throws InputError: no such device (lists them), a build without PortAudio
audio::Signal captured_sound(const std::string& device, double longest_s, int n_takes, Monitor& monitor);

}  // namespace klang::apps
