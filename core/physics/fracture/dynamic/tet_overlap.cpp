#include "core/physics/fracture/dynamic/tet_overlap.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture {
namespace {

using detail::at;
using Eigen::Vector3d;

constexpr std::array<std::array<int, 3>, 4> kFaces = {{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};  // outward
constexpr std::array<std::array<int, 2>, 6> kEdges = {{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
constexpr std::size_t kMostVertices = 48, kMostCorners = 16, kMostPolygons = 14;

/// Shape functions of a tetrahedron: slopes (rows), and values at a place.
struct Shape {
  Eigen::Matrix<double, 4, 3> slope;
  Vector3d origin;
  explicit Shape(const TetCorners& c) : origin(c[0]) {
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = c[at(k + 1)] - c[0];
    slope.bottomRows<3>() = edges.inverse();
    slope.row(0) = -slope.bottomRows<3>().colwise().sum();
  }
  double operator()(int corner, const Vector3d& x) const {
    return slope.row(corner).dot(x - origin) + (corner == 0 ? 1.0 : 0.0);
  }
};

struct Polygon {
  int face = 0;  ///< that it lies in: 0 to 3 of the first tetrahedron, 4 to 7 of the second
  std::size_t n = 0;
  std::array<int, kMostCorners> corner;
  void add(int vertex) {
    if (n < kMostCorners) corner[n++] = vertex;
  }
};

/// A convex polyhedron whose polygons turn the same way seen from outside, each edge in two of them: so it stays under cuts, by their
/// signs alone, and its area vectors sum to 0 whatever the rounding.
struct Polyhedron {
  std::array<Vector3d, kMostVertices> vertex;
  std::array<Polygon, kMostPolygons> polygon;
  std::size_t n_vertices = 0, n_polygons = 0;

  explicit Polyhedron(const TetCorners& corners) {
    for (const Vector3d& c : corners) vertex[n_vertices++] = c;
    for (int f = 0; f < 4; ++f) {
      Polygon& face = polygon[n_polygons++];
      face.face = f;
      for (const int c : kFaces[at(f)]) face.add(c);
    }
  }

  /// Keeps what has value >= 0. false: nothing is left.
  bool cut(const Shape& shape, int corner, int face) {
    std::array<double, kMostVertices> value;
    for (std::size_t v = 0; v < n_vertices; ++v) value[v] = shape(corner, vertex[v]);
    bool some = false, all = true;
    for (std::size_t p = 0; p < n_polygons; ++p)
      for (std::size_t k = 0; k < polygon[p].n; ++k) {
        const int v = polygon[p].corner[k];
        (value[at(v)] >= 0.0 ? some : all) = value[at(v)] >= 0.0;
      }
    if (all || !some) return some;
    struct Crossing {
      std::array<int, 2> edge;
      int vertex, next;
    };
    std::array<Crossing, kMostVertices> crossing;
    std::size_t n_crossings = 0;
    const auto crossing_of = [&](int a, int b) {
      const std::array<int, 2> edge = {std::min(a, b), std::max(a, b)};
      for (std::size_t i = 0; i < n_crossings; ++i)
        if (crossing[i].edge == edge) return i;
      const double s = value[at(edge[0])], t = value[at(edge[1])];
      vertex[n_vertices] = vertex[at(edge[0])] + s / (s - t) * (vertex[at(edge[1])] - vertex[at(edge[0])]);
      crossing[n_crossings] = {edge, static_cast<int>(n_vertices++), -1};
      return n_crossings++;
    };
    std::size_t kept = 0;
    for (std::size_t p = 0; p < n_polygons; ++p) {
      const Polygon old = polygon[p];
      Polygon now;
      now.face = old.face;
      int left = -1, first_entry = -1;
      for (std::size_t k = 0; k < old.n; ++k) {
        const int a = old.corner[k], b = old.corner[(k + 1) % old.n];
        const bool in_a = value[at(a)] >= 0.0, in_b = value[at(b)] >= 0.0;
        if (in_a) now.add(a);
        if (in_a == in_b) continue;
        if (n_vertices >= kMostVertices) return false;
        const std::size_t c = crossing_of(a, b);
        now.add(crossing[c].vertex);
        if (in_a) {
          left = static_cast<int>(c);
        } else if (left >= 0) {
          crossing[c].next = left;  // the lid goes against the polygon
          left = -1;
        } else {
          first_entry = static_cast<int>(c);
        }
      }
      if (left >= 0 && first_entry >= 0) crossing[at(first_entry)].next = left;
      if (now.n >= 3) polygon[kept++] = now;
    }
    n_polygons = kept;
    for (std::size_t i = 0; i < n_crossings && n_polygons < kMostPolygons; ++i) {
      if (crossing[i].next < 0) continue;
      Polygon lid;
      lid.face = face;
      for (std::size_t c = i; crossing[c].next >= 0;) {
        lid.add(crossing[c].vertex);
        const std::size_t next = at(crossing[c].next);
        crossing[c].next = -1;
        c = next;
      }
      if (lid.n >= 3) polygon[n_polygons++] = lid;
    }
    return n_polygons >= 4;
  }
};

double volume_of(const TetCorners& c) { return (c[1] - c[0]).cross(c[2] - c[0]).dot(c[3] - c[0]) / 6.0; }

}  // namespace

std::optional<TetOverlap> tet_overlap(const TetCorners& first, const TetCorners& second) {
  TetCorners a = first, b = second;  // about a corner, where round-off is least
  for (Vector3d& x : a) x -= first[0];
  for (Vector3d& x : b) x -= first[0];
  const std::array<Shape, 2> shape = {Shape(a), Shape(b)};
  Polyhedron common(a);
  for (int k = 0; k < 4; ++k)
    if (!common.cut(shape[1], k, 4 + k)) return std::nullopt;
  TetOverlap overlap;
  overlap.gradient_m2.fill(Vector3d::Zero());
  const Vector3d origin = common.vertex[at(common.polygon[0].corner[0])];
  for (std::size_t p = 0; p < common.n_polygons; ++p) {
    const Polygon& polygon = common.polygon[p];
    const int side = polygon.face / 4, opposite = polygon.face % 4;
    for (std::size_t k = 1; k + 1 < polygon.n; ++k) {
      const Vector3d &u = common.vertex[at(polygon.corner[0])], &v = common.vertex[at(polygon.corner[k])],
                     &w = common.vertex[at(polygon.corner[k + 1])];
      const Vector3d area = 0.5 * (v - u).cross(w - u), middle = (u + v + w) / 3.0;
      const double volume = area.dot(u - origin) / 3.0;
      overlap.volume_m3 += volume;
      overlap.centre_m += volume * (0.75 * middle + 0.25 * origin);
      for (int c = 0; c < 4; ++c)
        if (c != opposite) overlap.gradient_m2[at(4 * side + c)] += shape[at(side)](c, middle) * area;
    }
  }
  if (!(overlap.volume_m3 > 1e-14 * std::min(volume_of(a), volume_of(b)))) return std::nullopt;
  overlap.centre_m = overlap.centre_m / overlap.volume_m3 + first[0];
  return overlap;
}

double gap_along_m(const TetCorners& first, const TetCorners& second, int axis) {
  if (axis < 8) {
    const TetCorners &mine = axis < 4 ? first : second, &theirs = axis < 4 ? second : first;
    const auto& face = kFaces[at(axis % 4)];
    const Vector3d& p = mine[at(face[0])];
    const Vector3d n = (mine[at(face[1])] - p).cross(mine[at(face[2])] - p);
    double least = HUGE_VAL;
    for (const Vector3d& x : theirs) least = std::min(least, n.dot(x - p));
    return least / n.norm();
  }
  const auto &e = kEdges[at((axis - 8) / 6)], &g = kEdges[at((axis - 8) % 6)];
  const Vector3d u = first[at(e[1])] - first[at(e[0])], v = second[at(g[1])] - second[at(g[0])], n = u.cross(v);
  const double size = n.norm();
  if (!(size > 1e-6 * u.norm() * v.norm())) return -HUGE_VAL;
  double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
  for (std::size_t k = 0; k < 4; ++k) {
    const double x = n.dot(first[k] - first[0]), y = n.dot(second[k] - first[0]);
    low[0] = std::min(low[0], x);
    high[0] = std::max(high[0], x);
    low[1] = std::min(low[1], y);
    high[1] = std::max(high[1], y);
  }
  return std::max(low[1] - high[0], low[0] - high[1]) / size;
}

int widest_axis(const TetCorners& first, const TetCorners& second, bool faces_only) {
  int widest = 0;
  double gap = -HUGE_VAL;
  for (int axis = 0; axis < (faces_only ? 8 : kSeparatingAxes); ++axis)
    if (const double here = gap_along_m(first, second, axis); here > gap) {
      gap = here;
      widest = axis;
    }
  return widest;
}

}  // namespace klang::fracture
