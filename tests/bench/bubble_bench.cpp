// Bubble scenes in stereo, transfer in closed form. Bar: 8,000 bubbles in 5 s of sound in less than 5 s on 2 cores.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/sound/stage/bubble_scene.hpp"

namespace {

using namespace klang::bubble;
using namespace klang::stage;

BubbleScene scene_of(int count, double seconds, const char* rise) {
  return parse_bubble_scene(
      "[sound]\nduration_s = " + std::to_string(seconds) + "\n[pitch]\nphi0_m = -0.012\n[[population]]\ncount = " +
          std::to_string(count) + "\ntime_end_s = " + std::to_string(seconds) +
          "\nradius_m = 0.0012\nspread = 0.45\nsmallest_radius_m = 0.0005\nlargest_radius_m = 0.006\n"
          "box_low_m = [-0.08, -0.08, -0.06]\nbox_high_m = [0.08, 0.08, -0.01]\nrise = \"" +
          rise + "\"\n",
      "bench", ".", 1);
}

// A transfer for each bubble, a value a millisecond, as a solver would give it.
void add_transfers(BubbleScene& scene) {
  std::size_t i = 0;
  for (SceneBubble& bubble : scene.bubbles) {
    std::vector<TransferSeries::Row> rows;
    for (int k = 0; k < 300; ++k)
      rows.push_back({bubble.birth_s + 1e-3 * k, 2000.0,
                      std::polar(1e3 * (1.0 + 0.3 * std::sin(0.1 * k)), 0.05 * k + static_cast<double>(i))});
    bubble.transfer = std::make_shared<const TransferSeries>(std::move(rows), "bench");
    ++i;
  }
}

void BM_Bubbles_sound(benchmark::State& state, int count, double seconds, const char* rise, bool transfers = false) {
  BubbleScene scene = scene_of(count, seconds, rise);
  if (transfers) add_transfers(scene);
  for (auto _ : state) {
    const BubbleSound sound = synthesise_bubbles(scene);
    if (sound.status != BubbleSoundStatus::kDone) state.SkipWithError("silent");
    benchmark::DoNotOptimize(sound.sound.samples.data());
  }
  state.counters["times_real_time"] =
      benchmark::Counter(seconds * static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}
BENCHMARK_CAPTURE(BM_Bubbles_sound, 100_bubbles, 100, 0.1, "terminal")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Bubbles_sound, 8000_rising, 8000, 5.0, "terminal")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Bubbles_sound, 8000_fixed, 8000, 5.0, "fixed")
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(BM_Bubbles_sound, 8000_with_transfers, 8000, 5.0, "terminal", true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

// One track and its voice: time per sample. A bubble of 40 mm rings for seconds.
void BM_Bubbles_one_track(benchmark::State& state, double radius_m) {
  RingingBubble bubble;
  bubble.radius_m = radius_m;
  RiseOptions rise;
  rise.kind = RiseKind::kTerminal;
  bubble.motion = analytic_rise({0, 0, -0.03 - radius_m}, radius_m, rise);
  double seconds = 0.0;
  for (auto _ : state) {
    const RingTrack track = ring_track(bubble);
    seconds = track.end_s;
    benchmark::DoNotOptimize(track.blocks.data());
  }
  state.counters["life_s"] = seconds;
}
BENCHMARK_CAPTURE(BM_Bubbles_one_track, 1_mm, 1e-3)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_Bubbles_one_track, 5_mm, 5e-3)->Unit(benchmark::kMicrosecond);

}  // namespace
