#include <array>
#include <cmath>
#include <functional>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/liquid/carried_level.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using Eigen::Vector3d;

/// A shape that a given flow carries about and brings back.
struct Case {
  liquid::GridShape shape;
  std::function<double(const Vector3d&)> phi;
  std::function<Vector3d(const Vector3d&, double)> flow;
  double end_s = 1.0, exact = 0.0;
  int n_steps = 1;
};

/// tests/reference/liquid.json: zalesak_disk, scaled to the unit square; x and z are its plane.
double zalesak_phi(const Vector3d& x) {
  const double dx = x.x() - 0.5, dz = x.z() - 0.75;
  const double disc = std::hypot(dx, dz) - 0.15;
  const double qx = std::abs(dx) - 0.025, qz = x.z() - 0.85;  // the slot is open downwards
  const double slot = std::hypot(std::max(qx, 0.0), std::max(qz, 0.0)) + std::min(std::max(qx, qz), 0.0);
  return std::max(disc, -slot);
}

Case zalesak(int n) {
  Case c;
  c.shape = {n, 1, n, 1.0 / n};
  c.phi = zalesak_phi;
  c.flow = [](const Vector3d& x, double) {
    return Vector3d(2.0 * kPi * (0.5 - x.z()), 0.0, 2.0 * kPi * (x.x() - 0.5));
  };
  c.exact = 0.0582207030588901;
  c.n_steps = 6 * n;
  return c;
}

/// tests/reference/liquid.json: enright_sphere (LeVeque's flow).
Case enright(int n) {
  Case c;
  c.shape = {n, n, n, 1.0 / n};
  c.phi = [](const Vector3d& x) { return (x - Vector3d(0.35, 0.35, 0.35)).norm() - 0.15; };
  c.flow = [](const Vector3d& x, double t) {
    const auto s = [](double v) { return std::sin(kPi * v); };
    const auto d = [](double v) { return std::sin(2.0 * kPi * v); };
    return Vector3d(std::cos(kPi * t / 3.0) * Vector3d(2.0 * s(x.x()) * s(x.x()) * d(x.y()) * d(x.z()),
                                                       -d(x.x()) * s(x.y()) * s(x.y()) * d(x.z()),
                                                       -d(x.x()) * d(x.y()) * s(x.z()) * s(x.z())));
  };
  c.end_s = 3.0;
  c.exact = 0.01413716694115407;
  c.n_steps = 4 * n;
  return c;
}

/// What came back.
struct Carried {
  double volume = 0.0;     ///< of a plane shape: area
  double different = 0.0;  ///< share of the shape
};

/// @param shifts  the surface is shifted in each step so that the volume is kept, as the solver does; else what is lost is lost
Carried carry(const Case& c, bool shifts, Monitor& monitor) {
  const liquid::GridShape& shape = c.shape;
  const double h = shape.cell_m;
  const liquid::SolidField open = liquid::solid_field(shape, {});
  liquid::Field phi(shape.nx, shape.ny, shape.nz);
  liquid::Particles particles;
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        phi(i, j, k) = c.phi(shape.centre_m(i, j, k));
        for (int s = 0; s < 8; ++s) {
          const Vector3d x =
              h * Vector3d(i + 0.25 + 0.5 * (s & 1), j + 0.25 + 0.5 * ((s >> 1) & 1), k + 0.25 + 0.5 * (s >> 2));
          if (c.phi(x) < 0.0) particles.add(x, Eigen::Vector3f::Zero());
        }
      }
  const liquid::Field first = phi;
  particles.sort(shape);
  const liquid::Grid3<std::uint8_t> everywhere(shape.nx, shape.ny, shape.nz, 1);
  const double step_s = c.end_s / c.n_steps;
  liquid::MacGrid u(shape);
  liquid::update_carried(shape, phi, {u}, {}, particles);
  for (int step = 0; step < c.n_steps; ++step) {
    monitor.throw_if_stopped();
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < u[axis].nz(); ++k)
        for (int j = 0; j < u[axis].ny(); ++j)
          for (int i = 0; i < u[axis].nx(); ++i)
            u[axis](i, j, k) = c.flow(liquid::face_m(shape, axis, i, j, k), (step + 0.5) * step_s)[axis];
    liquid::advect_level_set(shape, u, step_s, 5.0 * h, phi);
    liquid::advect_particles(shape, u, everywhere, step_s, particles);
    liquid::correct_by_carried(shape, particles, {}, phi);
    particles.sort(shape);
    liquid::correct_by_particles(shape, particles, open, {}, phi);
    liquid::redistance(shape, 3.0 * h, 8.0 * h, phi);
    if (shifts) liquid::shift_to_volume(shape, open, c.exact * h * shape.ny, 0.25 * h, phi);
    liquid::update_carried(shape, phi, {u, step_s}, {}, particles);
  }
  const double per = shape.ny == 1 ? 1.0 / h : 1.0;  // a plane shape: area
  double different = 0.0;
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i)
        different += std::abs(liquid::plane_fraction(phi(i, j, k) / h, liquid::slope_at(phi, h, i, j, k)) -
                              liquid::plane_fraction(first(i, j, k) / h, liquid::slope_at(first, h, i, j, k)));
  return {per * liquid::liquid_volume_m3(shape, phi, open), per * different * h * h * h / c.exact};
}

