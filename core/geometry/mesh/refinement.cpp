#include "core/geometry/mesh/refinement.hpp"

#include <algorithm>

#include "core/foundation/base/check.hpp"

namespace klang::mesh {

TetMesh refined(const TetMesh& mesh) {
  KLANG_CHECK(mesh.order() == 1, "refined: the mesh is not of straight elements");
  TetMesh plain;
  plain.nodes_m = mesh.nodes_m;
  plain.elements = mesh.elements;
  const TetMesh with_middles = to_quadratic(plain);
  // The octahedron's diagonals join middles of opposite edges; the other four go around each.
  constexpr std::array<std::array<int, 6>, 3> kAround{{{4, 9, 6, 5, 8, 7}, {5, 7, 6, 4, 8, 9}, {6, 8, 4, 5, 9, 7}}};
  constexpr std::array<std::array<int, 4>, 4> kCorners{{{0, 4, 6, 7}, {4, 1, 5, 8}, {6, 5, 2, 9}, {7, 8, 9, 3}}};
  TetMesh fine;
  fine.nodes_m = with_middles.nodes_m;
  fine.elements.resize(8 * static_cast<Eigen::Index>(mesh.n_elements()), 4);
  Eigen::Index row = 0;
  for (Eigen::Index e = 0; e < mesh.n_elements(); ++e) {
    const auto nodes = with_middles.elements.row(e);
    const auto place = [&](int node) -> Eigen::Vector3d { return fine.nodes_m.row(node).transpose(); };
    const auto add = [&](std::array<int, 4> element) {
      const Eigen::Vector3d a = place(element[0]);
      if ((place(element[1]) - a).cross(place(element[2]) - a).dot(place(element[3]) - a) < 0.0)
        std::swap(element[2], element[3]);
      for (int c = 0; c < 4; ++c) fine.elements(row, c) = element[static_cast<std::size_t>(c)];
      ++row;
    };
    for (const auto& corner : kCorners) add({nodes[corner[0]], nodes[corner[1]], nodes[corner[2]], nodes[corner[3]]});
    const auto length = [&](const std::array<int, 6>& around) {
      return (place(nodes[around[0]]) - place(nodes[around[1]])).norm();
    };
    const auto& best = *std::min_element(kAround.begin(), kAround.end(),
                                         [&](const auto& a, const auto& b) { return length(a) < length(b); });
    for (std::size_t k = 0; k < 4; ++k)
      add({nodes[best[0]], nodes[best[1]], nodes[best[2 + k]], nodes[best[2 + (k + 1) % 4]]});
  }
  return fine;
}

}  // namespace klang::mesh
