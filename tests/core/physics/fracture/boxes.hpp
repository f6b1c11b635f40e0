#pragma once
#include <Eigen/Core>

#include "core/geometry/shapes/shape.hpp"

namespace klang::fracture::testing {

/// A box around its middle in straight tetrahedra.
inline mesh::TetMesh box(const Eigen::Vector3d& sides_m, int nx, int ny, int nz) {
  mesh::ShapeSpec spec{"box", {{"length_m", sides_m[0]}, {"width_m", sides_m[1]}, {"height_m", sides_m[2]}}, {}};
  mesh::TetMesh mesh = mesh::to_linear(mesh::mesh_shape(spec, mesh::ShapeDivisions{{nx, ny, nz}}, 1));
  const Eigen::RowVector3d middle = 0.5 * (mesh.nodes_m.colwise().maxCoeff() + mesh.nodes_m.colwise().minCoeff());
  mesh.nodes_m.rowwise() -= middle;
  return mesh;
}

/// Its corners.
inline Eigen::Matrix3Xd corners(const Eigen::Vector3d& sides_m) {
  Eigen::Matrix3Xd out(3, 8);
  for (int i = 0; i < 8; ++i)
    out.col(i) = 0.5 * sides_m.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  return out;
}

}  // namespace klang::fracture::testing
