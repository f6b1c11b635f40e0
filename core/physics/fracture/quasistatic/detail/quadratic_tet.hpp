#pragma once
#include <Eigen/Core>
#include <array>

namespace klang::fracture::detail {

using QuadraticDerivative = Eigen::Matrix<double, 10, 3>;

/// Derivatives by (l1, l2, l3) of the ten shape functions of a quadratic tetrahedron (mesh::TetMesh's order) at barycentric l.
inline QuadraticDerivative quadratic_derivative(const std::array<double, 4>& l) {
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  const auto slope = [](int i) {
    return i == 0 ? Eigen::RowVector3d(-1, -1, -1) : Eigen::RowVector3d(Eigen::RowVector3d::Unit(i - 1));
  };
  QuadraticDerivative derivative;
  for (int i = 0; i < 4; ++i) derivative.row(i) = (4.0 * l[i] - 1.0) * slope(i);
  for (int k = 0; k < 6; ++k) {
    const int i = edges[k][0], j = edges[k][1];
    derivative.row(4 + k) = 4.0 * (l[i] * slope(j) + l[j] * slope(i));
  }
  return derivative;
}

}  // namespace klang::fracture::detail
