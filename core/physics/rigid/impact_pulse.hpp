#pragma once

#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid {

/// 1/E* = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b [1/Pa], inverted (Hertz 1881).
double contact_modulus_pa(const Skin& a, const Skin& b);

/// Contact time of two elastic bodies with round surfaces: T = 2.868266 (m^2 / (R E*^2 v))^(1/5), the exact constant being
/// (4/5) B(2/5, 1/2) (15/16)^(2/5); fracture.md's table has the same. All > 0.
/// @param mass_kg       effective: 1 / (n . A n), A the inverse inertia of the pair at the place
/// @param radius_m      1 / (1/R_a + 1/R_b)
/// @param approach_m_s  normal speed at touch
double hertz_duration_s(double mass_kg, double radius_m, double contact_modulus_pa, double approach_m_s);

}  // namespace klang::rigid
