#include "core/sound/audio/sound_file.hpp"

#include <sndfile.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::audio {
namespace fs = std::filesystem;
namespace {

struct Closer {
  void operator()(SNDFILE* file) const { sf_close(file); }
};
using File = std::unique_ptr<SNDFILE, Closer>;

/// Read-only cursor over the bytes, for libsndfile's virtual files.
struct Cursor {
  std::string_view bytes;
  std::vector<std::size_t> unknown_sizes;  ///< places of four bytes that are read as 0xffffffff
  sf_count_t at = 0;
};

sf_count_t cursor_length(void* user) { return static_cast<sf_count_t>(static_cast<Cursor*>(user)->bytes.size()); }

sf_count_t cursor_seek(sf_count_t offset, int whence, void* user) {
  auto& cursor = *static_cast<Cursor*>(user);
  const auto length = static_cast<sf_count_t>(cursor.bytes.size());
  const sf_count_t base = whence == SEEK_CUR ? cursor.at : whence == SEEK_END ? length : 0;
  // Damaged headers ask for offsets anywhere; the sum is bounded before it can overflow.
  const sf_count_t bounded = std::clamp<sf_count_t>(offset, -length - base, length);
  cursor.at = std::clamp<sf_count_t>(base + bounded, 0, length);
  return cursor.at;
}

sf_count_t cursor_read(void* target, sf_count_t count, void* user) {
  auto& cursor = *static_cast<Cursor*>(user);
  const sf_count_t left = static_cast<sf_count_t>(cursor.bytes.size()) - cursor.at;
  const sf_count_t n = std::clamp<sf_count_t>(count, 0, left);
  std::memcpy(target, cursor.bytes.data() + cursor.at, static_cast<std::size_t>(n));
  for (const std::size_t place : cursor.unknown_sizes) {
    for (auto i = static_cast<sf_count_t>(place); i < static_cast<sf_count_t>(place) + 4; ++i) {
      if (i >= cursor.at && i < cursor.at + n) static_cast<unsigned char*>(target)[i - cursor.at] = 0xff;
    }
  }
  cursor.at += n;
  return n;
}

sf_count_t cursor_write(const void*, sf_count_t, void*) { return 0; }

sf_count_t cursor_tell(void* user) { return static_cast<Cursor*>(user)->at; }

std::uint32_t u32(std::string_view bytes, std::size_t at, bool big_endian) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto byte = static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i]));
    value |= byte << (8 * (big_endian ? 3 - i : i));
  }
  return value;
}

/// The chunk that holds the samples of a RIFF, RIFX or FORM file.
struct SampleChunk {
  std::size_t at = 0;       ///< place of its name
  std::uint64_t size = 0;   ///< bytes of samples by its header
  std::uint64_t left = 0;   ///< bytes of the file behind that header
  std::uint64_t whole = 0;  ///< bytes of the whole file by the file's header
};

std::optional<SampleChunk> sample_chunk(std::string_view bytes) {
  if (bytes.size() < 12) return std::nullopt;
  const std::string_view id = bytes.substr(0, 4);
  const bool big_endian = id == "FORM" || id == "RIFX";
  if (id != "RIFF" && !big_endian) return std::nullopt;
  const std::string_view wanted = id == "FORM" ? "SSND" : "data";
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::uint64_t size = u32(bytes, at + 4, big_endian);
    const std::uint64_t left = bytes.size() - at - 8;
    if (bytes.substr(at, 4) == wanted) return SampleChunk{at, size, left, u32(bytes, 4, big_endian) + 8};
    at += 8 + static_cast<std::size_t>(std::min<std::uint64_t>(size + (size & 1), left));
  }
  return std::nullopt;
}

constexpr std::uint64_t kUnknownSize = 0x7fff'ffffu;  ///< from here on a writer did not know the length

/// Bytes of samples that the header promises beyond the end of the file. libsndfile shortens such files
/// silently. Sizes of 0 and from 2^31 - 1 on are what streaming writers leave when they do not know the
/// length.
std::optional<std::uint64_t> missing_chunk_bytes(std::string_view bytes) {
  const auto chunk = sample_chunk(bytes);
  if (!chunk || chunk->size == 0 || chunk->size >= kUnknownSize || chunk->size <= chunk->left) return std::nullopt;
  return chunk->size - chunk->left;
}

