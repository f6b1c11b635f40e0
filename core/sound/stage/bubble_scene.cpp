#include "core/sound/stage/bubble_scene.hpp"

#include <chrono>

namespace klang::stage {

BubbleSound synthesise_bubbles(const BubbleScene& scene, Monitor& monitor) {
  const auto start = std::chrono::steady_clock::now();
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
