#include "core/physics/rigid/detail/hull_touches.hpp"

#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

constexpr double kOutermost = 1e-9;  // of the size: corners as far out as the farthest
constexpr double kOnSide = 1e-14;    // of the size: a point on the side of a face is inside

/// The face at the hull's end in a direction: of those with most of the outermost corners the one that faces it most.
const HullFeatures::Plate* outermost(const HullFeatures& hull, const Vector3d& direction) {
  static thread_local Eigen::VectorXd heights;  // its room is kept from call to call
  static thread_local std::vector<int> outer, beside;
  heights =
      direction.x() * hull.by_axis.col(0) + direction.y() * hull.by_axis.col(1) + direction.z() * hull.by_axis.col(2);
  const double enough = heights.maxCoeff() - kOutermost * hull.size;
  outer.clear();
  for (Eigen::Index i = 0; i < heights.size(); ++i)
    if (heights[i] >= enough) outer.push_back(static_cast<int>(i));
  beside.clear();  // faces of these corners, in the order of faces
  for (const int corner : outer) {
    const std::vector<int>& its = hull.plates_of_corner[static_cast<std::size_t>(corner)];
    beside.insert(beside.end(), its.begin(), its.end());
  }
  std::sort(beside.begin(), beside.end());
  const HullFeatures::Plate* best = nullptr;
  std::ptrdiff_t most = 1;
  double facing = 0.0;
  for (std::size_t i = 0, next = 0; i < beside.size(); i = next) {
    while (next < beside.size() && beside[next] == beside[i]) ++next;
    const HullFeatures::Plate& plate = hull.plates[static_cast<std::size_t>(beside[i])];
    const auto n =
        std::min<std::ptrdiff_t>(2, static_cast<std::ptrdiff_t>(next - i));  // a corner, an edge; a face faces it
    const double cosine = plate.normal.dot(direction);
    if (!(cosine > 0) || n < most || (n == most && cosine <= facing)) continue;
    most = n;
    facing = cosine;
    best = &plate;
  }
  return best;
}

void place(const HullFeatures& hull, const HullFeatures::Plate& plate, const Eigen::Isometry3d& to, Polygon& placed) {
  placed.clear();
  for (const int corner : plate.corners) placed.push_back(to * hull.corners.col(corner));
}

/// Leaves of a polygon what lies behind a plane.
void keep_behind(Polygon& polygon, const Vector3d& normal, double offset, Polygon& spare, std::vector<double>& over) {
  over.resize(polygon.size());
  double highest = -HUGE_VAL;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    over[i] = normal.dot(polygon[i]) - offset;
    highest = std::max(highest, over[i]);
  }
  if (highest <= 0) return;
  spare.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const std::size_t k = i + 1 < polygon.size() ? i + 1 : 0;
    const double d0 = over[i], d1 = over[k];
    if (d0 <= 0) spare.push_back(polygon[i]);
    if ((d0 < 0 && d1 > 0) || (d0 > 0 && d1 < 0))
      spare.push_back(polygon[i] + d0 / (d0 - d1) * (polygon[k] - polygon[i]));
  }
  polygon.swap(spare);
}

/// Leaves of a polygon what lies over another, seen along the other's way out.
void cut_within(Polygon& polygon, const Polygon& other, const Vector3d& out, double tolerance, Polygon& spare) {
  static thread_local std::vector<double> over;
  for (std::size_t i = 0; i < other.size() && !polygon.empty(); ++i) {
    const Vector3d side = (other[(i + 1) % other.size()] - other[i]).cross(out).normalized();
    keep_behind(polygon, side, side.dot(other[i]) + tolerance, spare, over);
  }
}

HullTouch where_edges_cross(const HullFeatures::Edge& a, const HullFeatures::Edge& b, const Eigen::Isometry3d& b_to_a,
                            const HullAxis& axis) {
  const Vector3d u = a.along, v = b_to_a.linear() * b.along, from = b_to_a * b.from, w = from - a.from;
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v);
  const double along_b = (uv * u.dot(w) - uu * v.dot(w)) / (uu * vv - uv * uv);
  return {from + std::clamp(along_b, 0.0, 1.0) * v, axis.gap};
}

/// The corner farthest into the hull whose face made the axis.
HullTouch farthest_corner(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                          const HullAxis& axis, bool of_b) {
  Eigen::Index i = 0;
  if (of_b) {
    (b.corners.transpose() * (b_to_a.linear().transpose() * axis.normal)).maxCoeff(&i);
    return {b_to_a * b.corners.col(i), axis.gap};
  }
  (a.corners.transpose() * axis.normal).minCoeff(&i);
  return {a.corners.col(i) - axis.gap * axis.normal, axis.gap};
}

}  // namespace

std::vector<HullTouch> hull_touches(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                                    const HullAxis& axis, double near) {
  const Vector3d& n = axis.normal;
  const HullFeatures::Plate* const of_a = outermost(a, -n);
  const HullFeatures::Plate* const of_b = outermost(b, b_to_a.linear().transpose() * n);
  std::vector<HullTouch> touches;
  bool face_of_a = true;
  if (of_a != nullptr && of_b != nullptr) {
    static thread_local Polygon face_a, face_b, spare;  // their room is kept from call to call
    place(a, *of_a, Eigen::Isometry3d::Identity(), face_a);
    place(b, *of_b, b_to_a, face_b);
    const Vector3d normal_b = b_to_a.linear() * of_b->normal;
    const double cosine_a = -n.dot(of_a->normal), cosine_b = n.dot(normal_b), tolerance = kOnSide * (a.size + b.size);
    face_of_a = cosine_a >= cosine_b - 1e-12;
    if (face_of_a) {
      cut_within(face_b, face_a, -n, tolerance, spare);
      for (const Vector3d& x : face_b) touches.push_back({x, (of_a->normal.dot(x) - of_a->offset) / cosine_a});
    } else {
      const double offset = of_b->offset + normal_b.dot(b_to_a.translation());
      cut_within(face_a, face_b, n, tolerance, spare);
      for (const Vector3d& x : face_a) {
        const double gap = (normal_b.dot(x) - offset) / cosine_b;
        touches.push_back({x - gap * n, gap});
      }
    }
  }
  const auto deeper = [](const HullTouch& x, const HullTouch& y) { return x.gap < y.gap; };
  std::erase_if(touches, [&](const HullTouch& touch) { return !(touch.gap <= near); });
  const auto deepest = std::min_element(touches.begin(), touches.end(), deeper);
  if (axis.edges) {
    touches.push_back(where_edges_cross(a.edges[(*axis.edges)[0]], b.edges[(*axis.edges)[1]], b_to_a, axis));
  } else if (deepest == touches.end() || deepest->gap > axis.gap + kOutermost * (a.size + b.size)) {
    touches.push_back(farthest_corner(a, b, b_to_a, axis, face_of_a));
  }
  return touches;
}

}  // namespace klang::rigid::detail
