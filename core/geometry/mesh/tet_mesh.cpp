#include "core/geometry/mesh/tet_mesh.hpp"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

#include "core/foundation/base/check.hpp"

namespace klang::mesh {
namespace {

struct Face {
  std::array<int, 3> corners_sorted;
  int element;
  int face;
};

std::vector<int> kept_nodes(const std::vector<int>& nodes, const std::vector<int>& new_index) {
  std::vector<int> kept;
  for (const int node : nodes)
    if (new_index[node] >= 0) kept.push_back(new_index[node]);
  return kept;
}

}  // namespace

SurfaceMesh boundary_surface(const TetMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(mesh.n_elements()) * 4);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int f = 0; f < 4; ++f) {
      std::array<int, 3> corners;
      for (int c = 0; c < 3; ++c) corners[c] = mesh.elements(e, kTetFaces[f][c]);
      std::sort(corners.begin(), corners.end());
      faces.push_back({corners, e, f});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.corners_sorted != b.corners_sorted ? a.corners_sorted < b.corners_sorted : a.element < b.element;
  });
  std::vector<Face> single;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].corners_sorted == faces[i].corners_sorted) ++end;
    if (end == i + 1) single.push_back(faces[i]);
    i = end;
  }
  std::sort(single.begin(), single.end(), [](const Face& a, const Face& b) {
    return a.element != b.element ? a.element < b.element : a.face < b.face;
  });

  SurfaceMesh surface;
  surface.vertices_m = mesh.nodes_m;
  const bool quadratic = mesh.order() == 2;
  surface.triangles.resize(static_cast<Eigen::Index>(single.size()), quadratic ? 6 : 3);
  for (std::size_t i = 0; i < single.size(); ++i) {
    const auto& corner = kTetFaces[single[i].face];
    for (int c = 0; c < 3; ++c) {
      surface.triangles(i, c) = mesh.elements(single[i].element, corner[c]);
      if (quadratic)
        surface.triangles(i, 3 + c) = mesh.elements(single[i].element, tet_mid_column(corner[c], corner[(c + 1) % 3]));
    }
  }
  return surface;
}

TetMesh to_linear(const TetMesh& mesh) {
  if (mesh.order() == 1) return mesh;
  std::vector<int> new_index(mesh.n_nodes(), -1);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int c = 0; c < 4; ++c) new_index[mesh.elements(e, c)] = 0;
  int n_nodes = 0;
  for (int& index : new_index)
    if (index == 0) index = n_nodes++;

  TetMesh linear;
  linear.nodes_m.resize(n_nodes, 3);
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (new_index[i] >= 0) linear.nodes_m.row(new_index[i]) = mesh.nodes_m.row(i);
  linear.elements.resize(mesh.n_elements(), 4);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int c = 0; c < 4; ++c) linear.elements(e, c) = new_index[mesh.elements(e, c)];
  for (const auto& [name, nodes] : mesh.node_sets) linear.node_sets[name] = kept_nodes(nodes, new_index);
  return linear;
}

TetMesh to_quadratic(const TetMesh& mesh) {
  if (mesh.order() == 2) return mesh;
  TetMesh quadratic;
  quadratic.elements.resize(mesh.n_elements(), 10);
  std::unordered_map<std::uint64_t, int> mid_of_edge;
  mid_of_edge.reserve(static_cast<std::size_t>(mesh.n_elements()) * 2);
  std::vector<std::array<int, 2>> ends;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (int c = 0; c < 4; ++c) quadratic.elements(e, c) = mesh.elements(e, c);
    for (int m = 0; m < 6; ++m) {
      const int a = std::min(mesh.elements(e, kTetEdges[m][0]), mesh.elements(e, kTetEdges[m][1]));
      const int b = std::max(mesh.elements(e, kTetEdges[m][0]), mesh.elements(e, kTetEdges[m][1]));
      const auto key = static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
      const auto [it, added] = mid_of_edge.try_emplace(key, mesh.n_nodes() + static_cast<int>(ends.size()));
      if (added) ends.push_back({a, b});
      quadratic.elements(e, 4 + m) = it->second;
    }
  }
  quadratic.nodes_m.resize(mesh.n_nodes() + static_cast<Eigen::Index>(ends.size()), 3);
  quadratic.nodes_m.topRows(mesh.n_nodes()) = mesh.nodes_m;
  for (std::size_t i = 0; i < ends.size(); ++i)
    quadratic.nodes_m.row(mesh.n_nodes() + static_cast<Eigen::Index>(i)) =
        0.5 * (mesh.nodes_m.row(ends[i][0]) + mesh.nodes_m.row(ends[i][1]));

  // A mid-node belongs to a named set when it lies between two of its corners on one face of the boundary
  // that is wholly in the set; an edge through the inside of a thin body does not.
  quadratic.node_sets = mesh.node_sets;
  if (!mesh.node_sets.empty()) {
    const SurfaceMesh surface = boundary_surface(mesh);
    for (auto& [name, nodes] : quadratic.node_sets) {
      std::vector<char> in_set(mesh.n_nodes(), 0);
      for (const int node : nodes) in_set[node] = 1;
      std::vector<char> mid_in_set(ends.size(), 0);
      for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
        const auto corner = surface.triangles.row(t);
        if (!in_set[corner[0]] || !in_set[corner[1]] || !in_set[corner[2]]) continue;
        for (int c = 0; c < 3; ++c) {
          const int a = std::min(corner[c], corner[(c + 1) % 3]);
          const int b = std::max(corner[c], corner[(c + 1) % 3]);
          const auto it = mid_of_edge.find(static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b));
          KLANG_CHECK(it != mid_of_edge.end(), "edge of the boundary");
          mid_in_set[it->second - mesh.n_nodes()] = 1;
        }
      }
      for (std::size_t i = 0; i < ends.size(); ++i)
        if (mid_in_set[i]) nodes.push_back(mesh.n_nodes() + static_cast<int>(i));
    }
  }
  return quadratic;
}

}  // namespace klang::mesh
