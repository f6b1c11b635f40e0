#include "validate/studies/two_medium.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/waves/spherical_bessel.hpp"

namespace klang::validate {
namespace {
using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;
}  // namespace

Complex ball_pressure(const LiquidBall& ball, Coupling coupling, const Vector3d& x_m) {
  const double a = ball.radius_m, kf = ball.liquid.wavenumber_per_m(ball.frequency_hz),
               ka = ball.air.wavenumber_per_m(ball.frequency_hz);
  const double r = x_m.norm(), cosine = x_m.z() / r;
  checked("liquid ball", "source_m", ball.source_m, 0.0, a * (1.0 - 1e-9));
  checked("liquid ball", "point's distance", r, a, 1e9);
  // Terms fall as (b/a)^n (a/r)^n; a central source has the first alone.
  const int n_terms =
      ball.source_m == 0.0 ? 1 : std::min(60, 12 + static_cast<int>(-36.0 / std::log(ball.source_m / r)));
  const auto size = static_cast<std::size_t>(n_terms) + 2;
  std::vector<double> jb(size), jf(size), jf_slope(size);
  std::vector<Complex> hf(size), hf_slope(size), ha(size), ha_slope(size), hr(size);
  acoustics::spherical_bessel_j(kf * ball.source_m, jb);
  acoustics::spherical_bessel_j(kf * a, jf);
  acoustics::spherical_derivatives<double>(kf * a, jf, jf_slope);
  acoustics::spherical_hankel2(kf * a, hf);
  acoustics::spherical_derivatives<Complex>(kf * a, hf, hf_slope);
  acoustics::spherical_hankel2(ka * a, ha);
  acoustics::spherical_derivatives<Complex>(ka * a, ha, ha_slope);
  acoustics::spherical_hankel2(ka * r, hr);
  Complex sum = 0.0;
  double p_before = 0.0, p = 1.0;
  for (int n = 0; n < n_terms; ++n) {
    const auto i = static_cast<std::size_t>(n);
    const Complex s = Complex(0.0, kf / (4.0 * kPi)) * (2.0 * n + 1.0) * jb[i];
    // Inside s h_n(kf r) + c j_n(kf r), outside d h_n(ka r); Wronskian j h' - j' h = -i / z^2.
    const Complex wronskian = Complex(0.0, -1.0) / (kf * a * kf * a);
    Complex d;
    if (coupling == Coupling::kOneWay) {
      d = s * kf * wronskian / jf[i] * (ball.air.density_kg_m3 / ball.liquid.density_kg_m3) / (ka * ha_slope[i]);
    } else {
      const Complex stiff = ka * ha_slope[i] / ball.air.density_kg_m3, soft = kf / ball.liquid.density_kg_m3;
      d = s * soft * wronskian / (stiff * jf[i] - soft * jf_slope[i] * ha[i]);
    }
    sum += d * hr[i] * p;
    const double next = ((2.0 * n + 1.0) * cosine * p - n * p_before) / (n + 1.0);
    p_before = p;
    p = next;
  }
  return sum;
}

TwoWayResult two_way_pressure(const bubble::LiquidBoundary& boundary, double frequency_hz, const Vector3d& bubble_m,
                              const std::vector<Vector3d>& points_m, const TwoWayOptions& options, Monitor& monitor) {
  TwoWayResult result;
  const mesh::SurfaceMesh& surface = boundary.surface();
  std::vector<int> vertex_of;
  acoustics::RadiatingSurface radiating = acoustics::radiating_surface(surface, &vertex_of);
  std::vector<int> element_vertex(static_cast<std::size_t>(surface.vertices_m.rows()), -1);
  for (std::size_t i = 0; i < vertex_of.size(); ++i)
    element_vertex[static_cast<std::size_t>(vertex_of[i])] = static_cast<int>(i);
  // The sample that each corner of a free triangle belongs to.
  std::vector<std::vector<std::size_t>> samples_of(static_cast<std::size_t>(surface.vertices_m.rows()));
  for (std::size_t s = 0; s < boundary.samples().size(); ++s)
    samples_of[static_cast<std::size_t>(boundary.samples()[s].vertex)].push_back(s);
  std::vector<Index> corner_sample(static_cast<std::size_t>(3 * surface.triangles.rows()), -1);
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    if (boundary.region()[static_cast<std::size_t>(t)] != 0) continue;
    Vector3d p[3];
    for (int c = 0; c < 3; ++c) p[c] = surface.vertices_m.row(surface.triangles(t, c)).transpose();
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (int c = 0; c < 3; ++c) {
      double best = -2.0;
      for (const std::size_t s : samples_of[static_cast<std::size_t>(surface.triangles(t, c))]) {
        const bubble::BoundarySample& sample = boundary.samples()[s];
        if (sample.region != bubble::BoundaryRegion::kFreeSurface || sample.normal.dot(normal) <= best) continue;
        best = sample.normal.dot(normal);
        corner_sample[static_cast<std::size_t>(3 * t + c)] = static_cast<Index>(s);
      }
    }
  }
  const acoustics::HelmholtzBem solver(std::move(radiating));
  acoustics::BemOptions bem;
  bem.medium = options.pass.air;
  bem.allow_coarse = true;
  bem.n_blas_threads = 1;  // the same bits on any number of threads
  Eigen::Matrix3Xd points(3, static_cast<Index>(points_m.size()));
  for (std::size_t i = 0; i < points_m.size(); ++i) points.col(static_cast<Index>(i)) = points_m[i];
  solver.check_outside(points);
  result.n_elements = solver.surface().n_triangles();

