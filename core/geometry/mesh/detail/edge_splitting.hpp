#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::detail {

/// Halves edges until none is longer than max_edge_m: always an edge that is the longest of each of its tetrahedra, which are cut in
/// two (Rivara 1984, Int. J. Numer. Meth. Eng. 20, 745-756), so that the volume and the surface stay and angles shrink no further
/// than bisection takes them. Linear elements.
void split_long_edges(TetMesh& mesh, double max_edge_m);

}  // namespace klang::mesh::detail
