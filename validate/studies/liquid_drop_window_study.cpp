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

/// A round tank and the drop over its middle, the same all around: the grid is a half plane.
constexpr double kRadius_m = 2e-3, kWidth_m = 14e-3, kHeight_m = 26e-3, kDepth_m = 16e-3, kStart_m = 0.3e-3;
constexpr double kEnd_s = 0.032, kCrater_s = 0.003;  ///< hollows before are air under the drop as it lands
constexpr double kSmallest_cells = 4.0;              ///< across: smaller bubbles are no result of the grid

struct Fall {
  const char* id;
  double height_m;
  bool entrains;  ///< Pumphrey and Elmore (1990): between 73 and 124 mm for 4 mm
};
constexpr std::array<Fall, 4> kFalls{{{"fall-040mm", 0.040, false},
                                      {"fall-085mm", 0.085, true},
                                      {"fall-110mm", 0.110, true},
                                      {"fall-200mm", 0.200, false}}};

/// Volume of air that no way through air leads from to the top: rings of cells where phi > 0.
double closed_air_m3(const liquid::GridShape& shape, const liquid::Field& phi) {
  std::vector<char> seen(phi.size(), 0);
  std::vector<std::array<int, 2>> open;
  const auto enter = [&](int i, int k) {
    if (!phi.contains(i, 0, k) || !(phi(i, 0, k) > 0.0) || seen[phi.index(i, 0, k)] != 0) return;
    seen[phi.index(i, 0, k)] = 1;
    open.push_back({i, k});
  };
  for (int i = 0; i < shape.nx; ++i) enter(i, shape.nz - 1);
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    for (int c = -1; c <= 1; ++c)
      for (int a = -1; a <= 1; ++a) enter(i + a, k + c);
  }
  double volume = 0.0;
  const double h = shape.cell_m;
  for (int k = 0; k < shape.nz; ++k)
    for (int i = 0; i < shape.nx; ++i)
      if (phi(i, 0, k) > 0.0 && seen[phi.index(i, 0, k)] == 0) volume += 2.0 * kPi * (i + 0.5) * h * h * h;
  return volume;
}

/// How far air reaches below the surface at rest, on the drop's axis.
double crater_m(const liquid::GridShape& shape, const liquid::Field& phi) {
  for (int k = 0; k < shape.nz; ++k)
    if (phi(0, 0, k) > 0.0) return kDepth_m - shape.cell_m * k;
  return 0.0;
}

struct Landing {
  double closed_m3 = 0.0, closed_s = 0.0;  ///< the most at any time after kCrater_s, and that time after contact
  double crater_m = 0.0;
  double n_cells = 0.0, wall_time_s = 0.0;
};

Landing land(double fall_m, double cell_m, Monitor& monitor) {
  const Stopwatch watch;
  liquid::LiquidSetup setup;
  const auto n = [&](double length_m) { return static_cast<int>(std::lround(length_m / cell_m)); };
  setup.round = true;
  setup.shape = {n(kWidth_m), 1, n(kHeight_m), cell_m};
  setup.options.longest_step_s = 2.5e-4;
  setup.options.cfl = 1.0;
  setup.options.tension = true;
  setup.options.pressure_tolerance = 1e-7;  // fluxes at the axis are small
  setup.pools.push_back({Vector3d::Zero(), Vector3d(kWidth_m, cell_m, kDepth_m), {}});
  const double gravity = setup.options.gravity_m_s2;
  setup.drops.push_back({kRadius_m, Vector3d(0.0, 0.5 * cell_m, kDepth_m + kRadius_m + kStart_m),
                         Vector3d(0.0, 0.0, -std::sqrt(2.0 * gravity * (fall_m - kStart_m)))});
  liquid::Liquid water(setup);
  Landing landing;
  const double contact_s = kStart_m / std::sqrt(2.0 * gravity * fall_m);
  water.advance_to(contact_s + kEnd_s, [&](const liquid::LiquidStep& step) {
    monitor.throw_if_stopped();
    landing.crater_m = std::max(landing.crater_m, crater_m(setup.shape, water.phi_m()));
    const double closed = closed_air_m3(setup.shape, water.phi_m());
    if (step.time_s <= contact_s + kCrater_s || !(closed > landing.closed_m3)) return;
    landing.closed_m3 = closed;
    landing.closed_s = step.time_s - contact_s;
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
      "mm, as experiments have it (between 73 and 124 mm)? The flow is the same all around the drop's axis; the air "
      "weighs nothing, there is no viscosity, and no bubble of less than 4 cells counts.";
  constexpr std::array<double, 3> kCells_m{5e-4, 2.5e-4, 1.25e-4};
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
      level.error = (*level.value >= kSmallest_cells * kCells_m[i]) == fall.entrains ? 0.0 : 1.0;
      level.n_unknowns = landing.n_cells;
      level.wall_time_s = landing.wall_time_s;
      level.points.push_back({landing.closed_s, 0.0, landing.crater_m, 0.0});
      series.levels.push_back(level);
    }
    study.series.push_back(std::move(series));
  }
  return study;
}

}  // namespace klang::validate
