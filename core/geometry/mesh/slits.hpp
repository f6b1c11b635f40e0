#pragma once
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// A surface whose slits are shut. A slit is where two triangles lie on each other and face each other: nothing is between them.
struct ShutSlits {
  std::vector<Eigen::Index> kept;  ///< triangles that belong to no slit, ascending
  std::vector<int> vertex_of;      ///< of each vertex: the first at its place; itself where there are no slits at all
  bool any = false;
};

/// Slits are found by their corners' places, which must be the same to the last bit, as copies of nodes are. Where there are some, vertices at one place
/// become one, so that what is left closes over a slit's mouth.
/// @param surface  rows of 3 or 6
ShutSlits shut_slits(const SurfaceMesh& surface);

}  // namespace klang::mesh
