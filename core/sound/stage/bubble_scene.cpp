#include "core/sound/stage/bubble_scene.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::stage {
namespace {

constexpr double kMostSampleBytes = 2e9, kBytesPerSample = 16.0;  // the mix and the sound made of it

/// What the sound takes is known before it is made.
void check_memory(const BubbleScene& scene) {
  double length_s = scene.duration_s.value_or(0.0);
  if (!scene.duration_s)
    for (const SceneBubble& bubble : scene.bubbles) length_s = std::max(length_s, bubble.birth_s);
  const double n_bytes = length_s * scene.sample_rate_hz * scene.listener.n_channels() * kBytesPerSample;
  if (!(n_bytes <= kMostSampleBytes))
    throw InputError(scene.name,
                     "a sound of " + to_text(std::round(length_s)) + " s at " + to_text(scene.sample_rate_hz) +
                         " Hz takes too much memory",
                     to_text(std::round(n_bytes / 1e8) / 10.0) + " GB",
                     "up to 2 GB: a shorter duration_s or births that end sooner, a lower sample_rate_hz, mono");
}

}  // namespace

BubbleSound synthesise_bubbles(const BubbleScene& scene, Monitor& monitor) {
  const auto start = std::chrono::steady_clock::now();
  check_memory(scene);
  events::EventLog log;
  std::vector<BubbleSource> sources;
  for (const SceneBubble& bubble : scene.bubbles) {
    log.bubbles.push_back({bubble.birth_s, bubble.radius_m, bubble.strength, bubble.motion->position_m(0.0)});
    sources.push_back({bubble.motion, bubble.transfer});
  }
  BubbleVoice voice(scene, std::move(sources));
  Voice* const voices[] = {&voice};
  BubbleSound result;
  result.sound = render(log, voices, scene.listener, {scene.sample_rate_hz, scene.duration_s}, monitor);
  result.sound.origin = scene.name;
  result.bubbles = voice.bubbles();
  result.n_too_high = voice.n_too_high();
  const bool silent = result.sound.n_frames() == 0 || !(result.sound.samples.cwiseAbs().maxCoeff() > 0.0);
  result.status = silent ? BubbleSoundStatus::kSilent : BubbleSoundStatus::kDone;
  result.wall_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace klang::stage
