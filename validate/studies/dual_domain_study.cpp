#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"
#include "validate/studies/detail/pressure_slice.hpp"
#include "validate/studies/dimpled_tank.hpp"
#include "validate/studies/registry.hpp"
#include "validate/studies/two_medium.hpp"

namespace klang::validate {
namespace {

using bubble::DualDomainOptions;
using bubble::DualDomainResult;
using bubble::LiquidBoundary;
using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;

// Samples must outnumber the waves several times: 3400 of them for 529 waves, 6900 for the reference's 900.
constexpr double kSpacing_m = 0.005, kFineSpacing_m = 0.0035, kElement_m = 0.007;
constexpr int kReferenceSources = 100, kElementSources = 40;
constexpr double kFrequencyHz = 2000.0, kBubbleRadius_m = 0.00165;
const Vector3d kBubble_m(0.012, -0.008, -0.030);  // below the dimple, off its axis
constexpr int kRepeats = 6;
constexpr int kEnoughSources = 60;  // of pass 1 where pass 2 is looked at
const double kNoOrder = std::numeric_limits<double>::quiet_NaN();

std::vector<DualDomainResult> solved(const LiquidBoundary& boundary, double frequency_hz, int n_fluid, int n_air,
                                     std::uint64_t seed, const DualDomainOptions& options) {
  std::vector<DualDomainResult> result =
      bubble::solve_dual_domain(boundary, frequency_hz, bubble::random_source_points(boundary, n_fluid, n_air, seed),
                                {{kBubble_m, kBubbleRadius_m}}, options);
  if (!result[0].usable()) throw NumericalError("converge dual-domain: " + result[0].message);
  return result;
}

/// L2 error of dP/dn over the free surface, relative.
double slope_error(const LiquidBoundary& boundary, const DualDomainResult& result, const Eigen::VectorXcd& reference) {
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
    const bubble::BoundarySample& s = boundary.samples()[i];
    if (s.region != bubble::BoundaryRegion::kFreeSurface) continue;
    const auto k = static_cast<Index>(i);
    error += s.area_m2 * std::norm(result.normal_derivative[k] / result.source_strength - reference[k]);
    size += s.area_m2 * std::norm(reference[k]);
  }
  return std::sqrt(error / size);
}

/// rms over the listeners, relative.
double pressure_error(const DualDomainResult& result, const std::vector<Vector3d>& points,
                      const std::vector<Complex>& reference) {
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    error += std::norm(bubble::air_pressure(result, points[i]) / result.source_strength - reference[i]);
    size += std::norm(reference[i]);
  }
  return std::sqrt(error / size);
}

/// Mean over repeats with its 95 % interval (Student's t of 5 degrees of freedom).
Level mean_level(const std::vector<double>& errors, double n_sources, double seconds) {
  static_assert(kRepeats == 6, "Student's t below is for 6 repeats");
  constexpr double kStudent = 2.571;
  Level level;
  double mean = 0.0, square = 0.0;
  for (const double e : errors) mean += e / static_cast<double>(errors.size());
  for (const double e : errors) square += (e - mean) * (e - mean) / static_cast<double>(errors.size() - 1);
  const double half = kStudent * std::sqrt(square / static_cast<double>(errors.size()));
  level.error = mean;
  level.error_ci95 = {std::max(0.0, mean - half), mean + half};
  level.n = n_sources;
  level.n_unknowns = 9.0 * n_sources;
  level.wall_time_s = seconds;
  return level;
}

struct SeriesWords {
  const char *id, *title, *reference, *step, *error;
};
Series new_series(const SeriesWords& words, double tolerance, bool counts) {
  Series series;
  series.id = words.id;
  series.title = words.title;
  series.reference = words.reference;
  series.step_words = words.step;
  series.error_words = words.error;
  series.expected_order = kNoOrder;
  series.error_tolerance = tolerance;
  series.counts = counts;
  return series;
}

/// What is needed once.
struct Scene {
  detail::DimpledTank tank;
  std::unique_ptr<LiquidBoundary> boundary;
  Eigen::VectorXcd slope;                 ///< dP/dn of a unit source, reference
  std::vector<Vector3d> points;           ///< listeners
  std::vector<Complex> one_way, two_way;  ///< of a unit source, boundary elements
  std::vector<double> change;
};

