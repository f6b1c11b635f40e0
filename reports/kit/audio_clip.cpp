#include "reports/kit/audio_clip.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/sound/audio/resample.hpp"

namespace klang::reports::detail {
namespace {

Eigen::Index clip_length(const audio::Signal& sound, double max_duration_s) {
  return std::min(sound.n_frames(), static_cast<Eigen::Index>(std::max(1.0, max_duration_s * sound.sample_rate_hz)));
}

void append_le(std::string& bytes, std::uint32_t value, int n) {
  for (int i = 0; i < n; ++i) bytes += static_cast<char>((value >> (8 * i)) & 0xff);
}

}  // namespace

double clip_gain(const audio::Signal& sound, double max_duration_s) {
  const Eigen::Index n = clip_length(sound, max_duration_s);
  const double peak = n > 0 ? sound.samples.col(0).head(n).cwiseAbs().maxCoeff() : 0.0;
  return peak > 0 ? std::clamp(0.9 / peak, 1e-6, 1e6) : 1.0;
}

std::string wav_clip(const audio::Signal& sound, double max_duration_s, double gain) {
  const Eigen::Index n = clip_length(sound, max_duration_s);
  audio::Signal clip;
  clip.sample_rate_hz = sound.sample_rate_hz;
  clip.samples = gain * sound.samples.col(0).head(n);
  constexpr double kHighestRate = 48000, kLowestRate = 8000;
  const double rate = sound.sample_rate_hz;
  if (rate > kHighestRate || rate < kLowestRate || rate != std::floor(rate)) {
    clip = audio::resample(clip, std::clamp(std::floor(rate), kLowestRate, kHighestRate));
  }
  Eigen::VectorXd samples = clip.samples.col(0);
  if (n < sound.n_frames()) {
    const Eigen::Index fade = std::min(samples.size(), static_cast<Eigen::Index>(0.03 * clip.sample_rate_hz));
    for (Eigen::Index i = 0; i < fade; ++i) {
      samples[samples.size() - 1 - i] *= static_cast<double>(i) / static_cast<double>(fade);
    }
  }
  const auto n_bytes = static_cast<std::uint32_t>(2 * samples.size());
  const auto whole_rate = static_cast<std::uint32_t>(clip.sample_rate_hz);
  std::string bytes = "RIFF";
  append_le(bytes, 36 + n_bytes, 4);
  bytes += "WAVEfmt ";
  append_le(bytes, 16, 4);
  append_le(bytes, 1, 2);  // PCM
  append_le(bytes, 1, 2);  // channels
  append_le(bytes, whole_rate, 4);
  append_le(bytes, 2 * whole_rate, 4);
  append_le(bytes, 2, 2);
  append_le(bytes, 16, 2);
  bytes += "data";
  append_le(bytes, n_bytes, 4);
  for (const double sample : samples) {
    const auto value = static_cast<std::int32_t>(std::lround(32767 * std::clamp(sample, -1.0, 1.0)));
    append_le(bytes, static_cast<std::uint32_t>(value), 2);
  }
  return bytes;
}

}  // namespace klang::reports::detail