/// The volume is that of a surface that is never shifted: with the shift it could not but be right. The shape is the solver's.
Level level_of(const Case& c, Monitor& monitor) {
  const Stopwatch watch;
  Level level;
  level.h_m = c.shape.cell_m;
  level.n = c.shape.nx;
  level.n_unknowns = static_cast<double>(c.shape.n_cells());
  level.value = carry(c, false, monitor).volume;
  level.exact = c.exact;
  level.error = std::abs(*level.value / c.exact - 1.0);
  level.shape_error = carry(c, true, monitor).different;
  level.wall_time_s = watch.seconds();
  return level;
}

}  // namespace

/// Shapes that a given flow carries about and brings back.
Study liquid_advection_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Shapes that a flow carries about and brings back";
  study.question =
      "How much volume is left after a turn of Zalesak's slotted disc and after Enright's sphere was drawn out to a "
      "film "
      "and back, with the solver's level set and particles, where the surface is never shifted to keep the volume? And "
      "how much of the shape differs where it is, as in the solver?";
  struct Plan {
    const char *id, *title, *reference, *words;
    Case (*make)(int n);
    double tolerance;
    double shape_tolerance;
  };
  const Plan plans[] = {{"zalesak", "Zalesak's slotted disc, one turn", "area in closed form",
                         "relative error of the area, surface never shifted", zalesak, 0.003, 0.01},
                        {"enright", "Enright's sphere, period 3", "volume of the sphere",
                         "relative error of the volume, surface never shifted", enright, 0.01, 0.01}};
  for (const Plan& plan : plans) {
    if (!wanted(options, plan.id)) continue;
    Series series;
    series.id = plan.id;
    series.title = plan.title;
    series.reference = plan.reference;
    series.step_words = "cell [m]";
    series.error_words = plan.words;
    series.expected_order = std::nan("");
    constexpr std::array<int, 3> kCells{25, 50, 100};
    const std::size_t n = level_count(options, kCells.size());
    series.error_tolerance = plan.tolerance * std::pow(1.0 * kCells.back() / kCells[n - 1], 2.0);
    for (std::size_t i = 0; i < n; ++i) {
      monitor.progress(plan.id, static_cast<double>(i) / static_cast<double>(n));
      series.levels.push_back(level_of(plan.make(kCells[i]), monitor));
    }
    if (n == kCells.size())  // the claim is about the finest
      study.claims.push_back(judged({series.id + ".shape",
                                     "share of the shape that differs in the end, finest cells",
                                     series.levels.back().shape_error.value_or(1.0),
                                     {},
                                     plan.shape_tolerance,
                                     {},
                                     false}));
    study.series.push_back(std::move(series));
  }
  return study;
}

}  // namespace klang::validate
