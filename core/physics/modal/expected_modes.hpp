#pragma once
#include <string_view>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::modal {

/// A body's volume V and surface S.
struct BodySize {
  double volume_m3 = 0.0, surface_m2 = 0.0;
};

BodySize size_of(const mesh::TetMesh& mesh);

/// How many modes a body has below a frequency f, to about a factor of two where there are hundreds: the larger of
///   V omega^3 (1/c_p^3 + 2/c_s^3) / (6 pi^2)                 of its volume V (Weyl's law for elastic waves) and
///   A omega sqrt(12 rho (1 - nu^2) / E) / (4 pi h)           of a plate with its area, A = S / 2, and mean thickness, h = 2 V / S.
/// Meant to tell thousands of modes from billions (a modulus or a length in another unit) before they are asked for.
/// Sources: Dupuis, Mazo & Onsager 1960, J. Chem. Phys. 33, 1452 (volume); Courant & Hilbert, Methods of Mathematical Physics I,
/// section VI.4 (plate).
double expected_modes(const BodySize& size, const solid::Material& material, double frequency_hz);

constexpr double kMostModes = 20000.0;  ///< of a band; with more a unit is wrong, and memory or time would end first

/// @throws InputError where more than most modes are expected below the frequency
void check_expected_modes(std::string_view place, double expected, double frequency_hz, double most = kMostModes);

}  // namespace klang::modal