std::vector<Vector3d> listeners() {
  std::vector<Vector3d> points;  // a spiral over a sphere around the tank
  constexpr int kCount = 24;
  for (int i = 0; i < kCount; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kCount, phi = 2.399963229728653 * i, r = std::sqrt(1.0 - z * z);
    points.emplace_back(0.5 * r * std::cos(phi), 0.5 * r * std::sin(phi), 0.5 * z - 0.04);
  }
  return points;
}

Scene make_scene(bool with_elements, Monitor& monitor) {
  Scene scene;
  scene.boundary = std::make_unique<LiquidBoundary>(scene.tank.mesh(kSpacing_m));
  const LiquidBoundary fine(scene.tank.mesh(kFineSpacing_m));
  const DualDomainResult reference = solved(fine, kFrequencyHz, kReferenceSources, 1, 1, {})[0];
  scene.slope.setZero(static_cast<Index>(scene.boundary->samples().size()));
  parallel_for(scene.boundary->samples().size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const bubble::BoundarySample& s = scene.boundary->samples()[i];
      scene.slope[static_cast<Index>(i)] =
          bubble::liquid_pressure_slope(reference, s.point_m, s.normal) / reference.source_strength;
    }
  });
  if (!with_elements) return scene;
  scene.points = listeners();
  const LiquidBoundary elements(scene.tank.mesh(kElement_m));
  const TwoWayResult both =
      two_way_pressure(elements, kFrequencyHz, kBubble_m, scene.points, {kElementSources, {}, 1e-9, 4}, monitor);
  scene.change = both.change;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    scene.one_way.push_back(both.one_way_pressure[i] / both.liquid.source_strength);
    scene.two_way.push_back(both.pressure[i] / both.liquid.source_strength);
  }
  return scene;
}

double relative(const std::vector<Complex>& a, const std::vector<Complex>& b) {
  double error = 0.0, size = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    error += std::norm(a[i] - b[i]);
    size += std::norm(b[i]);
  }
  return std::sqrt(error / size);
}

/// |v_n| on the surface with few and with many sources (HF Figure 9), |p| in a plane (HF Figure 10), and the errors.
void add_fields(const Scene& scene, const LiquidBoundary& fine, Fields& fields) {
  const auto surface_map = [&](const DualDomainResult& result, const std::string& name, const std::string& title,
                               const std::string& caption) {
    SurfaceField map;
    map.name = name;
    map.title = title;
    map.caption = caption;
    map.quantity = "normal_velocity_relative";
    map.vertices_m = fine.surface().vertices_m;
    map.triangles = fine.surface().triangles;
    map.values = Eigen::VectorXd::Zero(map.vertices_m.rows());
    for (std::size_t i = 0; i < fine.samples().size(); ++i)
      if (fine.samples()[i].region == bubble::BoundaryRegion::kFreeSurface)
        map.values[fine.samples()[i].vertex] = std::abs(result.normal_derivative[static_cast<Index>(i)]);
    map.values /= map.values.maxCoeff();
    fields.surfaces.push_back(std::move(map));
  };
  DualDomainOptions no_images;
  no_images.images = false;
  for (const int n : {5, 10, 20, 60}) {
    const DualDomainResult result = solved(fine, kFrequencyHz, n, 10, 1, no_images)[0];
    surface_map(
        result, "velocity-" + std::to_string(n), "|v_n| with " + std::to_string(n) + " quadrupoles",
        "Normal velocity of the liquid's surface (largest: 1) by pass 1 with " + std::to_string(n) +
            " quadrupoles’ worth of regular waves, without images of the bubble; walls stand still. HF Figure 9.");
  }
  const auto slice = [&](const DualDomainResult& result, const std::string& name, const std::string& title,
                         const std::string& caption) {
    SliceField field = detail::pressure_slice(0.25, 384, [&]() -> detail::PointValue {
      return [&](const Vector3d& x) {
        return scene.tank.inside(x) ? std::nan("") : std::abs(bubble::air_pressure(result, x));
      };
    });
    field.name = name;
    field.title = title;
    field.caption = caption;
    field.decibels = true;
    fields.slices.push_back(std::move(field));
  };
  for (const int n : {40, 60, 80})
    slice(solved(*scene.boundary, kFrequencyHz, kEnoughSources, n, 1, {})[0], "pressure-" + std::to_string(n),
          "|p| with " + std::to_string(n) + " quadrupoles",
          "Sound pressure at " + std::to_string(static_cast<int>(kFrequencyHz)) +
              " Hz in the plane y = 0 by pass 2 with " + std::to_string(n) +
              " quadrupoles, in dB re the loudest point; the liquid is grey. HF Figure 10.");
}

