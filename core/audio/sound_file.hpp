#pragma once
#include <filesystem>

#include "core/audio/signal.hpp"

namespace klang::audio {

enum class SampleFormat { kPcm16, kPcm24, kFloat32 };

/// Reads WAV, FLAC, OGG, AIFF (whatever libsndfile reads), any rate, 1 to 1024 channels.
/// @throws InputError: missing, not sound, empty, truncated, a NaN or infinite sample (its frame), a rate of 0.
Signal read_sound(const std::filesystem::path& path);

/// As read_sound, from bytes in memory (what the fuzz target calls). name: for messages.
Signal read_sound_bytes(std::string_view bytes, const std::string& name);

/// Writes WAV or FLAC by the extension, whole or not at all. PCM formats clip at full scale.
void write_sound(const std::filesystem::path& path, const Signal& signal,
                 SampleFormat format = SampleFormat::kPcm24);

}  // namespace klang::audio
