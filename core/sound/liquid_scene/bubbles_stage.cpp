#include "core/sound/liquid_scene/bubbles_stage.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/output_file.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/entrainment/entrainment.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/sound/liquid_scene/from_recording.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"

namespace klang::liquid_scene {
using entrainment::RadiusDistribution;

RadiusDistribution radii_of(const EntrainmentTable& table) {
  RadiusDistribution radii;
  radii.smallest_m = table.smallest_m;
  radii.largest_m = table.largest_m;
  if (table.radii == RadiusKind::kGaussian) {
    radii.kind = RadiusDistribution::Kind::kGaussian;
    radii.mean_m = table.mean_m.value_or(radii.mean_m);
    radii.std_m = table.std_m.value_or(radii.std_m);
  } else if (table.radii == RadiusKind::kRecording) {
    radii.kind = RadiusDistribution::Kind::kRecorded;
    radii.recorded_m = recorded_radii(table.recording);
  }
  return radii;
}

namespace {

using entrainment::Birth;
using entrainment::BubblePath;
using entrainment::EntrainmentOptions;

EntrainmentOptions options_of(const EntrainmentTable& table) {
  EntrainmentOptions options;
  options.attempts_per_m2_s = table.given ? table.attempts_per_m2_s : 0.0;
  options.seeds = {
      table.window_s, table.threshold_m_s, table.seed_life_s,
      table.criterion == "velocity" ? entrainment::SeedCriterion::kVelocity : entrainment::SeedCriterion::kSlope};
  options.coverage = table.coverage;
  options.consume = table.consume;
  options.form =
      table.literature == "paper" ? entrainment::EntrainmentForm::kPaper : entrainment::EntrainmentForm::kMended;
  options.radii = radii_of(table);
  for (const SeedPatch& patch : table.patches)
    options.patches.push_back({patch.low_m, patch.high_m, patch.start_s, patch.end_s});
  return options;
}

/// Seeds and attempts into the run; says where hardly an attempt found its surface covered.
std::vector<Birth> entrained(StageRun& run, const liquid::LiquidFrames& frames, const EntrainmentOptions& options) {
  constexpr std::size_t kFewAttempts = 20;
  constexpr double kNearlyAll = 0.9;
  run.document.entrainment.reset();
  if (!(options.attempts_per_m2_s > 0.0)) return {};
  entrainment::Births found = find_births(frames, options, run.seed, run.monitor);
  const auto count = [](std::size_t n) { return static_cast<std::int64_t>(n); };
  const std::vector<double>& recorded = options.radii.recorded_m;
  const auto n_outside = std::count_if(recorded.begin(), recorded.end(), [&](double r) {
    return !(r >= options.radii.smallest_m && r <= options.radii.largest_m);
  });
  if (n_outside > 0)
    run.warn(std::to_string(n_outside) + " of the recording's " + std::to_string(recorded.size()) +
             " radii lie outside smallest_m to largest_m (" + to_text(options.radii.smallest_m) + " to " +
             to_text(options.radii.largest_m) + " m) and are hardly made");
  run.document.entrainment = EntrainmentRecord{count(found.n_seeds), count(found.n_attempts), count(found.n_rejected)};
  const std::span<const double> times = frames.time_s();
  if (found.n_seeds == 0 && options.patches.empty() && times.size() > 1 &&
      options.seeds.window_s < 2.0 * (times[1] - times[0]) * (1.0 - 1e-9))
    run.warn("no seeds were found: window_s = " + to_text(options.seeds.window_s) +
             " holds fewer than three frames, which are " + to_text(times[1] - times[0]) + " s apart");
  if (found.n_attempts >= kFewAttempts &&
      static_cast<double>(found.n_rejected) >= kNearlyAll * static_cast<double>(found.n_attempts))
    run.warn(std::to_string(found.n_rejected) + " of " + std::to_string(found.n_attempts) +
             " attempts to make a bubble were refused, since seeds covered less than coverage = " +
             to_text(options.coverage) + " asks for; 0 refuses none");
  return std::move(found.births);
}

/// The pitch along a path, by the scene's law from phi. Eq. (6) counts from the depth of birth, whose pitch it takes as the free bubble's: one
/// that the flow drags down would end an octave below it. No depth makes a bubble lower than free. @param floor  false: as printed
void give_pitch(BubblePath& path, const stage::BubbleScene& sound, bool floor) {
  const double free_hz = bubble::bubble_oscillation(path.radius_m, sound.medium, sound.theory).undamped_frequency_hz;
  const auto below = [](double phi) { return std::min(phi, -1e-6); };  // the law holds below the surface
  for (const double phi : path.phi_m) {
    const double factor = bubble::pitch_factor(sound.pitch, path.radius_m, below(phi), below(path.phi_m.front()));
    path.frequency_hz.push_back(free_hz * (floor ? std::max(1.0, factor) : factor));
  }
}

void add_scripted(StageRun& run, const liquid::LiquidFrames& frames, std::vector<Birth>& births) {
  const double end_s = frames.time_s().back();
  std::size_t n_late = 0;
  for (const ScriptedBubble& scripted : run.scene.bubbles) {
    if (scripted.birth_s > end_s) {
      ++n_late;
      continue;
    }
    births.push_back(
        {scripted.radius_m, scripted.birth_s, scripted.position_m,
         liquid::velocity_m_s(frames, scripted.birth_s, scripted.position_m).value_or(Eigen::Vector3d::Zero())});
  }
  if (n_late > 0)
    run.warn(std::to_string(n_late) + " [[bubble]](s) would be born after the run's end (" + to_text(end_s) + " s)");
}

}  // namespace

std::size_t count_births(const LiquidScene& scene, const RunFolder& folder, std::size_t n_frames, std::uint64_t seed,
                         double attempts_per_m2_s, Monitor& monitor) {
  EntrainmentOptions options = options_of(scene.entrainment);
  options.attempts_per_m2_s = attempts_per_m2_s;
  return find_births(*folder_frames(scene, folder, n_frames), options, seed, monitor).births.size();
}

void run_bubbles(StageRun& run) {
  const StageWatch watch;
  const auto n_frames = static_cast<std::size_t>(std::max<std::int64_t>(run.document.n_frames, 1));
  const std::unique_ptr<liquid::LiquidFrames> frames = folder_frames(run.scene, run.folder, n_frames);
  const EntrainmentOptions options = options_of(run.scene.entrainment);
  if (options.attempts_per_m2_s > 0.0 && options.patches.empty() && run.document.imported &&
      !run.document.imported->has_velocity)
    throw InputError("[entrainment]", "these frames have no velocity, without which no marker moves", "",
                     "[[entrainment.patch]], [[bubble]], or frames with velocity");
  std::vector<Birth> births = entrained(run, *frames, options);
  const double end_s = frames->time_s().back();
  add_scripted(run, *frames, births);
  std::stable_sort(births.begin(), births.end(), [](const Birth& a, const Birth& b) { return a.time_s < b.time_s; });
  entrainment::RiseSettings rise;
  const std::string& drag = run.scene.entrainment.drag;
  rise.drag = drag == "clean"   ? entrainment::Drag::kClean
              : drag == "paper" ? entrainment::Drag::kPaper
                                : entrainment::Drag::kContaminated;
  rise.medium = run.scene.sound.medium;
  rise.gravity_m_s2 = run.scene.setup.options.gravity_m_s2;
  std::vector<BubblePath> paths = paths_of(*frames, births, rise, run.monitor);
  const bool paper = options.form == entrainment::EntrainmentForm::kPaper;
  for (BubblePath& path : paths) give_pitch(path, run.scene.sound, !paper);
  write_file(run.folder.file("bubbles.csv"), entrainment::bubbles_csv(entrainment::bubble_rows(
                                                 paths, rise.medium, run.scene.sound.theory, run.scene.sound.pitch)));
  entrainment::write_tracked_bubbles(run.folder.file("bubbles.trk"), paths);
  run.document.n_bubbles = static_cast<std::int64_t>(paths.size());
  run.document.births_per_s = end_s > 0.0 ? static_cast<double>(paths.size()) / end_s : 0.0;
  run.document.stages.bubbles =
      StageRecord{StageStatus::kDone, watch.seconds(), watch.cpu_s(), static_cast<std::int64_t>(n_frames)};
  run.folder.write_document(run.document);
}

}  // namespace klang::liquid_scene
