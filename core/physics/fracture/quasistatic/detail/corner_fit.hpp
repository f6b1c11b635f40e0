#pragma once
#include <Eigen/Core>

#include "core/geometry/mesh/tet_mesh.hpp"

/// The linear function over an element that is nearest to a stress in the mean square: its values at the corners are
/// M^-1 (int l_c sigma dV), M the Gram matrix of the barycentric coordinates l. It is the stress itself where edges are straight.
namespace klang::fracture::detail {

using TetNodes = Eigen::Matrix<double, 3, 10>;

bool has_curved_edge(const mesh::TetMesh& mesh, int element);
TetNodes nodes_of(const mesh::TetMesh& mesh, int element);

/// Inverse of the Gram matrix of an element's barycentric coordinates [1/m^3], and its volume [m^3].
struct CornerGram {
  Eigen::Matrix4d inverse;
  double volume_m3 = 0.0;
};
CornerGram corner_gram(const mesh::TetMesh& mesh, int element);

}  // namespace klang::fracture::detail
