#include <cmath>
#include <functional>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/dual_domain/reciprocal.hpp"
#include "validate/studies/closed_tank.hpp"
#include "validate/studies/dimpled_tank.hpp"
#include "validate/studies/registry.hpp"
#include "validate/studies/two_medium.hpp"

namespace klang::validate {
namespace {

using bubble::LiquidBoundary;
using Complex = std::complex<double>;
using Eigen::Vector3d;

constexpr double kUnitRadius_m = 0.001;
constexpr int kMostVertices = 20000;  // the boundary's own triangles are the air's elements

/// A series: a boundary for each element size, a bubble in it, listeners, and the exact pressure there.
struct Problem {
  Series series;
  double frequency_hz;
  Vector3d bubble_m;
  int n_sources;  ///< whose space the liquid's functions span
  std::vector<Vector3d> listeners;
  std::vector<double> sizes_m;
  std::function<LiquidBoundary(double h_m)> boundary;
  std::function<std::vector<Complex>()> exact;  ///< of a unit source
};

Series asked(const char* id, const char* title, const char* reference, double order, double tolerance) {
  Series series;
  series.id = id;
  series.title = title;
  series.reference = reference;
  series.step_words = "element size [m]";
  series.error_words = "relative error of the pressure, rms over listeners";
  series.expected_order = order;
  series.order_tolerance = 0.4;
  series.higher_is_fine = true;
  series.error_tolerance = tolerance;
  return series;
}

mesh::SurfaceMesh ball_surface(double radius_m, double h_m) {
  return acoustics::geodesic_sphere(radius_m, static_cast<int>(std::lround(1.05 * radius_m / h_m)));
}

Problem ball() {
  Problem p{asked("ball", "Ball of liquid, bubble off its centre", "one-way series in spherical harmonics (15 digits)",
                  2.0, 1e-3),
            1500.0,
            {0.0, 0.0, 0.02},
            20,
            {{0.3, 0.2, 0.4}, {0.0, 0.0, -0.6}, {0.5, 0.0, 0.0}, {-0.2, 0.3, 0.1}},
            {},
            {},
            {}};
  constexpr double kRadius_m = 0.05;
  for (const int n : {4, 6, 8, 12}) p.sizes_m.push_back(1.05 * kRadius_m / n);
  p.boundary = [](double h_m) {
    bubble::BoundaryMesh mesh;
    mesh.name = "ball";
    mesh.surface = ball_surface(kRadius_m, h_m);
    mesh.region.assign(static_cast<std::size_t>(mesh.surface.triangles.rows()), 0);
    return LiquidBoundary(mesh);
  };
  p.exact = [points = p.listeners, frequency = p.frequency_hz, source = p.bubble_m.z()] {
    LiquidBall exact;
    exact.radius_m = kRadius_m;
    exact.frequency_hz = frequency;
    exact.source_m = source;
    std::vector<Complex> values;
    for (const Vector3d& x : points) values.push_back(ball_pressure(exact, Coupling::kOneWay, x));
    return values;
  };
  return p;
}

Problem closed_tank(Monitor& monitor) {
  Problem p{
      asked("closed-tank", "Closed tank 30 x 20 x 15 cm, free top, rigid walls",
            "the liquid's slope as the sum over images (by horizontal modes, round-off); the air by boundary elements "
            "driven by it, extrapolated from two finer meshes (0.2 %)",
            std::numeric_limits<double>::quiet_NaN(), 0.02),
      1000.0,
      {0.13, 0.09, -0.03},
      60,
      {{0.5, 0.2, 0.3}, {-0.3, 0.4, 0.1}, {0.15, 0.1, 0.5}, {0.6, -0.2, -0.3}},
      {0.05, 0.025, 0.05 / 3.0, 0.0125},
      [](double h_m) { return LiquidBoundary(detail::ClosedTank().mesh(h_m)); },
      {}};
  p.exact = [points = p.listeners, frequency = p.frequency_hz, at = p.bubble_m, &monitor] {
    constexpr double kCoarse_m = 0.0125, kFine_m = 0.01;
    const std::vector<Complex> coarse = detail::forward_from_images({}, kCoarse_m, frequency, at, points, monitor),
                               fine = detail::forward_from_images({}, kFine_m, frequency, at, points, monitor);
    std::vector<Complex> values;
    const double share = kFine_m * kFine_m / (kCoarse_m * kCoarse_m - kFine_m * kFine_m);
    for (std::size_t i = 0; i < points.size(); ++i) values.push_back(fine[i] + share * (fine[i] - coarse[i]));
    return values;
  };
  return p;
}

Problem dimpled_tank(Monitor& monitor) {
  Problem p{asked("dimpled-tank", "Tank 14 x 14 x 8 cm with a crater of 6 mm",
                  "pass 1 with the waves of 60 sources and boundary elements in the air, 7 mm (1 to 2 %)",
                  std::numeric_limits<double>::quiet_NaN(), 0.03),
            2000.0,
            {0.012, -0.008, -0.030},
            60,
            {},
            {0.028, 0.02, 0.014, 0.01},
            [](double h_m) { return LiquidBoundary(detail::DimpledTank().mesh(h_m)); },
            {}};
  for (int i = 0; i < 8; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / 8.0, phi = 2.4 * i, r = std::sqrt(1.0 - z * z);
    p.listeners.emplace_back(0.5 * r * std::cos(phi), 0.5 * r * std::sin(phi), 0.5 * z - 0.04);
  }
  p.exact = [points = p.listeners, frequency = p.frequency_hz, at = p.bubble_m, &monitor] {
    const LiquidBoundary fine(detail::DimpledTank().mesh(0.007));
    const TwoWayResult one_way = two_way_pressure(fine, frequency, at, points, {60, {}, 1e-9, 1}, monitor);
    std::vector<Complex> values;
    for (const Complex& value : one_way.one_way_pressure) values.push_back(value / one_way.liquid.source_strength);
    return values;
  };
  return p;
}

Series run_problem(Problem problem, const StudyOptions& options, Monitor& monitor) {
  const std::vector<Complex> exact = problem.exact();
  Series& series = problem.series;
  const std::size_t n_levels = level_count(options, problem.sizes_m.size());
  if (std::isfinite(series.expected_order))
    series.error_tolerance *= std::pow(problem.sizes_m[n_levels - 1] / problem.sizes_m.back(), series.expected_order);
  for (std::size_t i = 0; i < n_levels; ++i) {
    monitor.throw_if_stopped();
    const Stopwatch lap;
    const LiquidBoundary boundary = problem.boundary(problem.sizes_m[i]);
    bubble::ReciprocalOptions solve;
    solve.air_vertices = kMostVertices;
    solve.estimate_air = false;
    const std::vector<bubble::ReciprocalTransfer> found = bubble::reciprocal_transfer(
        boundary, problem.frequency_hz, bubble::random_source_points(boundary, problem.n_sources, 1, 1),
        {{{problem.bubble_m, kUnitRadius_m}}, problem.listeners}, solve, monitor)[0];
    const double strength = bubble::bubble_source_strength(kUnitRadius_m, problem.frequency_hz, 1000.0);
    double error = 0.0, size = 0.0;
    for (std::size_t e = 0; e < exact.size(); ++e) {
      error += std::norm(found[e].plain / strength - exact[e]);
      size += std::norm(exact[e]);
    }
    Level level;
    level.h_m = problem.sizes_m[i];
    level.error = std::sqrt(error / size);
    level.value = std::abs(found[0].plain / strength);
    level.exact = std::abs(exact[0]);
    level.n_unknowns = static_cast<double>(boundary.surface().vertices_m.rows());
    level.wall_time_s = lap.seconds();
    series.levels.push_back(level);
  }
  series.exact_value = std::abs(exact[0]);
  judge(series);
  return series;
}

}  // namespace

Study reciprocal_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.name = "reciprocal";
  study.title = "Transfer of a bubble from the ear to the liquid";
  study.question =
      "How far is the pressure that a bubble makes at a listener, found by sending the ear's field into the liquid, "
      "from exact "
      "solutions? value and exact of a level: |P| at the first listener, of a unit source.";
  monitor.throw_if_stopped();
  if (wanted(options, "ball")) study.series.push_back(run_problem(ball(), options, monitor));
  if (wanted(options, "closed-tank")) study.series.push_back(run_problem(closed_tank(monitor), options, monitor));
  if (wanted(options, "dimpled-tank")) study.series.push_back(run_problem(dimpled_tank(monitor), options, monitor));
  study.status = StudyStatus::kDone;
  return study;
}

}  // namespace klang::validate
