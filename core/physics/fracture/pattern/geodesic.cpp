#include "core/physics/fracture/pattern/geodesic.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

constexpr double kLater = 1e-6;

}  // namespace

GeodesicRegions::GeodesicRegions(const mesh::TetMesh& mesh, double alpha) : mesh_(mesh), alpha_(alpha) {
  std::vector<std::pair<int, int>> edges;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& pair : mesh::kTetEdges) {
      const int a = mesh.elements(e, pair[0]), b = mesh.elements(e, pair[1]);
      edges.emplace_back(a, b);
      edges.emplace_back(b, a);
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  first_.assign(static_cast<std::size_t>(mesh.n_nodes()) + 1, 0);
  for (const auto& [a, b] : edges) {
    ++first_[static_cast<std::size_t>(a) + 1];
    neighbour_.push_back(b);
    length_m_.push_back((mesh.nodes_m.row(a) - mesh.nodes_m.row(b)).norm());
  }
  for (std::size_t n = 1; n < first_.size(); ++n) first_[n] += first_[n - 1];
}

Eigen::VectorXd GeodesicRegions::distances_m(const Seed& seed) const {
  using Entry = std::pair<double, int>;
  Eigen::VectorXd distance = Eigen::VectorXd::Constant(mesh_.n_nodes(), HUGE_VAL);
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int c = 0; c < 4; ++c) {
    const int node = mesh_.elements(seed.element, c);
    distance[node] = (mesh_.nodes_m.row(node).transpose() - seed.at_m).norm();
    queue.emplace(distance[node], node);
  }
  while (!queue.empty()) {
    const auto [far, node] = queue.top();
    queue.pop();
    if (far > distance[node]) continue;
    for (int j = first_[node]; j < first_[node + 1]; ++j) {
      const double longer = far + length_m_[j];
      if (longer < distance[neighbour_[j]]) {
        distance[neighbour_[j]] = longer;
        queue.emplace(longer, neighbour_[j]);
      }
    }
  }
  if (!distance.allFinite()) throw InputError("fracture", "the body's mesh consists of parts that no edge joins");
  return distance;
}

RegionFields GeodesicRegions::fields(const std::vector<Seed>& seeds) {
  const auto n = static_cast<Eigen::Index>(seeds.size());
  RegionFields fields{Eigen::MatrixXd(n, mesh_.n_nodes()), Eigen::MatrixXd(n, n)};
  Eigen::VectorXd k(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    auto known = known_.find(seeds[i].element);
    if (known == known_.end()) known = known_.emplace(seeds[i].element, distances_m(seeds[i])).first;
    k[i] = std::pow(seeds[i].density, alpha_);
    // Paths that join are equally long from two seeds in all that lies beyond: the first seed has it.
    fields.values.row(i) = k[i] * (1.0 + kLater * static_cast<double>(i)) * known->second.transpose();
  }
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) fields.slopes(i, j) = k[i] + k[j];
  return fields;
}

}  // namespace klang::fracture
