#include "reports/kit/audio_clip.hpp"

#include <algorithm>
#include <cmath>

#include "core/sound/audio/resample.hpp"
#include "core/sound/audio/sound_file.hpp"

namespace klang::reports::detail {
namespace {

Eigen::Index clip_length(const audio::Signal& sound, double max_duration_s) {
  return std::min(sound.n_frames(), static_cast<Eigen::Index>(std::max(1.0, max_duration_s * sound.sample_rate_hz)));
}

}  // namespace

double clip_gain(const audio::Signal& sound, double max_duration_s) {
  const Eigen::Index n = clip_length(sound, max_duration_s);
  const double peak = n > 0 ? sound.samples.col(0).head(n).cwiseAbs().maxCoeff() : 0.0;
  return peak > 0 ? std::clamp(0.9 / peak, 1e-6, 1e6) : 1.0;
}

std::string flac_clip(const audio::Signal& sound, double max_duration_s, double gain) {
  const Eigen::Index n = clip_length(sound, max_duration_s);
  audio::Signal clip;
  clip.sample_rate_hz = sound.sample_rate_hz;
  clip.samples = gain * sound.samples.col(0).head(n);
  constexpr double kHighestRate = 48000, kLowestRate = 8000;
  const double rate = sound.sample_rate_hz;
  if (rate > kHighestRate || rate < kLowestRate || rate != std::floor(rate)) {
    clip = audio::resample(clip, std::clamp(std::floor(rate), kLowestRate, kHighestRate));
  }
  if (n < sound.n_frames()) {
    const Eigen::Index n_clip = clip.n_frames();
    const Eigen::Index fade = std::min(n_clip, static_cast<Eigen::Index>(0.03 * clip.sample_rate_hz));
    for (Eigen::Index i = 0; i < fade; ++i)
      clip.samples(n_clip - 1 - i, 0) *= static_cast<double>(i) / static_cast<double>(fade);
  }
  return audio::flac_bytes(clip);
}

}  // namespace klang::reports::detail
