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
  const Eigen::VectorXd heights = hull.corners.transpose() * direction;
  const double enough = heights.maxCoeff() - kOutermost * hull.size;
  const HullFeatures::Plate* best = nullptr;
  int most = 1;
  double facing = 0.0;
  for (const HullFeatures::Plate& plate : hull.plates) {
    const double cosine = plate.normal.dot(direction);
    if (!(cosine > 0) || (most == 2 && cosine <= facing)) continue;
    int n = 0;  // a corner, an edge; a face faces the direction
    for (std::size_t i = 0; i < plate.corners.size() && n < 2; ++i) n += heights[plate.corners[i]] >= enough ? 1 : 0;
    if (n < most || (n == most && cosine <= facing)) continue;
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

/// What lies behind a plane.
void keep_behind(const Polygon& polygon, const Vector3d& normal, double offset, Polygon& kept) {
  kept.clear();
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
    const double d0 = normal.dot(from) - offset, d1 = normal.dot(to) - offset;
    if (d0 <= 0) kept.push_back(from);
    if ((d0 < 0 && d1 > 0) || (d0 > 0 && d1 < 0)) kept.push_back(from + d0 / (d0 - d1) * (to - from));
  }
}

/// Leaves of a polygon what lies over another, seen along the other's way out.
void cut_within(Polygon& polygon, const Polygon& other, const Vector3d& out, double tolerance, Polygon& spare) {
  for (std::size_t i = 0; i < other.size() && !polygon.empty(); ++i) {
    const Vector3d side = (other[(i + 1) % other.size()] - other[i]).cross(out).normalized();
    keep_behind(polygon, side, side.dot(other[i]) + tolerance, spare);
    polygon.swap(spare);
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
