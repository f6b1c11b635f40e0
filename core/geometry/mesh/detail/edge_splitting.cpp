#include "core/geometry/mesh/detail/edge_splitting.hpp"

#include <algorithm>
#include <map>
#include <vector>

#include "core/foundation/base/check.hpp"

namespace klang::mesh::detail {
namespace {

using Edge = std::pair<int, int>;  // lower node first

struct LongEdge {
  double length_m = 0.0;
  Edge edge;
};

/// One pass: splits all edges above the limit that are the longest of each of their tetrahedra. False: there was none.
bool split_once(TetMesh& mesh, double max_edge_m) {
  const auto length = [&mesh](int a, int b) { return (mesh.nodes_m.row(a) - mesh.nodes_m.row(b)).norm(); };
  // Equal lengths are told apart by the nodes' numbers, so that neighbours agree on the longest.
  const auto is_less = [](const LongEdge& a, const LongEdge& b) {
    return a.length_m != b.length_m ? a.length_m < b.length_m : a.edge < b.edge;
  };
  std::vector<LongEdge> longest(static_cast<std::size_t>(mesh.n_elements()));
  std::map<Edge, std::vector<int>> elements_of;  // of the edges above the limit
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& local : kTetEdges) {
      const Edge edge = std::minmax({mesh.elements(e, local[0]), mesh.elements(e, local[1])});
      const LongEdge here{length(edge.first, edge.second), edge};
      if (here.length_m > max_edge_m) elements_of[edge].push_back(e);
      if (is_less(longest[static_cast<std::size_t>(e)], here)) longest[static_cast<std::size_t>(e)] = here;
    }
  if (elements_of.empty()) return false;
  std::vector<Eigen::RowVector3d> nodes;
  std::vector<Eigen::RowVector4i> added;
  for (const auto& entry : elements_of) {
    const Edge& edge = entry.first;
    const std::vector<int>& around = entry.second;
    const bool is_longest = std::all_of(around.begin(), around.end(),
                                        [&](int e) { return longest[static_cast<std::size_t>(e)].edge == edge; });
    if (!is_longest) continue;
    const int middle = mesh.n_nodes() + static_cast<int>(nodes.size());
    nodes.push_back(0.5 * (mesh.nodes_m.row(edge.first) + mesh.nodes_m.row(edge.second)));
    for (const int e : around) {
      Eigen::RowVector4i other = mesh.elements.row(e);
      for (int c = 0; c < 4; ++c) {
        if (mesh.elements(e, c) == edge.first) other[c] = middle;
      }
      for (int c = 0; c < 4; ++c) {
        if (mesh.elements(e, c) == edge.second) mesh.elements(e, c) = middle;
      }
      added.push_back(other);
    }
  }
  KLANG_CHECK(!nodes.empty(), "the longest edge of all is the longest of its tetrahedra");
  const Eigen::Index n_nodes = mesh.n_nodes(), n_elements = mesh.n_elements();
  mesh.nodes_m.conservativeResize(n_nodes + static_cast<Eigen::Index>(nodes.size()), Eigen::NoChange);
  for (std::size_t i = 0; i < nodes.size(); ++i) mesh.nodes_m.row(n_nodes + static_cast<Eigen::Index>(i)) = nodes[i];
  mesh.elements.conservativeResize(n_elements + static_cast<Eigen::Index>(added.size()), Eigen::NoChange);
  for (std::size_t i = 0; i < added.size(); ++i)
    mesh.elements.row(n_elements + static_cast<Eigen::Index>(i)) = added[i];
  return true;
}

}  // namespace

void split_long_edges(TetMesh& mesh, double max_edge_m) {
  KLANG_CHECK(mesh.order() == 1 && max_edge_m > 0.0, "split_long_edges: linear elements and a length");
  while (split_once(mesh, max_edge_m)) {
  }
}

}  // namespace klang::mesh::detail
