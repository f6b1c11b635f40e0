#include "core/sound/liquid_scene/sound_stage.hpp"

#include <cmath>

#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/audio/sound_file.hpp"

namespace klang::liquid_scene {

void run_sound(StageRun& run) {
  const Stopwatch watch;
  const stage::BubbleScene& sound = run.scene.sound;
  if (!run.scene.bubbles.empty() || run.scene.entrainment.attempts_per_m2_s > 0.0)
    run.warn("the flow's bubbles are not computed: sound.wav is silent");
  audio::Signal signal;
  signal.sample_rate_hz = sound.sample_rate_hz;
  const double duration_s = sound.duration_s.value_or(run.until_s);
  signal.samples =
      decltype(signal.samples)::Zero(static_cast<Eigen::Index>(std::llround(duration_s * sound.sample_rate_hz)),
                                     static_cast<Eigen::Index>(sound.listener.n_channels()));
  audio::write_sound(run.folder.file("sound.wav"), signal);
  HeardLiquidRecord record;
  record.duration_s = signal.duration_s();
  record.sample_rate_hz = signal.sample_rate_hz;
  record.n_channels = static_cast<int>(signal.n_channels());
  run.document.sound = record;
  run.document.stages.sound = StageRecord{StageStatus::kDone, watch.seconds(), watch.seconds(), 1};
  run.folder.write_document(run.document);
}

}  // namespace klang::liquid_scene
