#pragma once

#include "core/physics/rigid/contact.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::rigid {

/// 1/E* = (1 - nu_a^2)/E_a + (1 - nu_b^2)/E_b [1/Pa], inverted (Hertz 1881).
double contact_modulus_pa(const Skin& a, const Skin& b);

/// Radius of the ball on a plane whose spring k = 4/3 E* sqrt(R) two surfaces have, by Hertz' elliptic contact (Johnson 1985, 4.28 to
/// 4.33): with A = k2/2, q the ratio of the ellipse's axes, e^2 = 1 - q^2, A/B = (K - E) / (E/q^2 - K): R = (pi^2/4) (K - E) / (A e^2 K^3).
/// @param larger_per_m, smaller_per_m  principal curvatures of the gap, both > 0; ratios above 1e6 count as 1e6
double elliptic_radius_m(double larger_per_m, double smaller_per_m);

/// That of the surfaces of two bodies where they touch. No touch is longer than the smaller of them.
/// @param b  null: the floor
double touch_radius_m(const RigidBodySpec& a, const RigidBodySpec* b, const ContactImpulse& touch);

/// Contact time of two elastic bodies with round surfaces: T = 2.868266 (m^2 / (R E*^2 v))^(1/5), the exact constant being
/// (4/5) B(2/5, 1/2) (15/16)^(2/5); fracture.md's table has the same. All > 0.
/// @param mass_kg       effective: 1 / (n . A n), A the inverse inertia of the pair at the place
/// @param radius_m      1 / (1/R_a + 1/R_b)
/// @param approach_m_s  normal speed at touch
double hertz_duration_s(double mass_kg, double radius_m, double contact_modulus_pa, double approach_m_s);

}  // namespace klang::rigid
