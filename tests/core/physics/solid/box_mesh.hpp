#pragma once
#include <map>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::test {

/// A box from the origin, cut into nx x ny x nz cells of six tetrahedra each (Kuhn), order 1 or 2.
inline mesh::TetMesh box_mesh(double lx_m, double ly_m, double lz_m, int nx, int ny, int nz, int order) {
  mesh::TetMesh mesh;
  const auto index = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  std::vector<Eigen::Vector3d> nodes((nx + 1) * (ny + 1) * (nz + 1));
  for (int k = 0; k <= nz; ++k)
    for (int j = 0; j <= ny; ++j)
      for (int i = 0; i <= nx; ++i) nodes[index(i, j, k)] = {lx_m * i / nx, ly_m * j / ny, lz_m * k / nz};
  constexpr int paths[6][2] = {{0, 1}, {1, 2}, {2, 0}, {1, 0}, {2, 1}, {0, 2}};  // first three even
  std::vector<std::array<int, 10>> elements;
  std::map<std::pair<int, int>, int> middle;
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i)
        for (int p = 0; p < 6; ++p) {
          int c[3] = {i, j, k};
          std::array<int, 10> element{};
          element[0] = index(c[0], c[1], c[2]);
          ++c[paths[p][0]];
          element[1] = index(c[0], c[1], c[2]);
          ++c[paths[p][1]];
          element[2] = index(c[0], c[1], c[2]);
          element[3] = index(i + 1, j + 1, k + 1);
          if (p >= 3) std::swap(element[1], element[2]);
          if (order == 2) {
            for (int m = 0; m < 6; ++m) {
              const auto ends = std::minmax(element[edges[m][0]], element[edges[m][1]]);
              const auto [place, is_new] =
                  middle.try_emplace({ends.first, ends.second}, static_cast<int>(nodes.size()));
              if (is_new) nodes.push_back(0.5 * (nodes[ends.first] + nodes[ends.second]));
              element[4 + m] = place->second;
            }
          }
          elements.push_back(element);
        }
  mesh.nodes_m.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t i = 0; i < nodes.size(); ++i) mesh.nodes_m.row(static_cast<Eigen::Index>(i)) = nodes[i].transpose();
  mesh.elements.resize(static_cast<Eigen::Index>(elements.size()), order == 2 ? 10 : 4);
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (int k = 0; k < mesh.elements.cols(); ++k) mesh.elements(static_cast<Eigen::Index>(e), k) = elements[e][k];
  return mesh;
}

}  // namespace klang::test
