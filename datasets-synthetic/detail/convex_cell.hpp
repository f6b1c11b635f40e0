#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::datasets::detail {

/// A closed convex body: plane faces, each a loop of vertices counter-clockwise seen from outside.
struct ConvexCell {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::vector<int>> faces;

  bool empty() const { return faces.empty(); }
  double volume_m3() const;
  /// Shortest edge of a face; infinite where empty.
  double shortest_edge_m() const;
};

/// A box around the origin.
ConvexCell box_cell(const Eigen::Vector3d& size_m);

/// What of the cell lies where normal . x <= offset. Vertices nearer to the plane than 1e-12 of the size of what the cell was cut from count as on it.
/// @param normal  of length 1
ConvexCell clipped(const ConvexCell& cell, const Eigen::Vector3d& normal, double offset_m);

/// The box cut into the Voronoi cells of the seeds, one for each in order: cell i is what lies nearest to seed i.
std::vector<ConvexCell> voronoi_cells(const Eigen::Vector3d& box_m, const std::vector<Eigen::Vector3d>& seeds_m);

/// Its faces cut into triangles, unused vertices dropped.
mesh::SurfaceMesh surface_of(const ConvexCell& cell);

}  // namespace klang::datasets::detail