  const bubble::SourcePoints sources = bubble::random_source_points(boundary, options.n_fluid_sources, 1, 1);
  bubble::DualDomainOptions solve = options.pass;
  const double omega = 2.0 * kPi * frequency_hz;
  for (int turn = 0; turn < options.max_turns; ++turn) {
    monitor.throw_if_stopped();
    result.liquid = bubble::solve_dual_domain(boundary, frequency_hz, sources, {{bubble_m, 0.001}}, solve)[0];
    if (!result.liquid.usable()) throw NumericalError("two-way: " + result.liquid.message);
    Eigen::MatrixXcd velocity = Eigen::MatrixXcd::Zero(3 * surface.triangles.rows(), 1);
    for (std::size_t i = 0; i < corner_sample.size(); ++i)  // dP/dn = -i omega rho v_n
      if (corner_sample[i] >= 0)
        velocity(static_cast<Index>(i), 0) = result.liquid.normal_derivative[corner_sample[i]] *
                                             Complex(0.0, 1.0 / (omega * options.pass.liquid.density_kg_m3));
    const acoustics::BemResult air = solver.solve(frequency_hz, velocity, bem);
    if (!air.usable()) throw NumericalError("two-way: " + air.message);
    const Eigen::VectorXcd pressure = solver.pressure_at(air, points);
    double change = 0.0;
    for (Index i = 0; i < pressure.size(); ++i)
      change = std::max(change, turn == 0 ? 1.0
                                          : std::abs(pressure[i] - result.pressure[static_cast<std::size_t>(i)]) /
                                                std::abs(pressure[i]));
    result.change.push_back(change);
    result.pressure.assign(pressure.data(), pressure.data() + pressure.size());
    if (turn == 0) result.one_way_pressure = result.pressure;
    if (turn > 0 && change <= options.tolerance) {
      result.converged = true;
      break;
    }
    solve.surface_pressure = Eigen::VectorXcd::Zero(static_cast<Index>(boundary.samples().size()));
    for (std::size_t s = 0; s < boundary.samples().size(); ++s)
      if (boundary.samples()[s].region == bubble::BoundaryRegion::kFreeSurface)
        solve.surface_pressure[static_cast<Index>(s)] =
            air.pressure_pa(element_vertex[static_cast<std::size_t>(boundary.samples()[s].vertex)], 0) /
            result.liquid.source_strength;
  }
  return result;
}

}  // namespace klang::validate
