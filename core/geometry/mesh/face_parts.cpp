#include "core/geometry/mesh/face_parts.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace klang::mesh {

FaceParts face_parts(const TetMesh& mesh) {
  struct Face {
    std::array<int, 3> corners;
    int element;
    bool operator<(const Face& other) const { return corners < other.corners; }
  };
  std::vector<Face> faces;
  faces.reserve(4 * static_cast<std::size_t>(mesh.n_elements()));
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (const auto& face : kTetFaces) {
      std::array<int, 3> nodes{mesh.elements(e, face[0]), mesh.elements(e, face[1]), mesh.elements(e, face[2])};
      std::sort(nodes.begin(), nodes.end());
      faces.push_back({nodes, e});
    }
  }
  std::sort(faces.begin(), faces.end());

  std::vector<int> parent(static_cast<std::size_t>(mesh.n_elements()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&parent](int e) {
    while (parent[e] != e) e = parent[e] = parent[parent[e]];
    return e;
  };
  for (std::size_t k = 1; k < faces.size(); ++k) {
    if (faces[k].corners != faces[k - 1].corners) continue;
    const int a = root(faces[k].element), b = root(faces[k - 1].element);
    parent[std::max(a, b)] = std::min(a, b);
  }
  FaceParts parts;
  parts.part.assign(parent.size(), -1);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const int first = root(e);
    parts.part[e] = first == e ? parts.n_parts++ : parts.part[first];  // a root is the lowest number of its part
  }
  return parts;
}

}  // namespace klang::mesh
