#include "core/geometry/mesh/import_check.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"

namespace klang::mesh {
namespace {

std::string element_name(int e) { return "element " + std::to_string(e); }

void check_indices(const TetMesh& mesh, const std::string& name) {
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) {
      const int node = mesh.elements(e, c);
      if (node < 0 || node >= mesh.n_nodes())
        throw InputError(name, element_name(e) + ": node out of range", std::to_string(node),
                         "0 to " + std::to_string(mesh.n_nodes() - 1));
      const double largest = mesh.nodes_m.row(node).cwiseAbs().maxCoeff();
      if (!mesh.nodes_m.row(node).allFinite() || !(largest <= 1e9))
        throw InputError(name, element_name(e) + ": node " + std::to_string(node) + " is not finite", "",
                         "finite coordinates up to 1e9 m");
      for (Eigen::Index k = 0; k < c; ++k)
        if (mesh.elements(e, k) == node)
          throw InputError(name, element_name(e) + ": a node repeats", std::to_string(node), "distinct nodes");
    }
}

void turn_inverted(TetMesh& mesh, const std::string& name) {
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const Eigen::Vector3d p0 = mesh.nodes_m.row(mesh.elements(e, 0));
    Eigen::Matrix3d sides;
    for (int c = 0; c < 3; ++c) sides.col(c) = mesh.nodes_m.row(mesh.elements(e, c + 1)).transpose() - p0;
    double longest = 0.0;
    for (const auto& edge : kTetEdges)
      longest = std::max(
          longest, (mesh.nodes_m.row(mesh.elements(e, edge[0])) - mesh.nodes_m.row(mesh.elements(e, edge[1]))).norm());
    const double det = sides.determinant();
    if (!(std::abs(det) > 1e-12 * longest * longest * longest))
      throw InputError(name, element_name(e) + " has no volume", to_text(det / 6.0) + " m^3",
                       "above 1e-12 of its longest edge cubed");
    if (det > 0.0) continue;
    std::swap(mesh.elements(e, 1), mesh.elements(e, 2));
    if (mesh.order() == 2) {  // corners 1 and 2 exchanged: edges 01 and 02, and 13 and 23
      std::swap(mesh.elements(e, 4), mesh.elements(e, 6));
      std::swap(mesh.elements(e, 8), mesh.elements(e, 9));
    }
  }
}

void check_faces(const TetMesh& mesh, const std::string& name) {
  struct Face {
    std::array<int, 3> corners;
    int element;
    bool turned;  // seen from outside the element, corners run the other way round when sorted
  };
  std::vector<Face> faces;
  faces.reserve(static_cast<std::size_t>(mesh.n_elements()) * 4);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& face : kTetFaces) {
      Face f{{mesh.elements(e, face[0]), mesh.elements(e, face[1]), mesh.elements(e, face[2])}, e, false};
      const auto& [a, b, c] = f.corners;
      f.turned = (a > b) != (b > c) != (a > c);
      std::sort(f.corners.begin(), f.corners.end());
      faces.push_back(f);
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.element < b.element;
  });
  int bad = mesh.n_elements(), other = 0;
  for (std::size_t i = 2; i < faces.size(); ++i)
    if (faces[i].corners == faces[i - 2].corners) bad = std::min(bad, faces[i].element);
  if (bad < mesh.n_elements())
    throw InputError(name, element_name(bad) + " is the third on one face", "", "at most two elements per face");
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (faces[i].corners == faces[i - 1].corners && faces[i].turned == faces[i - 1].turned && faces[i].element < bad) {
      bad = faces[i].element;
      other = faces[i - 1].element;
    }
  if (bad < mesh.n_elements())
    throw InputError(name, element_name(bad) + " lies on the same side of a face as element " + std::to_string(other),
                     "", "elements that do not overlap");
}

void check_mid_nodes(const TetMesh& mesh, const std::string& name) {
  std::unordered_map<std::uint64_t, int> mid_of_edge;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int m = 0; m < 6; ++m) {
      const auto [low, high] = std::minmax(mesh.elements(e, kTetEdges[m][0]), mesh.elements(e, kTetEdges[m][1]));
      const auto key = static_cast<std::uint64_t>(low) << 32 | static_cast<std::uint32_t>(high);
      const auto [it, added] = mid_of_edge.try_emplace(key, mesh.elements(e, 4 + m));
      if (!added && it->second != mesh.elements(e, 4 + m))
        throw InputError(name,
                         element_name(e) + ": another mid-node than its neighbour's on the edge of nodes " +
                             std::to_string(low) + " and " + std::to_string(high),
                         std::to_string(mesh.elements(e, 4 + m)), std::to_string(it->second));
    }
  for (int e = 0; e < mesh.n_elements(); ++e)
    if (!(smallest_jacobian(mesh, e) > 0.0))
      throw InputError(name, element_name(e) + " is folded over: its mid-nodes lie too far off", "",
                       "a positive Jacobian everywhere");
}

void drop_unused(TetMesh& mesh) {
  std::vector<int> new_index(mesh.n_nodes(), -1);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) new_index[mesh.elements(e, c)] = 0;
  int n_nodes = 0;
  for (int& index : new_index)
    if (index == 0) index = n_nodes++;
  if (n_nodes == mesh.n_nodes()) return;
  Points nodes(n_nodes, 3);
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (new_index[i] >= 0) nodes.row(new_index[i]) = mesh.nodes_m.row(i);
  mesh.nodes_m = std::move(nodes);
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (Eigen::Index c = 0; c < mesh.elements.cols(); ++c) mesh.elements(e, c) = new_index[mesh.elements(e, c)];
  for (auto it = mesh.node_sets.begin(); it != mesh.node_sets.end();) {
    std::vector<int> kept;
    for (const int node : it->second)
      if (new_index[node] >= 0) kept.push_back(new_index[node]);
    it->second = std::move(kept);
    it = it->second.empty() ? mesh.node_sets.erase(it) : std::next(it);
  }
}

}  // namespace

TetMesh checked_import(TetMesh mesh, const std::string& name) {
  if (mesh.n_elements() == 0) throw InputError(name, "no tetrahedra");
  check_indices(mesh, name);
  turn_inverted(mesh, name);
  check_faces(mesh, name);
  if (mesh.order() == 2) check_mid_nodes(mesh, name);
  drop_unused(mesh);
  return mesh;
}

}  // namespace klang::mesh