/// Places of sizes that a streaming writer left at 0: samples follow, though neither the chunk nor the file says so.
/// libsndfile reads 0xffffffff there as "to the end of the file", and 0 as no samples.
std::vector<std::size_t> sizes_left_at_zero(std::string_view bytes) {
  const auto chunk = sample_chunk(bytes);
  if (!chunk || chunk->size != 0 || chunk->left == 0 || !bytes.starts_with("RIFF")) return {};
  const bool file_ends_here = chunk->whole <= chunk->at + 8;
  if (!file_ends_here && chunk->whole < kUnknownSize) return {};  // other chunks follow: there are no samples
  return {4, chunk->at + 4};
}

/// The first sample that no sound has: not finite, or beyond kLargestSample.
void check_samples(const Signal& signal, const std::string& name) {
  for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
    for (Eigen::Index frame = 0; frame < signal.n_frames(); ++frame) {
      const double x = signal.samples(frame, channel);
      if (std::abs(x) <= kLargestSample) continue;
      const std::string place = "frame " + std::to_string(frame) + ", channel " + std::to_string(channel);
      if (!std::isfinite(x)) throw InputError(name, "has a sample that is not a finite number", place);
      throw InputError(name + ", " + place, "has a sample that no sound has", to_text(x),
                       "-1e12 to 1e12, where full scale is 1");
    }
  }
}

/// A whole Ogg file ends with a page that carries the end-of-stream flag (bit 2 of its sixth byte).
bool ogg_is_cut(std::string_view bytes) {
  if (!bytes.starts_with("OggS")) return false;
  const std::size_t page = bytes.rfind("OggS");
  if (page + 27 > bytes.size()) return true;
  const auto n_segments = static_cast<std::size_t>(static_cast<unsigned char>(bytes[page + 26]));
  if (page + 27 + n_segments > bytes.size()) return true;
  std::size_t end = page + 27 + n_segments;
  for (std::size_t i = 0; i < n_segments; ++i) end += static_cast<unsigned char>(bytes[page + 27 + i]);
  return end > bytes.size() || (static_cast<unsigned char>(bytes[page + 5]) & 4u) == 0;
}

std::vector<double> read_samples(SNDFILE* file, int n_channels, const std::string& name) {
  const sf_count_t block = std::max<sf_count_t>(1, 65536 / n_channels);
  std::vector<double> buffer(static_cast<std::size_t>(block * n_channels));
  std::vector<double> interleaved;
  for (;;) {
    const sf_count_t n = sf_readf_double(file, buffer.data(), block);
    if (n <= 0) break;
    interleaved.insert(interleaved.end(), buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(n * n_channels));
    if (interleaved.size() > kMaxSamples) {
      throw InputError(name, "is too long", "more than " + std::to_string(kMaxSamples) + " samples",
                       "frames x channels up to " + std::to_string(kMaxSamples));
    }
  }
  return interleaved;
}

/// Frames between the transforms of the coder that a file went through (Signal::coded_frames).
Eigen::Index coded_frames(const SF_INFO& info) {
  const int coding = info.format & SF_FORMAT_SUBMASK;
  if (coding == SF_FORMAT_VORBIS)
    return 1024;  // long blocks of 2048 (Vorbis I at 44.1 and 48 kHz; half of it below 26 kHz)
  if ((info.format & SF_FORMAT_TYPEMASK) == SF_FORMAT_MPEG) return 576;
  if (coding == SF_FORMAT_OPUS) return info.samplerate / 50;
  return 0;
}

}  // namespace

Signal read_sound(const fs::path& path) { return read_sound_bytes(read_file(path), path.string()); }

