#include "core/physics/solid/assembly.hpp"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/same_pattern.hpp"
#include "core/physics/solid/detail/element.hpp"

namespace klang::solid {
namespace {

constexpr int kChunk = 32;        // elements that one task adds in order
constexpr int kNodeGrain = 1024;  // nodes a task builds the pattern of

void check_mesh(const mesh::TetMesh& mesh) {
  if (mesh.elements.cols() != 4 && mesh.elements.cols() != 10) {
    throw InputError("mesh", "elements must have 4 or 10 nodes", std::to_string(mesh.elements.cols()), "4 or 10");
  }
  if (mesh.n_elements() == 0) throw InputError("mesh", "has no elements");
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const auto row = mesh.elements.row(e);
    if (row.minCoeff() < 0 || row.maxCoeff() >= mesh.n_nodes()) {
      throw InputError("mesh", "element " + std::to_string(e) + " names a node that is not there");
    }
  }
}

// Elements at each node, in order of their numbers.
struct NodeElements {
  std::vector<int> start;
  std::vector<int> element;
};

NodeElements elements_at_nodes(const mesh::TetMesh& mesh) {
  NodeElements result;
  result.start.assign(mesh.n_nodes() + 1, 0);
  for (Eigen::Index k = 0; k < mesh.elements.size(); ++k) ++result.start[mesh.elements.data()[k] + 1];
  for (int i = 0; i < mesh.n_nodes(); ++i) result.start[i + 1] += result.start[i];
  result.element.resize(result.start.back());
  std::vector<int> next(result.start.begin(), result.start.end() - 1);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (int k = 0; k < mesh.elements.cols(); ++k) result.element[next[mesh.elements(e, k)]++] = e;
  }
  return result;
}

// Lower triangle of the graph of free nodes: rows >= column, ascending, the diagonal first.
struct NodePattern {
  std::vector<std::int64_t> start;
  std::vector<int> row;
};

NodePattern node_pattern(const mesh::TetMesh& mesh, const NodeElements& at, const std::vector<int>& free_nodes,
                         const std::vector<int>& free_index) {
  const std::size_t n = free_nodes.size();
  const std::size_t n_ranges = (n + kNodeGrain - 1) / kNodeGrain;
  std::vector<std::vector<int>> range_rows(n_ranges);
  NodePattern pattern;
  pattern.start.assign(n + 1, 0);
  parallel_for(n, kNodeGrain, [&](std::size_t begin, std::size_t end) {
    auto& rows = range_rows[begin / kNodeGrain];
    std::vector<int> near;
    for (std::size_t j = begin; j < end; ++j) {
      near.clear();
      const int node = free_nodes[j];
      for (int k = at.start[node]; k < at.start[node + 1]; ++k) {
        for (int c = 0; c < mesh.elements.cols(); ++c) {
          const int i = free_index[mesh.elements(at.element[k], c)];
          if (i >= static_cast<int>(j)) near.push_back(i);
        }
      }
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      pattern.start[j + 1] = static_cast<std::int64_t>(near.size());
      rows.insert(rows.end(), near.begin(), near.end());
    }
  });
  for (std::size_t j = 0; j < n; ++j) pattern.start[j + 1] += pattern.start[j];
  pattern.row.reserve(pattern.start.back());
  for (const auto& rows : range_rows) pattern.row.insert(pattern.row.end(), rows.begin(), rows.end());
  return pattern;
}

// First place of column 3 j + b. Its rows are 3 j + b .. 3 j + 2, then three for each further node.
std::int64_t column_start(const NodePattern& pattern, std::size_t j, int b) {
  const std::int64_t further = pattern.start[j + 1] - pattern.start[j] - 1;
  return 9 * (pattern.start[j] - static_cast<std::int64_t>(j)) + 6 * static_cast<std::int64_t>(j) + b * 3 * further +
         (b == 0   ? 0
          : b == 1 ? 3
                   : 5);
}

