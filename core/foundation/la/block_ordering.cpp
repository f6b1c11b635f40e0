#include "core/foundation/la/block_ordering.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/la/detail/cholmod_session.hpp"

namespace klang::la {
namespace {

// Of the factor. METIS takes as long as a tenth of these and saves at most a half.
constexpr double kMetisFromOperations = 3e9;

// METIS draws from the C library's rand(), which it seeds at each call: two at a time would take each other's numbers, and
// the order, and with it the last bits of every solution, would change from run to run.
std::mutex metis_mutex;

// Lower triangle of a graph, by columns.
struct Graph {
  std::vector<int> start{0}, row;

  int n() const { return static_cast<int>(start.size()) - 1; }
  cholmod_sparse view() {
    cholmod_sparse graph{};
    graph.nrow = graph.ncol = static_cast<std::size_t>(n());
    graph.nzmax = row.size();
    graph.p = start.data();
    graph.i = row.data();
    graph.stype = -1;
    graph.itype = CHOLMOD_INT;
    graph.xtype = CHOLMOD_PATTERN;
    graph.sorted = 1;
    graph.packed = 1;
    return graph;
  }
};

// The nodes of which `number` is not negative, under these numbers, which ascend.
Graph graph_of(const SparseMatrix& lower, const std::vector<int>& number) {
  Graph graph;
  graph.row.reserve(static_cast<std::size_t>(lower.nonZeros() / 8));
  const int* outer = lower.outerIndexPtr();
  for (std::size_t j = 0; j < number.size(); ++j) {
    if (number[j] < 0) continue;
    // Column 3 j holds every node below: each third row of it, after the diagonal block.
    for (int k = outer[3 * j]; k < outer[3 * j + 1]; ++k) {
      const int i = number[lower.innerIndexPtr()[k] / 3];
      if (i < 0) continue;
      if (static_cast<int>(graph.row.size()) == graph.start.back() || graph.row.back() != i) graph.row.push_back(i);
    }
    graph.start.push_back(static_cast<int>(graph.row.size()));
  }
  return graph;
}

// An order of a graph and what its factor would take.
struct Trial {
  std::vector<int> order;
  double n_operations = 0;
};

Trial tried(Graph& graph, int method) {
  detail::CholmodSession session;
  cholmod_common& common = session.common;
  common.nmethods = 1;
  common.method[0].ordering = method;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  const cholmod_sparse view = graph.view();
  Trial trial;
  cholmod_factor* factor = cholmod_analyze(const_cast<cholmod_sparse*>(&view), &common);
  if (factor == nullptr) return trial;
  const int* order = static_cast<const int*>(factor->Perm);
  trial.order.assign(order, order + graph.n());
  trial.n_operations = common.fl;
  cholmod_free_factor(&factor, &common);
  return trial;
}

std::vector<int> corner_order(Graph& graph, double dofs_per_corner) {
  Trial best = tried(graph, CHOLMOD_AMD);
  if (best.order.empty()) {
    best.order.resize(static_cast<std::size_t>(graph.n()));
    std::iota(best.order.begin(), best.order.end(), 0);
    return best.order;
  }
  if (best.n_operations * std::pow(dofs_per_corner, 3) < kMetisFromOperations) return best.order;
  const std::lock_guard lock(metis_mutex);
  Trial metis = tried(graph, CHOLMOD_METIS);
  return !metis.order.empty() && metis.n_operations < best.n_operations ? metis.order : best.order;
}

std::vector<int> dofs_of(const std::vector<int>& nodes) {
  std::vector<int> order;
  order.reserve(3 * nodes.size());
  for (const int node : nodes)
    for (int a = 0; a < 3; ++a) order.push_back(3 * node + a);
  return order;
}

int n_nodes_of(const SparseMatrix& lower) {
  const int n_nodes = static_cast<int>(lower.rows() / 3);
  KLANG_CHECK(lower.rows() == 3 * n_nodes, "3 x 3 node blocks");
  return n_nodes;
}

}  // namespace

std::vector<int> block_ordering(const SparseMatrix& lower) {
  NodeEnds ends(static_cast<std::size_t>(n_nodes_of(lower)));
  for (std::size_t i = 0; i < ends.size(); ++i) ends[i] = {static_cast<int>(i), static_cast<int>(i)};
  return block_ordering(lower, ends);
}

std::vector<int> block_ordering(const SparseMatrix& lower, const NodeEnds& ends) {
  const int n_nodes = n_nodes_of(lower);
  KLANG_CHECK(static_cast<int>(ends.size()) == n_nodes, "ends of each node");
  std::vector<int> number(ends.size(), -1), corner;
  for (int i = 0; i < n_nodes; ++i) {
    if (ends[i][0] != i) continue;
    number[i] = static_cast<int>(corner.size());
    corner.push_back(i);
  }
  Graph graph = graph_of(lower, number);
  std::vector<int> rank(ends.size(), n_nodes), sorted(ends.size());
  if (!corner.empty()) {
    const std::vector<int> order = corner_order(graph, static_cast<double>(lower.rows()) / graph.n());
    for (int k = 0; k < graph.n(); ++k) rank[corner[order[k]]] = k;
  }
  // First by the end that comes first (a corner's own place, before its mid-nodes), then by the other end.
  const auto place = [&](int node) {
    const auto [a, b] = ends[node];
    if (a == node) return std::array{rank[node], -1};
    const int ra = a < 0 ? n_nodes : rank[a], rb = b < 0 ? n_nodes : rank[b];
    return std::array{std::min(ra, rb), std::max(ra, rb)};
  };
  std::iota(sorted.begin(), sorted.end(), 0);
  std::vector<std::array<int, 2>> key(ends.size());
  for (int i = 0; i < n_nodes; ++i) key[i] = place(i);
  std::stable_sort(sorted.begin(), sorted.end(), [&](int a, int b) { return key[a] < key[b]; });
  return dofs_of(sorted);
}

}  // namespace klang::la
