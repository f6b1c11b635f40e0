#include "core/physics/fracture/quasistatic/detail/corner_fit.hpp"

#include <Eigen/LU>

#include "core/foundation/math/tet_rule.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"
#include "core/physics/fracture/quasistatic/detail/quadratic_tet.hpp"

namespace klang::fracture::detail {
namespace {

constexpr double kStraightTolerance = 1e-12;  // of the edge, for its mid-node

}  // namespace

bool has_curved_edge(const mesh::TetMesh& mesh, int e) {
  for (int m = 0; m < 6; ++m) {
    const Eigen::RowVector3d a = mesh.nodes_m.row(mesh.elements(e, mesh::kTetEdges[m][0])),
                             b = mesh.nodes_m.row(mesh.elements(e, mesh::kTetEdges[m][1]));
    const Eigen::RowVector3d off = mesh.nodes_m.row(mesh.elements(e, 4 + m)) - 0.5 * (a + b);
    if (!(off.norm() <= kStraightTolerance * (b - a).norm())) return true;
  }
  return false;
}

TetNodes nodes_of(const mesh::TetMesh& mesh, int e) {
  TetNodes nodes;
  for (int c = 0; c < 10; ++c) nodes.col(c) = mesh.nodes_m.row(mesh.elements(e, c)).transpose();
  return nodes;
}

CornerGram corner_gram(const mesh::TetMesh& mesh, int e) {
  CornerGram gram;
  if (mesh.order() != 2 || !has_curved_edge(mesh, e)) {
    gram.volume_m3 = mesh::tet_volume_m3(mesh, e);
    gram.inverse = 20.0 / gram.volume_m3 * (Eigen::Matrix4d::Identity() - Eigen::Matrix4d::Constant(0.2));
    return gram;
  }
  static const TetRule rule = make_tet_rule();
  const TetNodes nodes = nodes_of(mesh, e);
  Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
  for (int q = 0; q < TetRule::kPoints; ++q) {
    const double weight = rule.weight[q] * (nodes * quadratic_derivative(rule.point[q])).determinant();
    const Eigen::Map<const Eigen::Vector4d> l(rule.point[q].data());
    products += weight * l * l.transpose();
    gram.volume_m3 += weight;
  }
  gram.inverse = products.inverse();
  return gram;
}

}  // namespace klang::fracture::detail
