#include "core/geometry/shapes/detail/block_mesh.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <set>
#include <unordered_map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::mesh::detail {
namespace {

/// Finds points that were seen before, within a distance, by hashing them into cells four times that wide.
class PointGlue {
 public:
  explicit PointGlue(double tolerance_m) : tolerance_m_(tolerance_m), cell_m_(4.0 * tolerance_m) {}

  int find(const Eigen::Vector3d& point, const std::vector<Eigen::Vector3d>& points) const {
    std::array<std::array<std::int64_t, 2>, 3> candidates;
    for (int axis = 0; axis < 3; ++axis) {
      const double scaled = point[axis] / cell_m_;
      candidates[axis] = {static_cast<std::int64_t>(std::floor(scaled - 0.25)),
                          static_cast<std::int64_t>(std::floor(scaled + 0.25))};
    }
    for (int corner = 0; corner < 8; ++corner) {
      bool repeated = false;
      std::array<std::int64_t, 3> key;
      for (int axis = 0; axis < 3; ++axis) {
        const int side = corner >> axis & 1;
        repeated |= side == 1 && candidates[axis][0] == candidates[axis][1];
        key[axis] = candidates[axis][side];
      }
      if (repeated) continue;
      const auto range = cells_.equal_range(hash(key));
      for (auto it = range.first; it != range.second; ++it)
        if ((points[it->second] - point).norm() <= tolerance_m_) return it->second;
    }
    return -1;
  }

  void insert(const Eigen::Vector3d& point, int index) {
    std::array<std::int64_t, 3> key;
    for (int axis = 0; axis < 3; ++axis) key[axis] = static_cast<std::int64_t>(std::floor(point[axis] / cell_m_));
    cells_.emplace(hash(key), index);
  }

 private:
  static std::uint64_t hash(const std::array<std::int64_t, 3>& key) {
    std::uint64_t h = 0x9e3779b97f4a7c15ULL;
    for (const std::int64_t k : key) {
      h ^= static_cast<std::uint64_t>(k);
      h *= 0xff51afd7ed558ccdULL;
      h ^= h >> 32;
    }
    return h;
  }

  double tolerance_m_;
  double cell_m_;
  std::unordered_multimap<std::uint64_t, int> cells_;
};

struct Path {
  std::array<int, 3> axes;
  bool even;
};
constexpr std::array<Path, 6> kPaths{{{{0, 1, 2}, true},
                                      {{1, 2, 0}, true},
                                      {{2, 0, 1}, true},
                                      {{1, 0, 2}, false},
                                      {{0, 2, 1}, false},
                                      {{2, 1, 0}, false}}};

bool right_handed(const Block& block) {
  const double h = 1e-3;
  const Eigen::Vector3d at = block.map(0.5, 0.5, 0.5);
  const Eigen::Vector3d du = block.map(0.5 + h, 0.5, 0.5) - at;
  const Eigen::Vector3d dv = block.map(0.5, 0.5 + h, 0.5) - at;
  const Eigen::Vector3d dw = block.map(0.5, 0.5, 0.5 + h) - at;
  return du.dot(dv.cross(dw)) > 0.0;
}

}  // namespace

void check_element_count(double n_elements) {
  if (!(n_elements <= 2e7))
    throw InputError("mesh", "too many elements", to_text(n_elements), "up to 2e7: a larger edge length");
}

double Segment::at(double u) const {
  if (grading == 0.0) return from + (to - from) * u;
  const auto border = [this](double s) { return s + grading * std::sin(kPi * s) / kPi; };
  const double cell = std::min(std::floor(u * n + 1e-9), n - 1.0), part = u * n - cell;
  return from + (to - from) * ((1.0 - part) * border(cell / n) + part * border((cell + 1.0) / n));
}

std::vector<Segment> mirrored_segments(int n, double half_length_m, const std::string& low_face,
                                       const std::string& high_face, double grading) {
  if (n % 2 != 0) return {{n, -half_length_m, half_length_m, low_face, high_face}};
  return {{n / 2, 0.0, -half_length_m, "", low_face, grading}, {n / 2, 0.0, half_length_m, "", high_face, grading}};
}

