#include "core/physics/fracture/pattern/geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

constexpr double kLater = 1e-6;

struct Neighbours {
  std::vector<int> first, node;  // of node n: first[n] to first[n + 1]
  std::vector<double> length_m;
};

Neighbours neighbours_of(const mesh::TetMesh& mesh) {
  std::vector<std::pair<int, int>> edges;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& pair : mesh::kTetEdges) {
      const int a = mesh.elements(e, pair[0]), b = mesh.elements(e, pair[1]);
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  Neighbours out;
  out.first.assign(static_cast<std::size_t>(mesh.n_nodes()) + 1, 0);
  for (const auto& [a, b] : edges) {
    ++out.first[static_cast<std::size_t>(a) + 1];
    out.node.push_back(b);
    out.length_m.push_back((mesh.nodes_m.row(a) - mesh.nodes_m.row(b)).norm());
  }
  for (std::size_t n = 1; n < out.first.size(); ++n) out.first[n] += out.first[n - 1];
  return out;
}

}  // namespace

RegionFields geodesic_fields(const mesh::TetMesh& mesh, const std::vector<Seed>& seeds, double alpha) {
  const Neighbours graph = neighbours_of(mesh);
  const auto n = static_cast<Eigen::Index>(seeds.size());
  RegionFields fields{Eigen::MatrixXd::Constant(n, mesh.n_nodes(), HUGE_VAL), Eigen::MatrixXd(n, n)};
  Eigen::VectorXd k(n);
  using Entry = std::pair<double, int>;
  for (Eigen::Index i = 0; i < n; ++i) {
    k[i] = std::pow(seeds[i].density, alpha);
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
    auto distance = fields.values.row(i);
    for (int c = 0; c < 4; ++c) {
      const int node = mesh.elements(seeds[i].element, c);
      distance[node] = (mesh.nodes_m.row(node).transpose() - seeds[i].at_m).norm();
      queue.emplace(distance[node], node);
    }
    while (!queue.empty()) {
      const auto [far, node] = queue.top();
      queue.pop();
      if (far > distance[node]) continue;
      for (int j = graph.first[node]; j < graph.first[node + 1]; ++j) {
        const double longer = far + graph.length_m[j];
        if (longer < distance[graph.node[j]]) {
          distance[graph.node[j]] = longer;
          queue.emplace(longer, graph.node[j]);
        }
      }
    }
    // Paths that join are equally long from two seeds in all that lies beyond: the first seed has it.
    distance *= k[i] * (1.0 + kLater * static_cast<double>(i));
  }
  if (!fields.values.allFinite()) throw InputError("fracture", "the body's mesh consists of parts that no edge joins");
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) fields.slopes(i, j) = k[i] + k[j];
  return fields;
}

}  // namespace klang::fracture