Signal read_sound_bytes(std::string_view bytes, const std::string& name) {
  if (bytes.empty()) throw InputError(name, "is empty", "0 bytes", "a WAV, FLAC, OGG, MP3 or AIFF file");
  if (const auto missing = missing_chunk_bytes(bytes)) {
    throw InputError(name, "is truncated: its header promises more samples",
                     std::to_string(*missing) + " bytes missing");
  }
  if (ogg_is_cut(bytes)) throw InputError(name, "is truncated: its last Ogg page is missing");
  SF_VIRTUAL_IO io{cursor_length, cursor_seek, cursor_read, cursor_write, cursor_tell};
  Cursor cursor{bytes, sizes_left_at_zero(bytes)};
  SF_INFO info{};
  const File file(sf_open_virtual(&io, SFM_READ, &info, &cursor));
  if (!file) {
    throw InputError(name, std::string("is not a sound file that can be read: ") + sf_strerror(nullptr));
  }
  checked(name, "sample_rate_hz", info.samplerate, 100, 1e7);
  checked(name, "channels", info.channels, 1, 1024);
  const std::vector<double> interleaved = read_samples(file.get(), info.channels, name);
  const auto n_channels = static_cast<Eigen::Index>(info.channels);
  const auto n_frames = static_cast<Eigen::Index>(interleaved.size()) / n_channels;
  // Compressed streams know their length from the header (FLAC); an unknown length is the largest number.
  if (info.frames > n_frames && info.frames < SF_COUNT_MAX && (info.format & SF_FORMAT_TYPEMASK) != SF_FORMAT_OGG) {
    throw InputError(name, "is truncated or damaged", std::to_string(n_frames) + " frames readable",
                     std::to_string(info.frames) + " by its header");
  }
  if (n_frames == 0) throw InputError(name, "has no samples", "0 frames", "at least 1");
  Signal signal;
  signal.samples = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      interleaved.data(), n_frames, n_channels);
  signal.sample_rate_hz = info.samplerate;
  signal.origin = name;
  signal.coded_frames = coded_frames(info);
  check_samples(signal, name);
  return signal;
}

namespace {

/// Bytes that libsndfile writes in memory.
struct Pad {
  std::string bytes;
  sf_count_t at = 0;
};

sf_count_t pad_length(void* user) { return static_cast<sf_count_t>(static_cast<Pad*>(user)->bytes.size()); }
sf_count_t pad_seek(sf_count_t offset, int whence, void* user) {
  auto& pad = *static_cast<Pad*>(user);
  const auto length = static_cast<sf_count_t>(pad.bytes.size());
  pad.at = std::clamp<sf_count_t>(offset + (whence == SEEK_CUR ? pad.at : whence == SEEK_END ? length : 0), 0, length);
  return pad.at;
}
sf_count_t pad_read(void* target, sf_count_t count, void* user) {
  auto& pad = *static_cast<Pad*>(user);
  const sf_count_t n = std::clamp<sf_count_t>(count, 0, static_cast<sf_count_t>(pad.bytes.size()) - pad.at);
  std::memcpy(target, pad.bytes.data() + pad.at, static_cast<std::size_t>(n));
  pad.at += n;
  return n;
}
sf_count_t pad_write(const void* source, sf_count_t count, void* user) {
  auto& pad = *static_cast<Pad*>(user);
  const auto at = static_cast<std::size_t>(pad.at), n = static_cast<std::size_t>(count);
  pad.bytes.resize(std::max(pad.bytes.size(), at + n));
  std::memcpy(pad.bytes.data() + at, source, n);
  pad.at += count;
  return count;
}
sf_count_t pad_tell(void* user) { return static_cast<Pad*>(user)->at; }

/// All samples, in blocks.
void write_samples(File file, const Signal& signal, int subformat, const std::string& place) {
  if (!file) throw InputError(place, std::string("cannot write: ") + sf_strerror(nullptr));
  sf_command(file.get(), SFC_SET_ADD_PEAK_CHUNK, nullptr, SF_FALSE);  // it would hold the time of writing
  constexpr Eigen::Index kBlock = 16384;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> block;
  std::vector<int> integers;
  for (Eigen::Index begin = 0; begin < signal.n_frames(); begin += kBlock) {
    const Eigen::Index n = std::min(kBlock, signal.n_frames() - begin);
    block = signal.samples.middleRows(begin, n);
    sf_count_t written = 0;
    if (subformat == SF_FORMAT_FLOAT) {
      written = sf_writef_double(file.get(), block.data(), n);
    } else {
      // libsndfile truncates when it clips; rounding to the nearest step halves the error.
      const int bits = subformat == SF_FORMAT_PCM_16 ? 16 : 24;
      const double full = std::ldexp(1.0, bits - 1);
      integers.resize(static_cast<std::size_t>(block.size()));
      for (Eigen::Index i = 0; i < block.size(); ++i) {
        const double step = std::clamp(std::nearbyint(block.data()[i] * full), -full, full - 1);
        integers[static_cast<std::size_t>(i)] = static_cast<int>(step * std::ldexp(1.0, 32 - bits));
      }
      written = sf_writef_int(file.get(), integers.data(), n);
    }
    if (written != n) {
      throw InputError(place, std::string("cannot write: ") + sf_strerror(file.get()));
    }
  }
  SNDFILE* raw = file.release();
  if (const int error = sf_close(raw); error != 0) {
    throw InputError(place, std::string("cannot write: ") + sf_error_number(error));
  }
}

/// What a format can hold.
void check_writable(const Signal& signal, bool flac, const std::string& place) {
  if (signal.samples.size() == 0) throw InputError(place, "no samples to write");
  checked(place, "sample_rate_hz", signal.sample_rate_hz, 1, flac ? 655350 : 1e7);
  if (signal.sample_rate_hz != std::round(signal.sample_rate_hz)) {
    throw InputError(place, "sample_rate_hz must be whole", to_text(signal.sample_rate_hz));
  }
  checked(place, "channels", static_cast<double>(signal.n_channels()), 1, flac ? 8 : 1024);
  if (!flac) checked(place, "samples", static_cast<double>(signal.samples.size()), 1, 1e9);  // WAV sizes are 32 bit
  if (!signal.samples.allFinite()) throw InputError(place, "cannot write samples that are not finite numbers");
}

}  // namespace

