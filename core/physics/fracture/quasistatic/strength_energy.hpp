#pragma once
#include <Eigen/Core>

#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// Upper bound of the largest principal stress [Pa] of an element whose mean energy density is energy_density_j_m3, with n the
/// stress' direction and C Hooke's law
///
///     n . sigma n = eps : C : (n x n) <= sqrt(eps : C : eps) sqrt((n x n) : C : (n x n)) = sqrt(2 w (lambda + 2 mu)),
///
/// equal for a strain along n alone. It also holds for the means of an element, whatever the stress within it (Jensen).
double principal_stress_bound_pa(const solid::Material& material, double energy_density_j_m3);

/// Least strain energy [J] of the whole body with which any element's mean principal stress could reach its strength: an element
/// holds no more than the body, so that n . sigma n <= sqrt(2 (lambda + 2 mu) E_S / V_e). A load that cannot put in as much
/// breaks nothing, and that is known before its stress is solved. A part in 1e9 is left for round-off.
/// @param volume_m3, strength_pa  by element, above 0
double strength_energy_j(const solid::Material& material, const Eigen::VectorXd& volume_m3,
                         const Eigen::VectorXd& strength_pa);

}  // namespace klang::fracture