constexpr const char* kFluidStep = "quadrupole sources in the liquid";
constexpr const char* kAirStep = "quadrupole sources in the air";
constexpr const char* kSlopeError = "L2 error of ∂P/∂n on the free surface, relative";
constexpr const char* kResidual = "‖Ac − b‖ / ‖b‖";
constexpr const char* kNoReference = "none: the residual itself";
const std::vector<int> kFluidCounts = {2, 5, 10, 20, 40, 60};
constexpr double kProgressSteps = 40.0;  // about as many levels as there are

/// Runs series of levels over numbers of sources into a study.
class SeriesRunner {
 public:
  SeriesRunner(Study& study, const StudyOptions& options, Monitor& monitor)
      : study_(study), options_(options), monitor_(monitor) {}

  /// @param repeated  the mean over kRepeats sets of sources
  void run(Series series, const std::vector<int>& counts, bool repeated,
           const std::function<double(int n, std::uint64_t seed)>& error) {
    if (!wanted(options_, series.id)) return;
    const std::size_t n_levels = level_count(options_, counts.size());
    for (std::size_t i = 0; i < n_levels; ++i) {
      monitor_.throw_if_stopped();
      monitor_.progress("dual domain", std::min(1.0, n_done_++ / kProgressSteps));
      const Stopwatch watch;
      std::vector<double> errors(repeated ? kRepeats : 1);
      for (std::size_t k = 0; k < errors.size(); ++k) errors[k] = error(counts[i], k + 1);
      const double seconds = watch.seconds() / static_cast<double>(errors.size());
      Level level;
      if (repeated) {
        level = mean_level(errors, counts[i], seconds);
      } else {
        level.error = errors[0];
        level.n = counts[i];
        level.n_unknowns = std::pow(std::floor(3.0 * std::sqrt(counts[i]) + 1e-9), 2.0);
        level.wall_time_s = seconds;
      }
      series.levels.push_back(level);
    }
    if (n_levels < counts.size()) series.error_tolerance = 1.0;  // stated for the finest level
    study_.series.push_back(std::move(series));
  }

 private:
  Study& study_;
  const StudyOptions& options_;
  Monitor& monitor_;
  double n_done_ = 0.0;
};

void run_pass_1(SeriesRunner& runner, const Scene& scene) {
  const LiquidBoundary& boundary = *scene.boundary;
  DualDomainOptions no_images, printed = DualDomainOptions::as_printed();
  no_images.images = false;
  printed.literature =
      bubble::Literature::kCorrected;  // signs and densities do not matter here, the wall's weight keeps its length
  runner.run(
      new_series({"fluid", "Pass 1, flat limit and images",
                  "100 sources (900 waves) on a finer surface (itself within about 3 %)", kFluidStep, kSlopeError},
                 0.06, true),
      kFluidCounts, false, [&](int n, std::uint64_t seed) {
        return slope_error(boundary, solved(boundary, kFrequencyHz, n, 1, seed, {})[0], scene.slope);
      });
  runner.run(
      new_series({"fluid-no-images", "Pass 1, flat limit",
                  "100 sources (900 waves) on a finer surface (itself within about 3 %)", kFluidStep, kSlopeError},
                 0.15, true),
      kFluidCounts, false, [&](int n, std::uint64_t seed) {
        return slope_error(boundary, solved(boundary, kFrequencyHz, n, 1, seed, no_images)[0], scene.slope);
      });
  runner.run(
      new_series({"fluid-printed", "Pass 1 as printed (sources, ridge 1e-8)",
                  "100 sources (900 waves) on a finer surface (itself within about 3 %)", kFluidStep, kSlopeError},
                 1.0, false),
      kFluidCounts, true, [&](int n, std::uint64_t seed) {
        return slope_error(boundary, solved(boundary, kFrequencyHz, n, 1, seed, printed)[0], scene.slope);
      });
  runner.run(
      new_series({"fluid-residual", "Pass 1 as printed, residual", kNoReference, kFluidStep, kResidual}, 1.0, false),
      kFluidCounts, true, [&](int n, std::uint64_t seed) {
        return solved(boundary, kFrequencyHz, n, 1, seed, printed)[0].fit_error_fluid;
      });
}

