#include "core/sound/bem/sphere_radiation.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/sound/waves/spherical_bessel.hpp"

namespace klang::acoustics {

using Complex = std::complex<double>;
using Eigen::Vector3d;

namespace {

struct Hankel {
  Complex value, slope;
};

Hankel hankel(int degree, double x) {
  std::vector<Complex> h(static_cast<std::size_t>(degree) + 2), d(h.size() - 1);
  spherical_hankel2(x, h);
  spherical_derivatives<Complex>(x, h, d);
  return {h[static_cast<std::size_t>(degree)], d[static_cast<std::size_t>(degree)]};
}

Vector3d point_of(const RadiatingSurface& surface, int t, const TrianglePoint& point) {
  return point.at[0] * surface.corner(t, 0) + point.at[1] * surface.corner(t, 1) + point.at[2] * surface.corner(t, 2);
}

/// Mean-square projection onto linear functions of each triangle of the velocity times the ratio of the sphere's area to
/// the polyhedron's under the same solid angle, radius^2 n.x / |x|^3.
Eigen::MatrixXcd corner_velocity(const RadiatingSurface& surface, const SphereCase& sphere) {
  Eigen::MatrixXcd velocity(3 * surface.n_triangles(), 1);
  for (int t = 0; t < surface.n_triangles(); ++t) {
    Vector3d moments = Vector3d::Zero();
    for (const TrianglePoint& point : seven_points()) {
      const Vector3d x = point_of(surface, t, point);
      const double r = x.norm();
      const double ratio = sphere.radius_m * sphere.radius_m * surface.normals.col(t).dot(x) / (r * r * r);
      const double v = std::legendre(static_cast<unsigned>(sphere.degree), x[2] / r) * ratio;
      moments += (point.weight * v) * Eigen::Map<const Vector3d>(point.at.data());
    }
    // The mass matrix of hat functions over the area is (1 + I) / 12.
    for (int c = 0; c < 3; ++c) velocity(3 * t + c, 0) = 12.0 * (moments[c] - 0.25 * moments.sum());
  }
  return velocity;
}

}  // namespace

void SphereCase::validate() const { validate_fields("sphere", *this); }

double SphereCase::frequency_hz(const Medium& medium) const {
  return ka * medium.sound_speed_m_s / (2.0 * kPi * radius_m);
}

Complex sphere_impedance(int degree, double ka, const Medium& medium) {
  const Hankel h = hankel(degree, ka);
  return Complex(0.0, -medium.density_kg_m3 * medium.sound_speed_m_s) * (h.value / h.slope);
}

Complex sphere_pressure_pa(const SphereCase& sphere, const Medium& medium, const Vector3d& x_m) {
  const double r = x_m.norm();
  const Complex ratio =
      hankel(sphere.degree, sphere.ka * r / sphere.radius_m).value / hankel(sphere.degree, sphere.ka).slope;
  return Complex(0.0, -medium.density_kg_m3 * medium.sound_speed_m_s) * ratio *
         std::legendre(static_cast<unsigned>(sphere.degree), x_m[2] / r);
}

Complex sphere_coefficient_pa(const SphereCase& sphere, const Medium& medium) {
  // P_n = sqrt(4 pi / (2 n + 1)) Y_n^0
  return Complex(0.0, -medium.density_kg_m3 * medium.sound_speed_m_s) / hankel(sphere.degree, sphere.ka).slope *
         std::sqrt(4.0 * kPi / (2.0 * sphere.degree + 1.0));
}

double sphere_radiated_power_w(const SphereCase& sphere, const Medium& medium) {
  return 2.0 * kPi * sphere.radius_m * sphere.radius_m / (2 * sphere.degree + 1) *
         sphere_impedance(sphere.degree, sphere.ka, medium).real();
}

int sphere_divisions(int n_elements) { return static_cast<int>(std::ceil(std::sqrt(n_elements / 20.0) - 1e-9)); }

SphereResult solve_sphere(const SphereCase& sphere, const BemOptions& options, Monitor& monitor) {
  sphere.validate();
  return solve_sphere(
      sphere, std::make_shared<HelmholtzBem>(radiating_surface(geodesic_sphere(sphere.radius_m, sphere.divisions))),
      options, monitor);
}

SphereResult solve_sphere(const SphereCase& sphere, std::shared_ptr<const HelmholtzBem> solver,
                          const BemOptions& options, Monitor& monitor) {
  sphere.validate();
  SphereResult result;
  result.solver = std::move(solver);
  KLANG_CHECK(result.solver->surface().n_triangles() == 20 * sphere.divisions * sphere.divisions, "another sphere");
  const RadiatingSurface& surface = result.solver->surface();
  result.element_size_m = std::sqrt(4.0 / std::sqrt(3.0) * surface.areas_m2.mean());
  const double frequency_hz = sphere.frequency_hz(options.medium);
  result.bem = result.solver->solve(frequency_hz, corner_velocity(surface, sphere), options, monitor);
  if (!result.bem.usable()) return result;

  double error = 0.0, scale = 0.0;
  for (int t = 0; t < surface.n_triangles(); ++t)
    for (const TrianglePoint& point : seven_points()) {
      const Vector3d x = point_of(surface, t, point).normalized() * sphere.radius_m;
      Complex p = 0.0;
      for (int c = 0; c < 3; ++c) p += point.at[c] * result.bem.pressure_pa(surface.triangles(c, t), 0);
      const Complex exact = sphere_pressure_pa(sphere, options.medium, x);
      const double weight = point.weight * surface.areas_m2[t];
      error += weight * std::norm(p - exact);
      scale += weight * std::norm(exact);
    }
  result.surface_pressure_relative_error = std::sqrt(error / scale);

  const int order = std::max(sphere.degree, static_cast<int>(std::ceil(sphere.ka))) + 2;
  result.multipole.wavenumber_per_m = result.bem.wavenumber_per_m;
  result.multipole.order = order;
  result.multipole.coefficients_pa = multipole_coefficients(
      result.solver->field(result.bem), result.bem.wavenumber_per_m, options.medium, Vector3d::Zero(), order);
  return result;
}

}  // namespace klang::acoustics
