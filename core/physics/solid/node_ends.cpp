#include "core/physics/solid/node_ends.hpp"

#include <vector>

namespace klang::solid {

la::NodeEnds node_ends(const mesh::TetMesh& mesh, const AssembledSolid& assembled) {
  std::vector<int> free_index(static_cast<std::size_t>(mesh.n_nodes()), -1);
  la::NodeEnds ends(assembled.free_nodes.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const int own = static_cast<int>(i);
    free_index[assembled.free_nodes[i]] = own;
    ends[i] = {own, own};
  }
  if (mesh.order() == 1) return ends;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (std::size_t k = 0; k < mesh::kTetEdges.size(); ++k) {
      const int own = free_index[mesh.elements(e, 4 + static_cast<int>(k))];
      if (own < 0) continue;
      ends[own] = {free_index[mesh.elements(e, mesh::kTetEdges[k][0])],
                   free_index[mesh.elements(e, mesh::kTetEdges[k][1])]};
    }
  return ends;
}

}  // namespace klang::solid
