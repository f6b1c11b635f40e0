#include <array>
#include <cmath>

#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/liquid/pressure.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

constexpr double kColumnWidth_m = 0.05715, kColumnHeight_m = 2.0 * kColumnWidth_m, kColumnGravity = 9.81;

/// tests/reference/liquid.json: released_column. Places, and p / (rho g H).
constexpr std::array<std::array<double, 3>, 16> kColumnPoints{{{0.0, 0.125, 0.2600271970891451},
                                                               {0.0, 0.25, 0.1788046222011039},
                                                               {0.0, 0.5, 0.08006103336143237},
                                                               {0.0, 0.75, 0.03033311469215591},
                                                               {0.25, 0.125, 0.24552242513502645},
                                                               {0.25, 0.25, 0.16714193414413492},
                                                               {0.25, 0.5, 0.07417769091837152},
                                                               {0.25, 0.75, 0.028044546871251175},
                                                               {0.5, 0.125, 0.2002980382413779},
                                                               {0.5, 0.25, 0.13201897242024951},
                                                               {0.5, 0.5, 0.057174848551034475},
                                                               {0.5, 0.75, 0.02150231199923645},
                                                               {0.75, 0.125, 0.11910458089447355},
                                                               {0.75, 0.25, 0.07419721133779121},
                                                               {0.75, 0.5, 0.031170044589205283},
                                                               {0.75, 0.75, 0.01165769372842983}}};

Level released_column(double cells_across) {
  const Stopwatch watch;
  const double h = kColumnWidth_m / cells_across;
  const liquid::GridShape shape{static_cast<int>(cells_across) + 3, 1, static_cast<int>(2.0 * cells_across) + 3, h};
  liquid::Field phi(shape.nx, 1, shape.nz), pressure(shape.nx, 1, shape.nz);
  for (int k = 0; k < shape.nz; ++k)
    for (int i = 0; i < shape.nx; ++i)
      phi(i, 0, k) = std::max((i + 0.5) * h - kColumnWidth_m, (k + 0.5) * h - kColumnHeight_m);
  std::vector<liquid::Solid> solids;
  const liquid::SolidField open = liquid::solid_field(shape, solids);
  liquid::MacGrid u(shape);
  liquid::PressureOptions options;
  options.tolerance = 1e-11;
  for (double& w : u[2].data()) w = -kColumnGravity * options.kick_s;
  const liquid::PressureSolve result = liquid::project(shape, phi, open, solids, {u, pressure}, options);
  Level level;
  level.h_m = h;
  level.n_unknowns = static_cast<double>(result.n_unknowns);
  for (const auto& [x, z, exact] : kColumnPoints) {
    const double height = z * kColumnHeight_m;
    const auto at = [&](double across) {
      return liquid::at_centres(pressure, {across, 0.0, height}, h) / (kColumnGravity * kColumnHeight_m);
    };
    // On the wall the slope across it is 0.
    const double value = x > 0.0 ? at(x * kColumnWidth_m) : (9.0 * at(0.5 * h) - at(1.5 * h)) / 8.0;
    level.points.push_back({x, z, value, exact});
    level.error = std::max(level.error, std::abs(value - exact));
    if (x == 0.5 && z == 0.25) {
      level.value = value;
      level.exact = exact;
    }
  }
  if (!result.converged) level.error = std::nan("");
  level.wall_time_s = watch.seconds();
  return level;
}

}  // namespace

/// The pressure of a column at the instant at which its gate goes.
Study liquid_column_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Pressure of a released column of liquid";
  study.question =
      "Two free surfaces that meet in an edge, neither on faces nor on centres of cells: does the ghost-fluid pressure "
      "converge to the series at second order?";
  Series series;
  series.id = "column";
  series.title = "Column twice as high as wide, at the instant the gate goes";
  series.reference = "alternating series (12 digits)";
  series.step_words = "cell [m]";
  series.error_words = "largest error of p / (ρ g H)";
  series.expected_order = 2.0;
  series.order_tolerance = 0.4;
  series.error_tolerance = 1e-4;
  series.exact_value = 0.13201897242024951;
  if (!wanted(options, series.id)) return study;
  constexpr std::array<double, 5> kCells{8.37, 16.37, 32.37, 64.37, 128.37};
  const std::size_t n = level_count(options, kCells.size());
  series.error_tolerance *= std::pow(kCells.back() / kCells[n - 1], 2.0);
  for (std::size_t i = 0; i < n; ++i) {
    monitor.throw_if_stopped();
    monitor.progress("column", static_cast<double>(i) / static_cast<double>(n));
    series.levels.push_back(released_column(kCells[i]));
  }
  study.series.push_back(std::move(series));
  return study;
}

}  // namespace klang::validate
