#include "core/sound/liquid_scene/sound_stage.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/sound_level.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"
#include "core/sound/liquid_scene/transfer_stage.hpp"

namespace klang::liquid_scene {
namespace {

using entrainment::BubblePath;

constexpr double kTimesFaded = 3.0;  ///< of the time in which a bubble fades to a thousandth

/// A law of pitch so steep that phi can carry any pitch within eight e-foldings, and its inverse: the voice takes the pitch from phi.
bubble::PitchModel carrier_law() {
  bubble::PitchModel law;
  law.kind = bubble::PitchKind::kHarmonicFluids;
  law.k_delta_per_m = 729.5;
  law.largest_factor = 1000.0;
  return law;
}
double carrier_phi(double factor) {
  const bubble::PitchModel law = carrier_law();
  const double scale = law.k_delta_per_m * std::exp(law.eta) * -law.phi0_m / law.eta;
  constexpr double kStart = 0.5;  // e^{-eta phi / phi0} at birth
  return -law.phi0_m / law.eta * std::log(kStart + std::log(factor) / scale);
}

/// How hard a bubble is hit at its birth, over the Laplace pressure of its own: a merger or a split by the jump in that pressure.
double strength(const BubblePath& path, const std::map<std::int64_t, double>& radii) {
  if (path.start == entrainment::StartKind::kEntrained) return 1.0;
  double jump = 0.0;
  for (const std::int64_t parent : path.parents) {
    const auto found = radii.find(parent);
    if (found != radii.end()) jump = std::max(jump, std::abs(path.radius_m / found->second - 1.0));
  }
  return jump > 0.0 ? jump : 1.0;
}

/// Names one of those that are left out.
std::string first_too_high(const stage::BubbleScene& scene, const stage::BubbleSound& made,
                           const std::vector<std::int64_t>& ids) {
  const double limit_hz = audio::highest_rendered_hz(scene.sample_rate_hz);
  for (std::size_t i = 0; i < made.bubbles.size() && i < ids.size(); ++i) {
    const double highest_hz = std::max(made.bubbles[i].frequency_start_hz, made.bubbles[i].frequency_end_hz);
    if (highest_hz >= limit_hz)
      return " (bubble " + std::to_string(ids[i]) + ": " + std::to_string(std::lround(highest_hz)) + " Hz)";
  }
  return {};
}

/// @param ids  of the scene's bubbles
stage::BubbleScene heard_scene(const StageRun& run, std::vector<std::int64_t>& ids) {
  stage::BubbleScene sound = run.scene.sound;
  sound.name = run.scene.name;
  sound.pitch = carrier_law();
  sound.duration_s = sound.duration_s.value_or(run.until_s);
  if (run.scene.transfer.method == TransferMethod::kUnit) sound.transfer = stage::SceneTransfer::kUnit;
  if (run.document.n_bubbles == 0) return sound;
  std::vector<BubblePath> paths = entrainment::read_tracked_bubbles(run.folder.file("bubbles.trk")).paths;
  const auto transfers = read_transfers(run.folder.file("transfer.csv"));
  std::map<std::int64_t, double> radii;
  for (const BubblePath& path : paths) radii[path.id] = path.radius_m;
  for (BubblePath& path : paths) {
    const std::optional<HeardBubble> one = heard(path, sound);
    const auto rows = transfers.find(path.id);
    const bool unit = sound.transfer == stage::SceneTransfer::kUnit;
    if (!one || (!unit && rows == transfers.end())) continue;
    stage::SceneBubble bubble;
    bubble.radius_m = one->radius_m;
    bubble.birth_s = one->birth_s;
    bubble.strength = strength(path, radii);
    bubble::SampledMotion motion;
    if (path.time_s.front() > one->birth_s) {
      motion.times_s.push_back(0.0);
      motion.positions_m.push_back(path.position_m.front());
      motion.phi_m.push_back(carrier_phi(1.0));
    }
    for (std::size_t i = 0; i < path.time_s.size(); ++i) {
      // Most bubbles live a hundred times as long as they sound, also with a pitch that falls.
      if (i >= 8 && path.time_s[i - 8] > one->birth_s + kTimesFaded * (one->faded_s - one->birth_s)) break;
      motion.times_s.push_back(path.time_s[i] - one->birth_s);
      motion.positions_m.push_back(path.position_m[i]);
      motion.phi_m.push_back(carrier_phi(path.frequency_hz[i] / path.frequency_hz.front()));
    }
    bubble.motion = bubble::sampled_motion(std::move(motion));
    if (!unit) bubble.transfer = std::make_shared<const bubble::TransferSeries>(rows->second, "transfer.csv");
    sound.bubbles.push_back(std::move(bubble));
    ids.push_back(path.id);
    path = {};  // gigabytes, all together
  }
  return sound;
}

}  // namespace

void run_sound(StageRun& run) {
  const StageWatch watch;
  std::vector<std::int64_t> ids;
  const stage::BubbleScene scene = heard_scene(run, ids);
  audio::Signal signal;
  double peak = 0.0, gain = 1.0;
  if (!scene.bubbles.empty()) {
    stage::BubbleSound made = stage::synthesise_bubbles(scene, run.monitor);
    signal = std::move(made.sound);
    peak = signal.n_frames() > 0 ? signal.samples.cwiseAbs().maxCoeff() : 0.0;
    const bool unit = scene.transfer == stage::SceneTransfer::kUnit;  // metres, not pascals
    if (unit && peak > 0.0) gain = std::pow(10.0, scene.peak_db_re_full_scale / 20.0) / peak;
    if (!unit) gain = audio::file_gain(peak, scene.peak_db_re_full_scale);
    if (!unit && audio::is_inaudible(peak)) run.warn(audio::inaudible_note(peak));
    signal.samples *= gain;
    if (made.n_too_high > 0)
      run.warn(std::to_string(made.n_too_high) +
               " bubble(s) are left out: their pitch reaches half of the sample rate" +
               first_too_high(scene, made, ids));
  }
  if (scene.bubbles.empty() || signal.n_frames() == 0) {
    signal.sample_rate_hz = scene.sample_rate_hz;
    signal.samples = decltype(signal.samples)::Zero(
        static_cast<Eigen::Index>(std::llround(*scene.duration_s * scene.sample_rate_hz)),
        static_cast<Eigen::Index>(scene.listener.n_channels()));
  }
  const auto n_left_out = run.document.n_bubbles - static_cast<std::int64_t>(scene.bubbles.size());
  if (n_left_out > 0)
    run.warn(std::to_string(n_left_out) +
             " bubble(s) are not heard: born outside the liquid, or of a pitch that no free bubble has");
  audio::write_sound(run.folder.file("sound.wav"), signal);
  HeardLiquidRecord record;
  record.duration_s = signal.duration_s();
  record.sample_rate_hz = signal.sample_rate_hz;
  record.n_channels = static_cast<int>(signal.n_channels());
  record.peak_pressure_pa = peak;
  record.gain = gain;
  run.document.sound = record;
  run.document.stages.sound = StageRecord{StageStatus::kDone, watch.seconds(), watch.cpu_s(), 1};
  run.folder.write_document(run.document);
}

}  // namespace klang::liquid_scene
