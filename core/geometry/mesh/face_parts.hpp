#pragma once
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// The bodies that a mesh consists of: elements that share a face are one. What hangs together by an edge or a node alone is
/// not, since it turns about it.
struct FaceParts {
  int n_parts = 0;
  std::vector<int> part;  ///< of each element, 0 to n_parts - 1, in the order of their first elements
};

FaceParts face_parts(const TetMesh& mesh);

}  // namespace klang::mesh
