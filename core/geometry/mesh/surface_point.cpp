#include "core/geometry/mesh/surface_point.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "core/foundation/base/errors.hpp"

namespace klang::mesh {
namespace {

/// Barycentric coordinates of the point of an edge that is nearest to p.
Eigen::Vector3d nearest_on_edge(const Eigen::Matrix3d& corners, const Eigen::Vector3d& p, int a, int b) {
  const Eigen::Vector3d along = corners.col(b) - corners.col(a);
  const double t = std::clamp(along.dot(p - corners.col(a)) / along.squaredNorm(), 0.0, 1.0);
  Eigen::Vector3d hats = Eigen::Vector3d::Zero();
  hats[a] = 1.0 - t;
  hats[b] = t;
  return hats;
}

/// The same for the whole triangle: the foot on its plane where that lies within, else the nearest edge's.
Eigen::Vector3d nearest_on_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << corners.col(1) - corners.col(0), corners.col(2) - corners.col(0);
  const Eigen::Vector2d foot = (edges.transpose() * edges).inverse() * (edges.transpose() * (p - corners.col(0)));
  const Eigen::Vector3d inside(1.0 - foot[0] - foot[1], foot[0], foot[1]);
  if (inside.minCoeff() >= 0.0) return inside;
  Eigen::Vector3d best;
  double least = std::numeric_limits<double>::infinity();
  for (int edge = 0; edge < 3; ++edge) {
    const Eigen::Vector3d hats = nearest_on_edge(corners, p, edge, (edge + 1) % 3);
    const double distance = (corners * hats - p).squaredNorm();
    if (distance < least) least = distance, best = hats;
  }
  return best;
}

}  // namespace

SurfacePoint nearest_surface_point(const TetMesh& mesh, const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) throw InputError("surface point", "is not finite");
  if (mesh.n_elements() == 0) throw InputError("surface point", "the mesh has no elements");
  return nearest_surface_point(boundary_surface(mesh), point_m);
}

SurfacePoint nearest_surface_point(const SurfaceMesh& surface, const Eigen::Vector3d& point_m) {
  if (!point_m.allFinite()) throw InputError("surface point", "is not finite");
  if (surface.triangles.rows() == 0) throw InputError("surface point", "the surface has no triangles");
  SurfacePoint found;
  Eigen::Vector3d hats = Eigen::Vector3d::Zero();
  Eigen::Index triangle = 0;
  found.distance_m = std::numeric_limits<double>::infinity();
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    Eigen::Matrix3d corners;
    for (int c = 0; c < 3; ++c) corners.col(c) = surface.vertices_m.row(surface.triangles(t, c)).transpose();
    const Eigen::Vector3d here = nearest_on_triangle(corners, point_m);
    const double distance = (corners * here - point_m).norm();
    if (distance < found.distance_m) found.distance_m = distance, hats = here, triangle = t;
  }
  for (Eigen::Index c = 0; c < surface.triangles.cols(); ++c) found.nodes.push_back(surface.triangles(triangle, c));
  found.barycentric = hats;
  found.weights = hats;
  if (surface.triangles.cols() == 6) {
    found.weights.resize(6);
    for (int c = 0; c < 3; ++c) {
      found.weights[c] = hats[c] * (2.0 * hats[c] - 1.0);
      found.weights[3 + c] = 4.0 * hats[c] * hats[(c + 1) % 3];
    }
  }
  return found;
}

}  // namespace klang::mesh
