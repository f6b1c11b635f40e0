#include "core/geometry/mesh/detail/self_intersection.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <mutex>
#include <numeric>
#include <vector>

#include "core/foundation/base/parallel.hpp"
#include "core/geometry/mesh/detail/tetgen_library.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct Bounds {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = Vector3d::Constant(-HUGE_VAL);
  void add(const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void add(const Bounds& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  bool meets(const Bounds& b) const {
    return (low.array() <= b.high.array()).all() && (b.low.array() <= high.array()).all();
  }
};

/// Boxes around halves of the triangles, halved again down to four.
class BoxTree {
 public:
  explicit BoxTree(const std::vector<Bounds>& boxes) : boxes_(boxes), order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0);
    if (!boxes.empty()) build(0, static_cast<int>(boxes.size()));
  }

  template <class Visit>
  void visit(const Bounds& box, Visit visit_triangle) const {
    std::vector<int> stack{0};
    while (!stack.empty()) {
      const Node& node = nodes_[stack.back()];
      stack.pop_back();
      if (!node.box.meets(box)) continue;
      if (node.left < 0) {
        for (int i = node.begin; i < node.end; ++i)
          if (boxes_[order_[i]].meets(box)) visit_triangle(order_[i]);
      } else {
        stack.push_back(node.left);
        stack.push_back(node.right);
      }
    }
  }

 private:
  struct Node {
    Bounds box;
    int begin, end, left = -1, right = -1;
  };

  int build(int begin, int end) {
    const int index = static_cast<int>(nodes_.size());
    Node node{{}, begin, end, -1, -1};
    for (int i = begin; i < end; ++i) node.box.add(boxes_[order_[i]]);
    nodes_.push_back(node);
    if (end - begin > 4) {
      int axis = 0;
      (node.box.high - node.box.low).maxCoeff(&axis);
      const int middle = (begin + end) / 2;
      std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
        const double ca = boxes_[a].low[axis] + boxes_[a].high[axis], cb = boxes_[b].low[axis] + boxes_[b].high[axis];
        return ca != cb ? ca < cb : a < b;
      });
      const int left = build(begin, middle);
      const int right = build(middle, end);
      nodes_[index].left = left;
      nodes_[index].right = right;
    }
    return index;
  }

  const std::vector<Bounds>& boxes_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

/// Does the segment pq meet the triangle abc, borders included? Segments in the plane of the triangle are
/// left to the flat test.
bool segment_meets_triangle(const double* p, const double* q, const double* a, const double* b, const double* c) {
  const int side_p = orientation_sign(a, b, c, p), side_q = orientation_sign(a, b, c, q);
  if (side_p == side_q) return false;
  const int ab = orientation_sign(p, q, a, b), bc = orientation_sign(p, q, b, c), ca = orientation_sign(p, q, c, a);
  return (ab >= 0 && bc >= 0 && ca >= 0) || (ab <= 0 && bc <= 0 && ca <= 0);
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Triangles in one plane: do their insides overlap? Separating-axis test on the three edge directions of
/// each.
bool flat_overlap(const std::array<Vector2d, 3>& s, const std::array<Vector2d, 3>& t) {
  const auto separated = [](const std::array<Vector2d, 3>& u, const std::array<Vector2d, 3>& v) {
    for (int i = 0; i < 3; ++i) {
      const Vector2d edge = u[(i + 1) % 3] - u[i];
      const double side = cross(edge, u[(i + 2) % 3] - u[i]);
      double nearest = -HUGE_VAL;
      for (const Vector2d& point : v) nearest = std::max(nearest, cross(edge, point - u[i]) / side);
      if (nearest <= 1e-9) return true;  // all of v beyond this edge, or on it
    }
    return false;
  };
  return !separated(s, t) && !separated(t, s);
}

class PairTest {
 public:
  explicit PairTest(const SurfaceMesh& surface) : surface_(surface) {}

  bool meet(int s, int t) const {
    std::array<int, 3> own = corners(s), other = corners(t);
    // Shared corners first.
    int n_shared = 0;
    for (int i = 0; i < 3; ++i)
      for (int k = n_shared; k < 3; ++k)
        if (own[i] == other[k]) {
          std::swap(own[n_shared], own[i]);
          std::swap(other[n_shared], other[k]);
          ++n_shared;
          break;
        }
    if (n_shared == 3) return true;
    const auto at = [this](int vertex) { return surface_.vertices_m.row(vertex).data(); };
    bool one_plane = true;
    for (int k = n_shared; k < 3; ++k)
      one_plane = one_plane && orientation_sign(at(own[0]), at(own[1]), at(own[2]), at(other[k])) == 0;
    if (one_plane) return flat_overlap(flat(own, s), flat(other, s));
    if (n_shared == 2) return false;
    const auto edge_meets = [&](int p, int q, const std::array<int, 3>& v) {
      return segment_meets_triangle(at(p), at(q), at(v[0]), at(v[1]), at(v[2]));
    };
    if (n_shared == 1) return edge_meets(own[1], own[2], other) || edge_meets(other[1], other[2], own);
    for (int i = 0; i < 3; ++i)
      if (edge_meets(own[i], own[(i + 1) % 3], other) || edge_meets(other[i], other[(i + 1) % 3], own)) return true;
    return false;
  }

 private:
  std::array<int, 3> corners(int t) const {
    return {surface_.triangles(t, 0), surface_.triangles(t, 1), surface_.triangles(t, 2)};
  }

  /// Both seen along the largest component of the normal of triangle s.
  std::array<Vector2d, 3> flat(const std::array<int, 3>& v, int s) const {
    const Vector3d p0 = surface_.vertices_m.row(surface_.triangles(s, 0));
    const Vector3d p1 = surface_.vertices_m.row(surface_.triangles(s, 1));
    const Vector3d p2 = surface_.vertices_m.row(surface_.triangles(s, 2));
    int axis = 0;
    (p1 - p0).cross(p2 - p0).cwiseAbs().maxCoeff(&axis);
    std::array<Vector2d, 3> result;
    for (int c = 0; c < 3; ++c)
      result[c] = {surface_.vertices_m(v[c], (axis + 1) % 3), surface_.vertices_m(v[c], (axis + 2) % 3)};
    return result;
  }

  const SurfaceMesh& surface_;
};

}  // namespace

std::optional<std::array<int, 2>> first_self_intersection(const SurfaceMesh& surface) {
  const int n = static_cast<int>(surface.triangles.rows());
  std::vector<Bounds> boxes(n);
  for (int t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) boxes[t].add(Vector3d(surface.vertices_m.row(surface.triangles(t, c))));
  const BoxTree tree(boxes);
  const PairTest test(surface);
  std::atomic<int> lowest{INT_MAX};
  std::mutex guard;
  std::array<int, 2> found{INT_MAX, INT_MAX};
  parallel_for(static_cast<std::size_t>(n), 256, [&](std::size_t begin, std::size_t end) {
    for (int s = static_cast<int>(begin); s < static_cast<int>(end) && s < lowest; ++s) {
      int partner = INT_MAX;
      tree.visit(boxes[s], [&](int t) {
        if (t > s && t < partner && test.meet(s, t)) partner = t;
      });
      if (partner == INT_MAX) continue;
      const std::lock_guard lock(guard);
      found = std::min(found, {s, partner});
      lowest = found[0];
      return;
    }
  });
  if (found[0] == INT_MAX) return std::nullopt;
  return found;
}

}  // namespace klang::mesh::detail
