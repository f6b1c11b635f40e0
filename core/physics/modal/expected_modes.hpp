#pragma once
#include <string_view>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::modal {

/// How many modes a body has below a frequency f, to about a factor of two where there are hundreds: the larger of
///   V omega^3 (1/c_p^3 + 2/c_s^3) / (6 pi^2)                 of its volume V (Weyl's law for elastic waves) and
///   A omega sqrt(12 rho (1 - nu^2) / E) / (4 pi h)           of a plate with its area, A = S / 2, and mean thickness, h = 2 V / S.
/// Meant to tell thousands of modes from billions (a modulus or a length in another unit) before they are asked for.
/// Sources: Dupuis, Mazo & Onsager 1960, J. Chem. Phys. 33, 1452 (volume); Courant & Hilbert, Methods of Mathematical Physics I,
/// section VI.4 (plate).
double expected_modes(const mesh::TetMesh& mesh, const solid::Material& material, double frequency_hz);

/// Refuses a band of more than most expected modes: memory or time would end first. by_mesh: the mesh's own unknowns bound them.
/// @throws InputError
void check_expected_modes(std::string_view place, const mesh::TetMesh& mesh, const solid::Material& material,
                          double frequency_hz, bool by_mesh, double most = 20000.0);

}  // namespace klang::modal
