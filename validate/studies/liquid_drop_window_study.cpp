#include <array>
#include <cmath>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/liquid/liquid_step.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using Eigen::Vector3d;

/// A quarter of the tank, the drop over its edge: walls are planes of symmetry.
constexpr double kRadius_m = 2e-3, kWidth_m = 16e-3, kHeight_m = 28e-3, kDepth_m = 18e-3, kStart_m = 1e-3;
constexpr double kEnd_s = 0.032, kCrater_s = 0.008;  ///< hollows before are air under the drop as it lands

struct Fall {
  const char* id;
  double height_m;
  bool entrains;  ///< Pumphrey and Elmore (1990): between 73 and 124 mm for 4 mm
};
constexpr std::array<Fall, 4> kFalls{{{"fall-040mm", 0.040, false},
                                      {"fall-085mm", 0.085, true},
                                      {"fall-110mm", 0.110, true},
                                      {"fall-200mm", 0.200, false}}};

/// Volume of air that no way through air leads from to the top: of phi > 0 by cells.
double closed_air_m3(const liquid::GridShape& shape, const liquid::Field& phi) {
  std::vector<char> seen(phi.size(), 0);
  std::vector<std::array<int, 3>> open;
  const auto enter = [&](int i, int j, int k) {
    if (!phi.contains(i, j, k) || !(phi(i, j, k) > 0.0) || seen[phi.index(i, j, k)] != 0) return;
    seen[phi.index(i, j, k)] = 1;
    open.push_back({i, j, k});
  };
  for (int j = 0; j < shape.ny; ++j)
    for (int i = 0; i < shape.nx; ++i) enter(i, j, shape.nz - 1);
  while (!open.empty()) {
    const auto [i, j, k] = open.back();
    open.pop_back();
    for (int c = -1; c <= 1; ++c)
      for (int b = -1; b <= 1; ++b)
        for (int a = -1; a <= 1; ++a) enter(i + a, j + b, k + c);
  }
  std::size_t n = 0;
  for (std::size_t c = 0; c < phi.size(); ++c) n += phi[c] > 0.0 && seen[c] == 0 ? 1 : 0;
  return 4.0 * static_cast<double>(n) * shape.cell_m * shape.cell_m * shape.cell_m;
}

/// How far air reaches below the surface at rest, on the drop's axis.
double crater_m(const liquid::GridShape& shape, const liquid::Field& phi) {
  for (int k = 0; k < shape.nz; ++k)
    if (phi(0, 0, k) > 0.0) return kDepth_m - shape.cell_m * k;
  return 0.0;
}

struct Landing {
  double closed_m3 = 0.0;  ///< the most at any time after kCrater_s
  double crater_m = 0.0;
  double n_cells = 0.0, wall_time_s = 0.0;
};

Landing land(double fall_m, double cell_m, Monitor& monitor) {
  const Stopwatch watch;
  liquid::LiquidSetup setup;
  const auto n = [&](double length_m) { return static_cast<int>(std::lround(length_m / cell_m)); };
  setup.shape = {n(kWidth_m), n(kWidth_m), n(kHeight_m), cell_m};
  setup.options.longest_step_s = 2.5e-4;
  setup.pools.push_back({Vector3d::Zero(), Vector3d(kWidth_m, kWidth_m, kDepth_m), {}});
  const double gravity = setup.options.gravity_m_s2;
  setup.drops.push_back({kRadius_m, Vector3d(0.0, 0.0, kDepth_m + kRadius_m + kStart_m),
                         Vector3d(0.0, 0.0, -std::sqrt(2.0 * gravity * (fall_m - kStart_m)))});
  liquid::Liquid water(setup);
  Landing landing;
  const double contact_s = kStart_m / std::sqrt(2.0 * gravity * fall_m);
  water.advance_to(contact_s + kEnd_s, [&](const liquid::LiquidStep& step) {
    monitor.throw_if_stopped();
    landing.crater_m = std::max(landing.crater_m, crater_m(setup.shape, water.phi_m()));
    if (step.time_s > contact_s + kCrater_s)
      landing.closed_m3 = std::max(landing.closed_m3, closed_air_m3(setup.shape, water.phi_m()));
  });
  landing.n_cells = static_cast<double>(setup.shape.n_cells());
  landing.wall_time_s = watch.seconds();
  return landing;
}

}  // namespace

/// Whether the crater of a falling drop pinches a bubble off.
Study liquid_drop_window_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "The window in which a falling drop entrains a bubble";
  study.question =
      "Does the crater of a drop of 4 mm pinch a bubble off after a fall of 85 and 110 mm and none after 40 and 200 "
      "mm, as "
      "experiments have it (between 73 and 124 mm)? The air weighs nothing here, and no smaller bubble than a cell is "
      "seen.";
  constexpr std::array<double, 3> kCells_m{1e-3, 5e-4, 2.5e-4};
  const std::size_t n = level_count(options, kCells_m.size());
  for (const Fall& fall : kFalls) {
    if (!wanted(options, fall.id)) continue;
    Series series;
    series.id = fall.id;
    series.title = fall.entrains ? "A fall within the window: a bubble" : "A fall outside the window: none";
    series.reference = "Pumphrey and Elmore (1990), regular entrainment";
    series.step_words = "cell [m]";
    series.error_words = "0: as in the experiment, 1: not";
    series.expected_order = std::nan("");
    series.error_tolerance = 0.5;
    for (std::size_t i = 0; i < n; ++i) {
      monitor.progress(fall.id, static_cast<double>(i) / static_cast<double>(n));
      const Landing landing = land(fall.height_m, kCells_m[i], monitor);
      Level level;
      level.h_m = kCells_m[i];
      level.value = std::cbrt(6.0 * landing.closed_m3 / kPi);  // the bubble's diameter
      level.error = (landing.closed_m3 > 0.0) == fall.entrains ? 0.0 : 1.0;
      level.n_unknowns = landing.n_cells;
      level.wall_time_s = landing.wall_time_s;
      level.points.push_back({0.0, 0.0, landing.crater_m, 0.0});
      series.levels.push_back(level);
    }
    study.series.push_back(std::move(series));
  }
  return study;
}

}  // namespace klang::validate
