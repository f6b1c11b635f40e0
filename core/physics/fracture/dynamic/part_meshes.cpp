#include "core/physics/fracture/dynamic/part_meshes.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture {
namespace {

using detail::at;
using Eigen::Vector3d;
using Edge = std::array<int, 2>;

constexpr double kOnEdge = 1e-9;  ///< of its length: nodes made on one lip are off the other's edge by round-off

/// Edges of faces that one element alone has.
std::set<Edge> free_edges(const CrackMesh& mesh) {
  std::map<std::array<int, 3>, int> faces;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    std::array<int, 4> nodes = mesh.nodes_of(e);
    std::sort(nodes.begin(), nodes.end());
    for (std::size_t k = 0; k < 4; ++k) ++faces[{nodes[k > 0 ? 0 : 1], nodes[k > 1 ? 1 : 2], nodes[k > 2 ? 2 : 3]}];
  }
  std::set<Edge> edges;
  for (const auto& [face, n] : faces)
    if (n == 1) edges.insert({Edge{face[0], face[1]}, Edge{face[0], face[2]}, Edge{face[1], face[2]}});
  return edges;
}

/// Where a place lies on an edge, from its first end; 0: it does not.
double share_on(const CrackMesh& mesh, const Edge& edge, const Vector3d& x) {
  const Vector3d &a = mesh.rest_m[at(edge[0])], &b = mesh.rest_m[at(edge[1])];
  if (((x - a.cwiseMin(b)).array() < -kOnEdge * (b - a).norm()).any() ||
      ((a.cwiseMax(b) - x).array() < -kOnEdge * (b - a).norm()).any())
    return 0.0;
  const double length_sq = (b - a).squaredNorm(), t = (x - a).dot(b - a) / length_sq;
  const bool is_inside = t > kOnEdge && t < 1.0 - kOnEdge;
  return is_inside && (x - a - t * (b - a)).squaredNorm() <= kOnEdge * kOnEdge * length_sq ? t : 0.0;
}

void match_lips(CrackMesh& mesh) {
  std::set<Edge> edges = free_edges(mesh);
  const int n = mesh.n_nodes();
  for (int node = 0; node < n; ++node) {
    const int old = mesh.made_of(node);
    if (old == node || mesh.rest_m[at(old)] == mesh.rest_m[at(node)]) continue;  // not made by a bisection
    const Vector3d x = mesh.rest_m[at(node)];
    std::vector<std::pair<Edge, double>> cuts;
    for (const Edge& edge : edges)
      if (const double t = share_on(mesh, edge, x); t > 0.0) cuts.push_back({edge, t});
    for (const auto& [edge, t] : cuts) {
      const int middle = mesh.bisect_edge(edge[0], edge[1], t);
      mesh.rest_m[at(middle)] = x;
      edges.erase(edge);
      for (const int element : mesh.star(middle))
        for (const int other : mesh.nodes_of(element))
          if (other != middle) edges.insert({std::min(other, middle), std::max(other, middle)});
    }
  }
}

}  // namespace

std::vector<mesh::TetMesh> part_meshes(CrackMesh mesh, bool lips_match) {
  if (lips_match) match_lips(mesh);
  int n_parts = 0;
  const std::vector<int> part_of = mesh.fragments(n_parts);
  std::vector<std::vector<int>> elements(at(n_parts));
  for (int e = 0; e < mesh.n_elements(); ++e) elements[at(part_of[at(e)])].push_back(e);
  std::vector<mesh::TetMesh> parts;
  std::vector<int> number(at(mesh.n_nodes()), -1);
  for (const std::vector<int>& own : elements) {
    std::vector<int> nodes;
    for (const int element : own)
      for (const int node : mesh.nodes_of(element))
        if (number[at(node)] < 0) {
          number[at(node)] = 0;
          nodes.push_back(node);
        }
    std::sort(nodes.begin(), nodes.end());
    mesh::TetMesh part;
    part.nodes_m.resize(static_cast<Eigen::Index>(nodes.size()), 3);
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      number[at(nodes[i])] = static_cast<int>(i);
      part.nodes_m.row(static_cast<Eigen::Index>(i)) = mesh.rest_m[at(nodes[i])].transpose();
    }
    part.elements.resize(static_cast<Eigen::Index>(own.size()), 4);
    for (std::size_t e = 0; e < own.size(); ++e)
      for (int c = 0; c < 4; ++c)
        part.elements(static_cast<Eigen::Index>(e), c) = number[at(mesh.nodes_of(own[e])[at(c)])];
    parts.push_back(std::move(part));
  }
  return parts;
}

}  // namespace klang::fracture
