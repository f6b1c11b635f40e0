#include <cmath>
#include <cstdio>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"
#include "validate/studies/detail/pressure_slice.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using acoustics::SphereCase;
using acoustics::SphereResult;

constexpr double kRadius_m = 0.1;
constexpr int kSlicePixels = 512;

struct Case {
  const char* id;
  const char* title;
  int degree;
  double ka;
  double error_tolerance;  ///< at the finest of the default levels
};
// pi and 4.4934 are zeros of j_0 and j_1: there the plain surface equation has no unique solution.
const std::vector<Case> kCases = {{"quadrupole-ka5", "Quadrupole, ka = 5", 2, 5.0, 1e-2},
                                  {"pulsating-ka1", "Pulsating sphere, ka = 1", 0, 1.0, 1e-2},
                                  {"pulsating-kapi", "Pulsating sphere, ka = π", 0, kPi, 1e-2},
                                  {"dipole-ka4.4934", "Dipole, ka = 4.4934", 1, 4.493409457909064, 1e-2},
                                  {"octupole-ka1", "Octupole, ka = 1", 3, 1.0, 1e-2}};

SphereResult solved(const SphereCase& sphere, std::shared_ptr<const acoustics::HelmholtzBem>& solver,
                    Monitor& monitor) {
  acoustics::BemOptions options;
  options.allow_coarse = true;
  options.n_blas_threads = 1;  // the same bits on any number of threads
  SphereResult result = solver ? acoustics::solve_sphere(sphere, solver, options, monitor)
                               : acoustics::solve_sphere(sphere, options, monitor);
  if (!result.bem.usable()) throw NumericalError("converge bem: " + result.bem.message);
  solver = result.solver;
  return result;
}

/// At an interior resonance the error must be no larger than beside it.
struct Resonance {
  const char *name, *words;
  int degree;
  double ka;
};
Claim resonance_claim(const Resonance& at, int divisions, std::shared_ptr<const acoustics::HelmholtzBem>& solver,
                      Monitor& monitor) {
  const auto error = [&](double ka) {
    return solved({at.degree, kRadius_m, ka, divisions}, solver, monitor).surface_pressure_relative_error;
  };
  const double beside = 0.5 * (error(0.94 * at.ka) + error(1.06 * at.ka));
  return judged({at.name, at.words, error(at.ka) / beside, 1.0, 0.25, {}, false});
}

/// |p| and its error around the sphere from the solution's multipoles; the error map on the surface; the balloon.
void add_fields(const SphereCase& sphere, const SphereResult& result, const std::string& words, Fields& fields) {
  const acoustics::Multipole& multipole = result.multipole;
  const auto factory = [&](bool difference) {
    return [&, difference]() -> detail::PointValue {
      auto basis = std::make_shared<acoustics::HelmholtzBasis>(multipole.order);
      auto values = std::make_shared<Eigen::VectorXcd>();
      return [&, difference, basis, values](const Eigen::Vector3d& x) {
        if (x.norm() < kRadius_m) return std::nan("");
        basis->values(acoustics::Wave::kSingular, multipole.wavenumber_per_m, x - multipole.centre_m, *values);
        const std::complex<double> p = (values->array() * multipole.coefficients_pa.array()).sum();
        const std::complex<double> exact = difference ? acoustics::sphere_pressure_pa(sphere, {}, x) : 0.0;
        return std::abs(p - exact);
      };
    };
  };
  SliceField pressure = detail::pressure_slice(3.0 * kRadius_m, kSlicePixels, factory(false));
  pressure.name = "pressure";
  pressure.title = "|p| around the sphere";
  pressure.caption = words + ": sound pressure in the plane y = 0, in dB re the loudest point; the body is grey.";
  pressure.decibels = true;
  fields.slices.push_back(std::move(pressure));
  SliceField error = detail::pressure_slice(3.0 * kRadius_m, kSlicePixels, factory(true));
  error.name = "pressure-error";
  error.title = "Error of p around the sphere";
  error.caption = words + ": |p − exact| in pascal at unit velocity, same plane.";
  error.quantity = "pressure_error_pa";
  fields.slices.push_back(std::move(error));

  const acoustics::RadiatingSurface& surface = result.solver->surface();
  SurfaceField map;
  map.name = "surface-error";
  map.title = "Error of p on the surface";
  map.caption = words + ": |p − exact| at the vertices over the largest exact |p|; " +
                std::to_string(surface.n_triangles()) + " elements.";
  map.quantity = "relative_error";
  map.vertices_m = surface.vertices_m.transpose();
  map.triangles = surface.triangles.transpose();
  map.values.resize(surface.n_vertices());
  double largest = 0.0;
  for (int i = 0; i < surface.n_vertices(); ++i) {
    // The polyhedron's vertices lie a little outside the ball: the exact value is that of the surface below them.
    const Eigen::Vector3d x = kRadius_m * surface.vertices_m.col(i).normalized();
    const std::complex<double> exact = acoustics::sphere_pressure_pa(sphere, {}, x * (1.0 + 1e-12));
    map.values[i] = std::abs(result.bem.pressure_pa(i, 0) - exact);
    largest = std::max(largest, std::abs(exact));
  }
  map.values /= largest;
  fields.surfaces.push_back(std::move(map));

  BalloonField balloon =
      detail::balloon([&](const Eigen::Vector3d& s) { return std::abs(acoustics::far_field_pa_m(multipole, s)); });
  balloon.name = "directivity";
  balloon.title = "Directivity";
  balloon.caption =
      words + ": far field, level re the loudest direction; 30 dB from the surface of the unit ball to its centre.";
  fields.balloons.push_back(std::move(balloon));
}

}  // namespace

