#pragma once
#include <complex>
#include <memory>

#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

/// How a sphere moves, by degree from 0.
enum class SpherePattern { kPulsating, kDipole, kQuadrupole, kOctupole };
constexpr auto words_of(SpherePattern) {
  return std::array{Word{SpherePattern::kPulsating, "pulsating"}, Word{SpherePattern::kDipole, "dipole"},
                    Word{SpherePattern::kQuadrupole, "quadrupole"}, Word{SpherePattern::kOctupole, "octupole"}};
}

/// A sphere with normal velocity P_n(cos theta) x 1 m/s, P_n the Legendre polynomial: n = 0 pulsates, 1 is a dipole, 2 an
/// axial quadrupole, 3 an axial octupole.
struct SphereCase {
  int degree = 0;
  double radius_m = 0.1;
  double ka = 1.0;
  int divisions = 10;     ///< 20 divisions^2 elements
  void validate() const;  ///< InputError
  double frequency_hz(const Medium& medium) const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"degree", "Of the Legendre polynomial", between(0.0, 20.0)}, self.degree);
    visit({"radius_m", "Radius of the sphere", between(1e-6, 1e6)}, self.radius_m);
    visit({"ka", "Wavenumber times radius of the sphere", between(1e-3, 100.0)}, self.ka);
    visit({"divisions", "Of the edges of the icosahedron", between(1.0, 100.0)}, self.divisions);
  }
};

/// Exact surface pressure over normal velocity, -i rho c h_n(ka) / h_n'(ka) [Pa s/m], h_n^(2).
std::complex<double> sphere_impedance(int degree, double ka, const Medium& medium);

/// Exact pressure [Pa] of the case at a point on or outside the sphere.
std::complex<double> sphere_pressure_pa(const SphereCase& sphere, const Medium& medium, const Eigen::Vector3d& x_m);

/// Exact coefficient M_n^0 [Pa]; all others are 0.
std::complex<double> sphere_coefficient_pa(const SphereCase& sphere, const Medium& medium);

/// Exact radiated power [W], time average: 1/2 Re Z integral P_n^2 dS = 2 pi a^2 / (2 n + 1) Re Z, Z the sphere_impedance.
double sphere_radiated_power_w(const SphereCase& sphere, const Medium& medium);

/// Divisions of the icosahedron's edges that give at least n_elements.
int sphere_divisions(int n_elements);

struct SphereResult {
  std::shared_ptr<const HelmholtzBem> solver;
  BemResult bem;
  /// Of pressure on the surface against the exact one, both in the mean square over the polyhedron (7 points per triangle).
  double surface_pressure_relative_error = 0.0;
  double element_size_m = 0.0;  ///< edge of the equilateral triangle of mean area
  Multipole multipole;          ///< about the centre, of order max(degree, ceil(ka)) + 2
};

/// Boundary elements on a geodesic polyhedron of the ball's volume. The velocity goes over to the flat triangles with its
/// volume flow (by solid angle), linear on each triangle.
SphereResult solve_sphere(const SphereCase& sphere, const BemOptions& options = {},
                          Monitor& monitor = silent_monitor());
/// As solve_sphere with the solver of an earlier result of the same radius and divisions: saves what no frequency changes.
SphereResult solve_sphere(const SphereCase& sphere, std::shared_ptr<const HelmholtzBem> solver,
                          const BemOptions& options = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::acoustics