/// A crater as deep as it is wide: what no wave about one centre follows.
void run_steep_crater(SeriesRunner& runner) {
  detail::DimpledTank steep;
  steep.dimple_m = 0.015;
  steep.width_m = 0.02;
  const LiquidBoundary crater(steep.mesh(kSpacing_m));
  runner.run(
      new_series({"fluid-steep-residual", "Pass 1 in a steep crater, residual", kNoReference, kFluidStep, kResidual},
                 1.0, false),
      kFluidCounts, false,
      [&](int n, std::uint64_t seed) { return solved(crater, kFrequencyHz, n, 1, seed, {})[0].fit_error_fluid; });
}

/// Pass 2, behind a converged pass 1. What stays sits at the rim, where the surface's motion ends at an edge: no field of
/// sources inside follows that (docs/dual-domain.md).
void run_pass_2(SeriesRunner& runner, const Scene& scene) {
  const LiquidBoundary& boundary = *scene.boundary;
  const std::vector<int> air_counts = {5, 10, 20, 40, 80, 120};
  runner.run(new_series({"air-residual", "Pass 2, residual", kNoReference, kAirStep, kResidual}, 1.0, false),
             air_counts, true, [&](int n, std::uint64_t seed) {
               return solved(boundary, kFrequencyHz, kEnoughSources, n, seed, {})[0].fit_error_air;
             });
  runner.run(new_series({"air-pressure", "Pass 2, pressure at listeners",
                         "boundary elements driven by the same surface velocity (0.2 %)", kAirStep,
                         "rms error of the pressure at 24 listeners 0.5 m away, relative"},
                        0.18, true),
             air_counts, true, [&](int n, std::uint64_t seed) {
               return pressure_error(solved(boundary, kFrequencyHz, kEnoughSources, n, seed, {})[0], scene.points,
                                     scene.one_way);
             });
}

/// What the coupling leaves out: a ball, exactly.
void add_ball(Study& study, const StudyOptions& options, const Scene& scene) {
  Series ball =
      new_series({"one-way-ball", "One-way coupling of a ball, bubble off the centre", "two-way series (1e-12)",
                  "frequency [Hz]", "rms error of the pressure around the ball, relative"},
                 1.0, false);
  if (!wanted(options, ball.id)) return;
  for (const double frequency_hz : {200.0, 500.0, 1000.0, 2000.0, 4000.0, 6000.0, 10000.0, 14000.0}) {
    const LiquidBall liquid{0.05, frequency_hz, 0.025, {1000.0, 1497.0}, {}};
    std::vector<Complex> one, two;
    for (const Vector3d& x : scene.points.empty() ? listeners() : scene.points) {
      one.push_back(ball_pressure(liquid, Coupling::kOneWay, x));
      two.push_back(ball_pressure(liquid, Coupling::kTwoWay, x));
    }
    Level level;
    level.n = frequency_hz;
    level.error = relative(one, two);
    ball.levels.push_back(level);
  }
  study.series.push_back(std::move(ball));
}