/// Surface pressure of the boundary elements on spheres against the exact series, interior resonances included.
Study bem_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Pressure of the boundary elements";
  study.question =
      "Does the surface pressure of vibrating spheres converge with the square of the element size, also at the "
      "frequencies "
      "where the sphere resonates inside (ka = π, 4.4934)? The error is the root mean square over the surface against "
      "the "
      "exact series.";
  const std::vector<int> divisions = {4, 6, 8, 10};
  const std::size_t n_levels = level_count(options, divisions.size());
  std::vector<Case> cases;
  for (const Case& c : kCases) {
    if (!wanted(options, c.id)) continue;
    cases.push_back(c);
    Series series;
    series.id = c.id;
    series.title = c.title;
    series.reference = "closed form with spherical Hankel functions";
    series.step_words = "element size [m]";
    series.error_words = "root-mean-square error of the surface pressure, relative";
    series.expected_order = 2.0;
    series.order_tolerance = 0.3;
    series.higher_is_fine = true;
    series.error_tolerance =
        c.error_tolerance * std::pow(static_cast<double>(divisions.back()) / divisions[n_levels - 1], 2.0);
    study.series.push_back(std::move(series));
  }
  if (cases.empty()) return study;
  double n_done = 0.0, n_all = 0.0;
  const auto work = [](int n) { return std::pow(n, 4.0); };
  for (std::size_t i = 0; i < n_levels; ++i) n_all += work(divisions[i]) * static_cast<double>(cases.size());
  for (std::size_t i = 0; i < n_levels; ++i) {
    std::shared_ptr<const acoustics::HelmholtzBem> solver;
    for (std::size_t k = 0; k < cases.size(); ++k) {
      monitor.throw_if_stopped();
      monitor.progress("boundary elements", n_done / n_all);
      const Stopwatch watch;
      const SphereCase sphere{cases[k].degree, kRadius_m, cases[k].ka, divisions[i]};
      const SphereResult result = solved(sphere, solver, silent_monitor());
      Level level;
      level.h_m = result.element_size_m;
      level.error = result.surface_pressure_relative_error;
      level.value = result.bem.radiated_power_w[0];
      level.n_unknowns = result.bem.n_unknowns;
      level.wall_time_s = watch.seconds();
      study.series[k].levels.push_back(level);
      n_done += work(divisions[i]);
      if (options.fields && k == 0 && i + 1 == n_levels) add_fields(sphere, result, cases[k].title, study.fields);
    }
    if (i == 1 && options.only.empty()) {
      study.claims.push_back(
          resonance_claim({"resonance-pi", "Error at ka = π over its mean 6 % beside (pulsating)", 0, kPi},
                          divisions[i], solver, silent_monitor()));
      study.claims.push_back(resonance_claim(
          {"resonance-4.4934", "Error at ka = 4.4934 over its mean 6 % beside (dipole)", 1, 4.493409457909064},
          divisions[i], solver, silent_monitor()));
    }
  }
  return study;
}

}  // namespace klang::validate
