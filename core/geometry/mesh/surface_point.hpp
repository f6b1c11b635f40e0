#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// A point of a body's boundary as a weighted mean of its nodes: sum_k weights[k] u(nodes[k]) is a nodal field's value
/// there. Weights are the element's shape functions and add up to 1.
struct SurfacePoint {
  std::vector<int> nodes;  ///< 3 of a straight mesh, 6 of a quadratic one
  Eigen::VectorXd weights;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();  ///< of the triangle's corners
  double distance_m = 0.0;                                ///< of the wanted point from the triangle's plane corners
};

/// The boundary's point nearest to a point, by the triangles' corners (curved ones: to their sagitta); of equal ones that in
/// the first triangle.
/// @throws InputError for a point that is not finite or a mesh without elements
SurfacePoint nearest_surface_point(const TetMesh& mesh, const Eigen::Vector3d& point_m);
/// The same on a boundary that boundary_surface() made once.
SurfacePoint nearest_surface_point(const SurfaceMesh& surface, const Eigen::Vector3d& point_m);

}  // namespace klang::mesh
