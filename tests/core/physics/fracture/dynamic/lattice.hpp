#pragma once
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <random>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::test {

/// Cells of a box cut into six tetrahedra each along the diagonal (1,1,1). Nodes inside and on faces may be moved at random by a
/// share of the cell.
inline mesh::TetMesh lattice(std::array<int, 3> cells, const Eigen::Vector3d& size_m, double shake = 0.0,
                             unsigned seed = 1) {
  mesh::TetMesh mesh;
  const auto number = [&](int i, int j, int k) { return (i * (cells[1] + 1) + j) * (cells[2] + 1) + k; };
  mesh.nodes_m.resize((cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1), 3);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> part(-shake, shake);
  for (int i = 0; i <= cells[0]; ++i)
    for (int j = 0; j <= cells[1]; ++j)
      for (int k = 0; k <= cells[2]; ++k) {
        const std::array<int, 3> at = {i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          const int most = cells[static_cast<std::size_t>(axis)], here = at[static_cast<std::size_t>(axis)];
          const double move = here > 0 && here < most ? part(random) : 0.0;
          mesh.nodes_m(number(i, j, k), axis) = size_m[axis] * (here + move) / most;
        }
      }
  std::vector<std::array<int, 4>> elements;
  for (int i = 0; i < cells[0]; ++i)
    for (int j = 0; j < cells[1]; ++j)
      for (int k = 0; k < cells[2]; ++k) {
        std::array<int, 3> order = {0, 1, 2};
        do {
          std::array<int, 3> at = {i, j, k};
          std::array<int, 4> nodes = {number(i, j, k)};
          for (std::size_t step = 0; step < 3; ++step) {
            ++at[static_cast<std::size_t>(order[step])];
            nodes[step + 1] = number(at[0], at[1], at[2]);
          }
          Eigen::Matrix3d edges;
          for (int c = 0; c < 3; ++c)
            edges.col(c) =
                (mesh.nodes_m.row(nodes[static_cast<std::size_t>(c + 1)]) - mesh.nodes_m.row(nodes[0])).transpose();
          if (edges.determinant() < 0.0) std::swap(nodes[2], nodes[3]);
          elements.push_back(nodes);
        } while (std::next_permutation(order.begin(), order.end()));
      }
  mesh.elements.resize(static_cast<int>(elements.size()), 4);
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int c = 0; c < 4; ++c) mesh.elements(static_cast<int>(e), c) = elements[e][static_cast<std::size_t>(c)];
  return mesh;
}

/// A mesh with a slit in the plane z = height_m for x above from_m: what lies above it gets nodes of its own.
inline mesh::TetMesh slit_at(const mesh::TetMesh& whole, double height_m, double from_m) {
  mesh::TetMesh mesh = whole;
  std::vector<int> copy(static_cast<std::size_t>(whole.n_nodes()), -1);
  int n = whole.n_nodes();
  for (int i = 0; i < whole.n_nodes(); ++i)
    if (std::abs(whole.nodes_m(i, 2) - height_m) < 1e-9 && whole.nodes_m(i, 0) > from_m + 1e-9)
      copy[static_cast<std::size_t>(i)] = n++;
  mesh.nodes_m.conservativeResize(n, 3);
  for (int i = 0; i < whole.n_nodes(); ++i)
    if (copy[static_cast<std::size_t>(i)] >= 0)
      mesh.nodes_m.row(copy[static_cast<std::size_t>(i)]) = whole.nodes_m.row(i);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    double z = 0.0;
    for (int c = 0; c < 4; ++c) z += 0.25 * whole.nodes_m(whole.elements(e, c), 2);
    for (int c = 0; c < 4; ++c)
      if (const int own = copy[static_cast<std::size_t>(whole.elements(e, c))]; own >= 0 && z > height_m)
        mesh.elements(e, c) = own;
  }
  return mesh;
}

}  // namespace klang::test
