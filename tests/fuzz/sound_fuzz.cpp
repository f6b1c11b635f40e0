/// Any bytes read as sound give a signal of finite samples or an InputError.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/sound_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const auto signal = klang::audio::read_sound_bytes({reinterpret_cast<const char*>(data), size}, "fuzz input");
    if (signal.n_frames() < 1 || !signal.samples.allFinite() || !(signal.sample_rate_hz > 0)) std::abort();
  } catch (const klang::InputError&) {
  }
  return 0;
}
