#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/quasistatic/stress_field.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// Share of the strain energy that the mesh is too stiff to take up, estimated: energy of the difference between the stress and
/// its mean over the elements at each corner, interpolated (Zienkiewicz and Zhu 1987), over that energy plus the field's. A
/// displacement method gives too little energy for given forces: E_mesh = (1 - share) E. Where one layer of linear elements
/// bends, the estimate is above a third, and the truth above that.
double energy_share_missing(const mesh::TetMesh& mesh, const StressField& field, const solid::Material& material);

}  // namespace klang::fracture
