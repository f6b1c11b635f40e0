#pragma once
#include <filesystem>
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/quasistatic/body_stress.hpp"

namespace klang::fracture {

/// A .vtu that ParaView opens. Points: displacement_m, force_n. Cells: stress_pa (XX YY ZZ XY YZ XZ, the element's mean),
/// principal_stress_pa (of that, descending), max_principal_stress_pa (at the element's corners), energy_density_j_m3.
/// @throws InputError when it cannot be written
void write_stress_file(const std::filesystem::path& path, const mesh::TetMesh& mesh, const BodyStress& stress,
                       const std::string& provenance_json);

}  // namespace klang::fracture
