#pragma once
#include <Eigen/Core>
#include <Eigen/LU>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// dx/d(xi, eta, zeta) of element e at barycentric (1 - xi - eta - zeta, xi, eta, zeta) = bary.
inline Eigen::Matrix3d tet_jacobian(const TetMesh& mesh, int e, const Eigen::Vector4d& bary) {
  // Gradients of the barycentric coordinates in the reference element.
  static const Eigen::Matrix<double, 4, 3> kGradients =
      (Eigen::Matrix<double, 4, 3>() << -1, -1, -1, 1, 0, 0, 0, 1, 0, 0, 0, 1).finished();
  Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
  if (mesh.order() == 1) {
    for (int c = 0; c < 4; ++c) jacobian += mesh.nodes_m.row(mesh.elements(e, c)).transpose() * kGradients.row(c);
    return jacobian;
  }
  for (int c = 0; c < 4; ++c)
    jacobian += mesh.nodes_m.row(mesh.elements(e, c)).transpose() * ((4.0 * bary[c] - 1.0) * kGradients.row(c));
  for (int m = 0; m < 6; ++m) {
    const int a = kTetEdges[m][0], b = kTetEdges[m][1];
    jacobian += mesh.nodes_m.row(mesh.elements(e, 4 + m)).transpose() *
                (4.0 * (bary[a] * kGradients.row(b) + bary[b] * kGradients.row(a)));
  }
  return jacobian;
}

/// Volume of one element: 5-point rule of Grundmann and Moeller, exact for the cubic det J.
inline double tet_volume_m3(const TetMesh& mesh, int e) {
  double sum = -0.8 * tet_jacobian(mesh, e, Eigen::Vector4d::Constant(0.25)).determinant();
  for (int c = 0; c < 4; ++c) {
    Eigen::Vector4d bary = Eigen::Vector4d::Constant(1.0 / 6.0);
    bary[c] = 0.5;
    sum += 0.45 * tet_jacobian(mesh, e, bary).determinant();
  }
  return sum / 6.0;
}

/// Smallest det J over the nodes, the centre and four inner points.
inline double smallest_jacobian(const TetMesh& mesh, int e) {
  double smallest = tet_jacobian(mesh, e, Eigen::Vector4d::Constant(0.25)).determinant();
  if (mesh.order() == 1) return smallest;
  const auto at = [&](const Eigen::Vector4d& bary) {
    const double det = tet_jacobian(mesh, e, bary).determinant();
    if (!(det >= smallest)) smallest = det;
  };
  for (int c = 0; c < 4; ++c) {
    at(Eigen::Vector4d::Unit(c));
    Eigen::Vector4d inner = Eigen::Vector4d::Constant(0.13819660112501051518);
    inner[c] = 0.58541019662496845446;
    at(inner);
  }
  for (const auto& edge : kTetEdges) at(0.5 * (Eigen::Vector4d::Unit(edge[0]) + Eigen::Vector4d::Unit(edge[1])));
  return smallest;
}

}  // namespace klang::mesh
