#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/liquid/liquid_step.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

/// tests/reference/liquid.json: standing_wave_2d, L = 0.2 m, depth 0.1 m, mode 2.
constexpr double kWaveTank_m = 0.2, kWaveDepth_m = 0.1, kWaveOmega = 17.522594830545945,
                 kWaveNumber = 31.41592653589793;
constexpr double kWavePeriods = 3.0;

struct Found {
  Level level;
  double loss_per_period = 0.0;
};

/// Amplitude of the mode, over the first.
double wave_amplitude(const liquid::Liquid& water) {
  const liquid::GridShape& shape = water.shape();
  double sum = 0.0;
  for (int i = 0; i < shape.nx; ++i)
    for (int k = 0; k + 1 < shape.nz; ++k) {
      const double low = water.phi_m()(i, 0, k), high = water.phi_m()(i, 0, k + 1);
      if (low < 0.0 && high >= 0.0)
        sum += shape.cell_m * (k + 0.5 + low / (low - high)) * std::cos(kWaveNumber * (i + 0.5) * shape.cell_m);
    }
  return 2.0 * sum / shape.nx * kWaveNumber / 0.01;
}

Found swing(int n, Monitor& monitor) {
  const Stopwatch watch;
  liquid::LiquidSetup setup;
  const double h = kWaveTank_m / n;
  setup.shape = {n, 2, static_cast<int>(std::ceil(0.7 * n)), h};
  setup.pools.push_back({Eigen::Vector3d::Zero(), Eigen::Vector3d(kWaveTank_m, 2.0 * h, kWaveDepth_m),
                         liquid::PoolWave{0.01 / kWaveNumber, 2, 0}});
  liquid::Liquid water(setup);
  std::vector<double> crossings, peaks;
  double before = wave_amplitude(water), earlier = before, t_before = 0.0;
  std::size_t n_steps = 0;
  water.advance_to(kWavePeriods * 2.0 * kPi / kWaveOmega, [&](const liquid::LiquidStep& step) {
    monitor.throw_if_stopped();
    const double now = wave_amplitude(water);
    if (now * before < 0.0) crossings.push_back(t_before + (step.time_s - t_before) * before / (before - now));
    if (std::abs(before) > std::abs(earlier) && std::abs(before) >= std::abs(now)) peaks.push_back(std::abs(before));
    earlier = before;
    before = now;
    t_before = step.time_s;
    ++n_steps;
  });
  Found found;
  found.level.h_m = h;
  found.level.n_unknowns = static_cast<double>(setup.shape.n_cells());
  found.level.exact = kWaveOmega;
  if (crossings.size() >= 2 && peaks.size() >= 2) {
    found.level.value = kPi * static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
    found.loss_per_period = 1.0 - std::pow(peaks.back() / peaks.front(), 2.0 / static_cast<double>(peaks.size() - 1));
  }
  found.level.error = found.level.value ? std::abs(*found.level.value / kWaveOmega - 1.0) : std::nan("");
  found.level.wall_time_s = watch.seconds();
  return found;
}

}  // namespace

/// A standing gravity wave of small amplitude.
Study liquid_wave_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "A standing wave of a liquid with a free surface";
  study.question =
      "Does a wave of small amplitude (k a = 0.01) swing at the frequency of the linear theory, and what does it lose "
      "per "
      "period?";
  Series series;
  series.id = "frequency";
  series.title = "Second mode of a tank of 0.2 m, 0.1 m deep";
  series.reference = "ω² = g k tanh k h (15 digits)";
  series.step_words = "cell [m]";
  series.error_words = "relative error of the frequency";
  series.expected_order = std::nan("");
  series.error_tolerance = 0.005;
  series.exact_value = kWaveOmega;
  if (!wanted(options, series.id)) return study;
  constexpr std::array<int, 4> kCells{8, 16, 32, 64};
  const std::size_t n = level_count(options, kCells.size());
  for (std::size_t i = 0; i < n; ++i) {
    monitor.progress("wave", static_cast<double>(i) / static_cast<double>(n));
    const Found found = swing(kCells[i], monitor);
    series.levels.push_back(found.level);
    if (kCells[i] == 32) {
      study.claims.push_back(judged({"wave.frequency-32-cells",
                                     "relative error of the frequency at 32 cells per wavelength",
                                     found.level.error,
                                     {},
                                     0.005,
                                     {},
                                     false}));
      study.claims.push_back(judged({"wave.loss-32-cells",
                                     "share of the amplitude that is lost per period, 32 cells per wavelength",
                                     std::abs(found.loss_per_period),
                                     {},
                                     0.02,
                                     {},
                                     false}));
    }
  }
  study.series.push_back(std::move(series));
  return study;
}

}  // namespace klang::validate