TetMesh mesh_blocks(const std::vector<Block>& blocks, int order, double glue_m) {
  KLANG_CHECK(order == 1 || order == 2, "order");
  double n_elements = 0.0;
  for (const Block& block : blocks) {
    for (const int count : block.counts) KLANG_CHECK(count >= 1, "divisions");
    n_elements += 6.0 * block.counts[0] * block.counts[1] * block.counts[2];
  }
  check_element_count(n_elements);

  const int step = order == 2 ? 2 : 1;  // lattice points per cell: mid-nodes are the odd ones
  std::vector<Eigen::Vector3d> points;
  PointGlue glue(glue_m);
  std::map<std::string, std::set<int>> sets;
  TetMesh mesh;
  mesh.elements.resize(static_cast<Eigen::Index>(n_elements), order == 2 ? 10 : 4);
  int row = 0;

  for (const Block& block : blocks) {
    const std::array<int, 3> n{step * block.counts[0], step * block.counts[1], step * block.counts[2]};
    std::vector<int> lattice(static_cast<std::size_t>(n[0] + 1) * (n[1] + 1) * (n[2] + 1));
    const auto slot = [&](int i, int j, int k) -> int& {
      return lattice[(static_cast<std::size_t>(k) * (n[1] + 1) + j) * (n[0] + 1) + i];
    };
    for (int k = 0; k <= n[2]; ++k)
      for (int j = 0; j <= n[1]; ++j)
        for (int i = 0; i <= n[0]; ++i) {
          const Eigen::Vector3d point =
              block.map(static_cast<double>(i) / n[0], static_cast<double>(j) / n[1], static_cast<double>(k) / n[2]);
          const bool on_boundary = i == 0 || i == n[0] || j == 0 || j == n[1] || k == 0 || k == n[2];
          int index = on_boundary ? glue.find(point, points) : -1;
          if (index < 0) {
            index = static_cast<int>(points.size());
            points.push_back(point);
            if (on_boundary) glue.insert(point, index);
          }
          slot(i, j, k) = index;
          const std::array<bool, 6> on{i == 0, i == n[0], j == 0, j == n[1], k == 0, k == n[2]};
          for (int face = 0; face < 6; ++face)
            if (on[face] && !block.faces[face].empty()) sets[block.faces[face]].insert(index);
        }

    const bool right = right_handed(block);
    for (int k = 0; k < n[2]; k += step)
      for (int j = 0; j < n[1]; j += step)
        for (int i = 0; i < n[0]; i += step)
          for (const Path& path : kPaths) {
            // Cells with an odd index are mirror images: diagonals run from even to odd lattice points.
            const std::array<int, 3> cell{i, j, k};
            std::array<std::array<int, 3>, 4> corner;
            bool positive = path.even == right;
            for (int c = 0; c < 3; ++c) {
              const bool mirrored = cell[c] / step % 2 != 0;
              corner[0][c] = cell[c] + (mirrored ? step : 0);
              if (mirrored) positive = !positive;
            }
            for (int c = 0; c < 3; ++c) {
              const int axis = path.axes[c];
              corner[c + 1] = corner[c];
              corner[c + 1][axis] = cell[axis] + (corner[0][axis] == cell[axis] ? step : 0);
            }
            if (!positive) std::swap(corner[1], corner[2]);
            for (int c = 0; c < 4; ++c) mesh.elements(row, c) = slot(corner[c][0], corner[c][1], corner[c][2]);
            if (order == 2)
              for (int e = 0; e < 6; ++e) {
                const auto& a = corner[kTetEdges[e][0]];
                const auto& b = corner[kTetEdges[e][1]];
                mesh.elements(row, 4 + e) = slot((a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2);
              }
            const Eigen::Vector3d& p0 = points[mesh.elements(row, 0)];
            const double det = (points[mesh.elements(row, 1)] - p0)
                                   .dot((points[mesh.elements(row, 2)] - p0).cross(points[mesh.elements(row, 3)] - p0));
            if (!(det > 0.0))
              throw InputError("mesh", "the divisions are too coarse for the curvature, element has no volume",
                               std::to_string(row), "more divisions around");
            ++row;
          }
  }

  mesh.nodes_m.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) mesh.nodes_m.row(static_cast<Eigen::Index>(i)) = points[i];
  for (const auto& [name, nodes] : sets) mesh.node_sets[name].assign(nodes.begin(), nodes.end());
  return mesh;
}

}  // namespace klang::mesh::detail
