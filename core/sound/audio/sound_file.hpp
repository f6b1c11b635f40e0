#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/sound/audio/signal.hpp"

namespace klang::audio {

enum class SampleFormat { kPcm16, kPcm24, kFloat32 };

/// Most samples (frames x channels) that are read: 4e8, 3.2 GB in memory. A small compressed file can unpack
/// to anything.
inline constexpr std::size_t kMaxSamples = 400'000'000;

/// Largest magnitude of a sample (full scale = 1) that is taken for sound: squares and their sums stay finite.
inline constexpr double kLargestSample = 1e12;

/// Reads WAV, FLAC, OGG, MP3, AIFF (whatever libsndfile reads), 100 Hz to 10 MHz, 1 to 1024 channels. A WAV whose
/// writer left its sizes at 0 is read to the file's end.
/// @throws InputError: missing, not sound, empty, truncated, a sample that is not finite or beyond kLargestSample (its
/// frame), a rate of 0.
Signal read_sound(const std::filesystem::path& path);

/// As read_sound, from bytes in memory (what the fuzz target calls). name: for messages.
Signal read_sound_bytes(std::string_view bytes, const std::string& name);

/// Writes WAV or FLAC by the extension, whole or not at all. PCM formats clip at full scale. FLAC has no
/// floats: kFloat32 becomes 24 bits there. The same signal gives the same bytes (no dates in the header).
/// @throws InputError: another extension, no samples, a sample that is not finite, a rate or channel count
/// the format
///         cannot hold, a path that cannot be written.
void write_sound(const std::filesystem::path& path, const Signal& signal, SampleFormat format = SampleFormat::kPcm24);

/// The bytes of a FLAC file, 16 or 24 bits. @throws InputError as write_sound
std::string flac_bytes(const Signal& signal, SampleFormat format = SampleFormat::kPcm16);

}  // namespace klang::audio