/// The one-way coupling against the exact ball and against boundary elements in turns.
void add_coupling_claims(Study& study, const Scene& scene) {
  const LiquidBoundary& boundary = *scene.boundary;
  // tests/reference/fluid.json: concentric_two_way_exact, rel_err of the one-way solution.
  for (const auto& [frequency_hz, error] :
       {std::pair{500.0, 4.020804984196476e-06}, {1500.0, 2.3561525127135014e-05}, {4000.0, 7.822396845048716e-05}}) {
    const LiquidBall liquid{0.05, frequency_hz, 0.0, {1000.0, 1497.0}, {}};
    const Complex two = ball_pressure(liquid, Coupling::kTwoWay, {0.5, 0, 0});
    char name[64], words[96];
    std::snprintf(name, sizeof name, "one-way-concentric-%g", frequency_hz);
    std::snprintf(words, sizeof words, "Concentric ball, %g Hz: error of the one-way coupling", frequency_hz);
    study.claims.push_back(
        judged({name,
                words,
                std::abs(ball_pressure(liquid, Coupling::kOneWay, {0.5, 0, 0}) - two) / std::abs(two),
                error,
                1e-5 * error,
                {},
                false}));
  }
  study.claims.push_back(judged({"one-way-dimple",
                                 "Dimpled tank, 2 kHz: error of the one-way coupling (boundary elements in turns)",
                                 relative(scene.one_way, scene.two_way),
                                 {},
                                 0.005,
                                 {},
                                 false}));
  study.claims.push_back(judged({"two-way-turns",
                                 "Dimpled tank: change of the two-way pressure in its last turn",
                                 scene.change.back(),
                                 {},
                                 1e-6,
                                 {},
                                 false}));
  const DualDomainResult whole = solved(boundary, kFrequencyHz, 60, 100, 1, {})[0];
  study.claims.push_back(judged({"whole-chain-dimple",
                                 "Dimpled tank, 60 and 100 sources: error of the pressure against the two-way solution",
                                 pressure_error(whole, scene.points, scene.two_way),
                                 {},
                                 0.18,
                                 {},
                                 false}));
}

/// HF Table 1, row Droplet: residuals 0.06 and 0.18, averages over its solves with 30 to 60 and 80 to 120 sources from 500 Hz to
/// 4 kHz. HF leaves walls and floor of that scene out: the whole surface is free here too.
void add_table_1_claims(Study& study, const Scene& scene) {
  bubble::BoundaryMesh free = scene.tank.mesh(kSpacing_m);
  free.region.assign(free.region.size(), 0);
  const LiquidBoundary body(free);
  double fluid = 0.0, air = 0.0;
  struct Row {
    double frequency_hz;
    int n_fluid, n_air;
  };
  constexpr Row kRows[] = {{500.0, 30, 80}, {2000.0, 43, 97}, {4000.0, 60, 120}};
  for (const Row& row : kRows)
    for (std::uint64_t seed = 1; seed <= kRepeats; ++seed) {
      const DualDomainResult result =
          solved(body, row.frequency_hz, row.n_fluid, row.n_air, seed, DualDomainOptions::as_printed())[0];
      fluid += result.fit_error_fluid / (3.0 * kRepeats);
      air += result.fit_error_air / (3.0 * kRepeats);
    }
  study.claims.push_back(
      judged({"table1-droplet-fluid",
              "Residual of pass 1 as printed with the sources of HF Table 1, Droplet (HF: mean 0.06)",
              fluid,
              0.06,
              0.1,
              {},
              false}));
  study.claims.push_back(
      judged({"table1-droplet-air",
              "Residual of pass 2 as printed with the sources of HF Table 1, Droplet (HF: mean 0.18)",
              air,
              0.18,
              0.15,
              {},
              false}));
}

}  // namespace

/// Bubbles in liquids: both passes of the dual-domain solver over their sources, and what the one-way coupling leaves out.
Study dual_domain_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Dual-domain solver: bubbles heard through a liquid’s surface";
  study.question =
      "How do the two passes of the dual-domain solver (Zheng and James 2009) converge over the number of their "
      "multipole sources, and how "
      "wrong is it that air does not act back on the liquid? One bubble below the crater that a drop leaves in a rigid "
      "tank of water, "
      "fixed geometry, random sets of sources (HF Figure 13).";
  monitor.throw_if_stopped();
  const Scene scene = make_scene(wanted(options, "air-pressure"), monitor);
  SeriesRunner runner(study, options, monitor);
  run_pass_1(runner, scene);
  run_steep_crater(runner);
  run_pass_2(runner, scene);
  add_ball(study, options, scene);
  if (options.only.empty()) {
    add_coupling_claims(study, scene);
    add_table_1_claims(study, scene);
  }
  if (options.fields) add_fields(scene, LiquidBoundary(scene.tank.mesh(kFineSpacing_m)), study.fields);
  return study;
}

}  // namespace klang::validate