void write_sound(const fs::path& path, const Signal& signal, SampleFormat format) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  const bool flac = extension == ".flac";
  if (!flac && extension != ".wav") {
    throw InputError(path.string(), "cannot write sound with this extension", extension, ".wav or .flac");
  }
  const std::string place = path.string();
  check_writable(signal, flac, place);
  SF_INFO info{};
  info.samplerate = static_cast<int>(signal.sample_rate_hz);
  info.channels = static_cast<int>(signal.n_channels());
  int subformat = SF_FORMAT_PCM_24;
  if (format == SampleFormat::kPcm16) subformat = SF_FORMAT_PCM_16;
  if (format == SampleFormat::kFloat32 && !flac) subformat = SF_FORMAT_FLOAT;
  const bool extensible = !flac && info.channels > 2;
  info.format = (flac ? SF_FORMAT_FLAC : extensible ? SF_FORMAT_WAVEX : SF_FORMAT_WAV) | subformat;
  write_file_with(path, [&](const fs::path& temporary) {
    write_samples(File(sf_open(temporary.c_str(), SFM_WRITE, &info)), signal, subformat, place);
  });
}

std::string flac_bytes(const Signal& signal, SampleFormat format) {
  const std::string place = "flac";
  check_writable(signal, true, place);
  SF_INFO info{};
  info.samplerate = static_cast<int>(signal.sample_rate_hz);
  info.channels = static_cast<int>(signal.n_channels());
  const int subformat = format == SampleFormat::kPcm16 ? SF_FORMAT_PCM_16 : SF_FORMAT_PCM_24;
  info.format = SF_FORMAT_FLAC | subformat;
  SF_VIRTUAL_IO io{pad_length, pad_seek, pad_read, pad_write, pad_tell};
  Pad pad;
  write_samples(File(sf_open_virtual(&io, SFM_WRITE, &info, &pad)), signal, subformat, place);
  return std::move(pad.bytes);
}

}  // namespace klang::audio
