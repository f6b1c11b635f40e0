#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::fracture {

/// One function per region, linear on every tetrahedron of a mesh: the region of a point is that of the smallest. The regions of
/// power cells are so exactly, those of weighted paths along edges (geodesic) between nodes.
struct RegionFields {
  Eigen::MatrixXd values;  ///< regions x nodes
  Eigen::MatrixXd
      slopes;  ///< regions x regions: how fast the difference of two grows per metre at most; diagonal unused
  int n_regions() const { return static_cast<int>(values.rows()); }
};

/// A mesh of which each tetrahedron belongs to one region.
struct RegionCut {
  mesh::TetMesh mesh;        ///< straight tetrahedra that share faces; the nodes of the mesh that was cut come first
  std::vector<int> region;   ///< by element
  std::vector<int> element;  ///< by element: the one of the mesh that was cut in which it lies
};

/// Cuts tetrahedra in which several regions meet where their functions are equal, so that planes stay planes: on edges where the
/// least function changes, on faces where three are equal, inside where four are. Each is found from the edge, face or
/// tetrahedron alone: neighbours agree. A point is in every region whose plane is within 1e-10 of the body's size, so a crack
/// through a node makes no sliver. Where that is not to be decided by rounding, all planes are shifted by a few times that. The elements' volumes add up to those of the mesh.
///
/// A region is convex in a tetrahedron: its part there is the hull of the points that have it, filled from its lowest vertex. What lies on
/// a face is a fan from its lowest vertex, whichever side looks.
/// @param mesh  straight (order 1)
/// @throws InputError for values that are not finite, and where even shifted planes leave an element unfilled (none is known)
RegionCut cut_regions(const mesh::TetMesh& mesh, const RegionFields& fields);

}  // namespace klang::fracture