SparseMatrix zero_matrix(const NodePattern& pattern) {
  const std::size_t n = pattern.start.size() - 1;
  const std::int64_t n_entries =
      n == 0 ? 0 : 9 * (pattern.start[n] - static_cast<std::int64_t>(n)) + 6 * static_cast<std::int64_t>(n);
  if (n_entries > std::numeric_limits<int>::max()) {
    throw InputError("mesh", "too large for 32-bit sparse matrices", std::to_string(n) + " nodes");
  }
  SparseMatrix matrix = la::room_for(static_cast<Eigen::Index>(3 * n), static_cast<Eigen::Index>(3 * n),
                                     static_cast<Eigen::Index>(n_entries));
  int* outer = matrix.outerIndexPtr();
  int* inner = matrix.innerIndexPtr();
  double* values = matrix.valuePtr();
  outer[3 * n] = static_cast<int>(n_entries);
  parallel_for(n, kNodeGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t j = begin; j < end; ++j) {
      for (int b = 0; b < 3; ++b) {
        std::int64_t place = column_start(pattern, j, b);
        outer[3 * j + b] = static_cast<int>(place);
        for (int a = b; a < 3; ++a) inner[place++] = static_cast<int>(3 * j) + a;
        for (std::int64_t p = pattern.start[j] + 1; p < pattern.start[j + 1]; ++p) {
          for (int a = 0; a < 3; ++a) inner[place++] = 3 * pattern.row[p] + a;
        }
      }
      std::fill(values + column_start(pattern, j, 0),
                values + (j + 1 < n ? column_start(pattern, j + 1, 0) : n_entries), 0.0);
    }
  });
  return matrix;
}

// Chunks of consecutive elements, coloured so that chunks of one colour share no node: they may be added at
// the same time, and every entry receives its terms in the same order on any number of threads.
std::vector<std::vector<int>> coloured_chunks(const mesh::TetMesh& mesh) {
  constexpr int kColours = 64;
  const int n_chunks = (mesh.n_elements() + kChunk - 1) / kChunk;
  std::vector<std::uint64_t> used(mesh.n_nodes(), 0);
  std::vector<std::vector<int>> colours;
  std::vector<std::vector<int>> alone;  // chunks for which 64 colours do not suffice
  for (int chunk = 0; chunk < n_chunks; ++chunk) {
    const int first = chunk * kChunk, last = std::min(first + kChunk, mesh.n_elements());
    std::uint64_t taken = 0;
    for (int e = first; e < last; ++e) {
      for (int k = 0; k < mesh.elements.cols(); ++k) taken |= used[mesh.elements(e, k)];
    }
    int colour = 0;
    while (colour < kColours && (taken >> colour & 1) != 0) ++colour;
    if (colour == kColours) {
      alone.push_back({chunk});
      continue;
    }
    for (int e = first; e < last; ++e) {
      for (int k = 0; k < mesh.elements.cols(); ++k) used[mesh.elements(e, k)] |= std::uint64_t{1} << colour;
    }
    if (colour >= static_cast<int>(colours.size())) colours.resize(colour + 1);
    colours[colour].push_back(chunk);
  }
  colours.insert(colours.end(), alone.begin(), alone.end());
  return colours;
}

void lump(int n_nodes, detail::ElementIntegrals& element) {
  // The consistent diagonal scaled to the element's mass (Hinton, Rock, Zienkiewicz 1976): row sums would
  // give the corners of a quadratic element negative mass. For linear elements it is volume / 4.
  double trace = 0;
  for (int i = 0; i < n_nodes; ++i) trace += element.mass[i][i];
  for (int i = 0; i < n_nodes; ++i) {
    for (int j = 0; j < n_nodes; ++j) {
      element.mass[i][j] = i == j ? element.mass[i][i] * element.volume_m3 / trace : 0.0;
    }
  }
}

class Adder {
 public:
  Adder(const mesh::TetMesh& mesh, const NodePattern& pattern, const std::vector<int>& free_index,
        AssembledSolid& solid)
      : mesh_(mesh),
        pattern_(pattern),
        free_index_(free_index),
        lambda_(solid.stiffness_lambda.valuePtr()),
        mu_(solid.stiffness_mu.valuePtr()),
        mass_(solid.mass_unit_density.valuePtr()) {}

  void add(int e, const detail::ElementIntegrals& element) const {
    const int n_nodes = static_cast<int>(mesh_.elements.cols());
    for (int c = 0; c < n_nodes; ++c) {
      const int j = free_index_[mesh_.elements(e, c)];
      if (j < 0) continue;
      const auto begin = pattern_.row.begin() + pattern_.start[j];
      const auto end = pattern_.row.begin() + pattern_.start[j + 1];
      for (int r = 0; r < n_nodes; ++r) {
        const int i = free_index_[mesh_.elements(e, r)];
        if (i < j) continue;
        add_block(j, std::lower_bound(begin, end, i) - begin, r, c, element);
      }
    }
  }

