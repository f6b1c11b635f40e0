#pragma once
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::solid {

/// What is odd about a support on this mesh: a plane x=VALUE that cuts through the body, where an end was probably meant
/// (analytic bodies are centred on the origin: docs/shapes.md); empty: nothing.
std::string support_doubt(const Support& support, const mesh::TetMesh& mesh);

}  // namespace klang::solid
