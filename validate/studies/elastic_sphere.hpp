#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/solid/material.hpp"

namespace klang::validate {

enum class SphereModeKind { kTorsional, kSpheroidal };

/// A free vibration of a homogeneous elastic ball.
struct SphereMode {
  SphereModeKind kind = SphereModeKind::kTorsional;
  int degree = 0;             ///< l; 2 l + 1 modes share the eigenvalue
  double wavenumber_a = 0.0;  ///< x = omega a / c_s, c_s = sqrt(mu / rho)
  int multiplicity() const { return 2 * degree + 1; }
};

/// Roots of Lamb's characteristic equations of a free ball up to x = highest, ascending, rigid modes left out.
///   torsional, l >= 1:   (l - 1) j_l(x) - x j_{l+1}(x) = 0
///   spheroidal, l = 0:   4 y j_1(y) - x^2 j_0(y) = 0
///   spheroidal, l >= 1:  the 2 x 2 determinant of radial and tangential traction of a compressional (argument y) and a shear
///                        potential (argument x)
/// with y = x c_s / c_p = x sqrt((1 - 2 nu) / (2 - 2 nu)). Found by a scan of step 0.01 (neighbouring roots of one equation
/// lie much further apart) and bisection to the last digit.
/// @param poissons_ratio nu, -1 < nu < 0.5
/// @param highest        0 < highest <= 40
/// @throws InputError
/// Source: Lamb 1882, Proc. London Math. Soc. 13, 189; form of Eringen and Suhubi 1975, Elastodynamics II, 8.14.
std::vector<SphereMode> elastic_sphere_modes(double poissons_ratio, double highest);

/// Frequencies [Hz] of the lowest count modes, each as often as its multiplicity says, ascending.
Eigen::VectorXd elastic_sphere_frequency_hz(double radius_m, const solid::Material& material, int count);

/// Displacement of the torsional mode (degree l, m = 0) at a point, not normalised:
///   u = j_l(x r / a) dP_l(cos theta)/dtheta e_phi
Eigen::Vector3d torsional_displacement(int degree, double wavenumber_a, double radius_m,
                                       const Eigen::Vector3d& point_m);

}  // namespace klang::validate