 private:
  void add_block(int j, std::int64_t position, int r, int c, const detail::ElementIntegrals& element) const {
    const auto& h = element.gradient_products;
    const double trace = h[3 * r][3 * c] + h[3 * r + 1][3 * c + 1] + h[3 * r + 2][3 * c + 2];
    for (int b = 0; b < 3; ++b) {
      const std::int64_t column = column_start(pattern_, j, b);
      const std::int64_t place = position == 0 ? column - b : column + (3 - b) + 3 * (position - 1);
      for (int a = position == 0 ? b : 0; a < 3; ++a) {
        lambda_[place + a] += h[3 * r + a][3 * c + b];
        mu_[place + a] += h[3 * r + b][3 * c + a] + (a == b ? trace : 0.0);
      }
      mass_[place + b] += element.mass[r][c];
    }
  }

  const mesh::TetMesh& mesh_;
  const NodePattern& pattern_;
  const std::vector<int>& free_index_;
  double* lambda_;
  double* mu_;
  double* mass_;
};

}  // namespace

AssembledSolid assemble(const mesh::TetMesh& mesh, const Support& support, MassKind mass) {
  check_mesh(mesh);
  const NodeElements at = elements_at_nodes(mesh);
  std::vector<char> held(mesh.n_nodes(), 0);
  for (const int node : held_nodes(support, mesh)) held[node] = 1;

  AssembledSolid solid;
  solid.n_mesh_nodes = mesh.n_nodes();
  std::vector<int> free_index(mesh.n_nodes(), -1);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    if (held[i] || at.start[i] == at.start[i + 1]) continue;  // a node of no element has neither mass nor stiffness
    free_index[i] = static_cast<int>(solid.free_nodes.size());
    solid.free_nodes.push_back(i);
  }
  if (solid.free_nodes.empty()) throw InputError("support", "holds every node of the mesh", support.where);

  const NodePattern pattern = node_pattern(mesh, at, solid.free_nodes, free_index);
  solid.stiffness_lambda = zero_matrix(pattern);
  solid.stiffness_mu = zero_matrix(pattern);
  solid.mass_unit_density = zero_matrix(pattern);

  const Adder adder(mesh, pattern, free_index, solid);
  std::atomic<int> first_bad = std::numeric_limits<int>::max();
  for (const auto& chunks : coloured_chunks(mesh)) {
    parallel_for(chunks.size(), 1, [&](std::size_t begin, std::size_t end) {
      detail::ElementIntegrals element;
      for (std::size_t k = begin; k < end; ++k) {
        const int first = chunks[k] * kChunk, last = std::min(first + kChunk, mesh.n_elements());
        for (int e = first; e < last; ++e) {
          if (!detail::integrate_element(mesh, e, element)) {
            int seen = first_bad.load();
            while (e < seen && !first_bad.compare_exchange_weak(seen, e)) {
            }
            continue;
          }
          if (mass == MassKind::kLumped) lump(static_cast<int>(mesh.elements.cols()), element);
          adder.add(e, element);
        }
      }
    });
  }
  if (first_bad.load() != std::numeric_limits<int>::max()) {
    throw InputError("mesh", "element " + std::to_string(first_bad.load()) + " is flat, inside out or not finite", {},
                     "a positive Jacobian determinant at every integration point");
  }
  return solid;
}

SparseMatrix stiffness(const AssembledSolid& solid, double lame_lambda_pa, double lame_mu_pa) {
  KLANG_CHECK(solid.stiffness_lambda.nonZeros() == solid.stiffness_mu.nonZeros(), "one pattern for both");
  SparseMatrix result = la::same_pattern(solid.stiffness_mu);
  const double *lambda_values = solid.stiffness_lambda.valuePtr(), *mu_values = solid.stiffness_mu.valuePtr();
  double* values = result.valuePtr();
  parallel_for(static_cast<std::size_t>(result.nonZeros()), 1 << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) values[k] = lame_lambda_pa * lambda_values[k] + lame_mu_pa * mu_values[k];
  });
  return result;
}

}  // namespace klang::solid
