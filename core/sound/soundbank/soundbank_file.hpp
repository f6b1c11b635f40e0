#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "core/sound/soundbank/soundbank_build.hpp"

namespace klang::soundbank {

/// Writes and reads a bank: 8 bytes "KLBANK\r\n", version, sizes, a JSON header (what `klang proxy info` shows; SHA-256 of the data), and
/// the data compressed by zlib, little-endian. Reading gives back every bit.
void write_soundbank(const std::filesystem::path& path, const Soundbank& bank);
/// @throws InputError when the file is missing, no bank, truncated, damaged or of a newer version
Soundbank read_soundbank(const std::filesystem::path& path);
Soundbank read_soundbank_bytes(const std::string& bytes, const std::string& name);

/// What a stopped build leaves beside its output. The key says of which options it is.
void write_build_progress(const std::filesystem::path& path, const BuildProgress& progress, const std::string& key);
/// Empty where the file belongs to another key. @throws InputError as read_soundbank
std::optional<BuildProgress> read_build_progress(const std::filesystem::path& path, const std::string& key);

/// InputError unless the bank is of this Poisson's ratio, to 0.005. place: whose it is, for the message.
void check_poissons_ratio(const Soundbank& bank, double poissons_ratio, const std::string& place);

}  // namespace klang::soundbank
