#include "core/geometry/mesh/detail/surface_edges.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>

#include "core/foundation/base/conventions.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector3d;

std::array<Vector3d, 3> corners(const SurfaceMesh& surface, Eigen::Index t) {
  return {surface.vertices_m.row(surface.triangles(t, 0)), surface.vertices_m.row(surface.triangles(t, 1)),
          surface.vertices_m.row(surface.triangles(t, 2))};
}

/// Solid angle of a triangle seen from a point over 4 pi (van Oosterom and Strackee 1983).
double winding(const std::array<Vector3d, 3>& p, const Vector3d& from) {
  const Vector3d a = p[0] - from, b = p[1] - from, c = p[2] - from;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double up = a.dot(b.cross(c));
  const double down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(up, down) / (4.0 * kPi);
}

}  // namespace

std::vector<HalfEdge> sorted_half_edges(const IndexRows& triangles) {
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(triangles.rows()) * 3);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = triangles(t, c), b = triangles(t, (c + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.low, x.high, x.triangle) < std::tie(y.low, y.high, y.triangle);
  });
  return edges;
}

std::vector<int> parts_over_edges(const std::vector<HalfEdge>& edges, int n_triangles, int& n_parts) {
  std::vector<int> root(static_cast<std::size_t>(n_triangles));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* end) {
    if (end - first == 2) root[find(first->triangle)] = find(first[1].triangle);
  });
  std::vector<int> part(root.size()), number(root.size(), -1);
  n_parts = 0;
  for (int t = 0; t < n_triangles; ++t) {
    const int r = find(t);
    if (number[r] < 0) number[r] = n_parts++;
    part[t] = number[r];
  }
  return part;
}

std::vector<PartGeometry> part_geometry(const SurfaceMesh& surface, const std::vector<int>& part_of_triangle,
                                        int n_parts) {
  const auto n = static_cast<int>(surface.triangles.rows());
  std::vector<PartGeometry> parts(static_cast<std::size_t>(n_parts));
  std::vector<Vector3d> low(parts.size(), Vector3d::Constant(HUGE_VAL)), high(parts.size(), -low[0]);
  std::vector<std::vector<int>> triangles(parts.size());
  const Vector3d origin = surface.vertices_m.row(surface.triangles(0, 0));
  for (int t = 0; t < n; ++t) {
    const auto at = static_cast<std::size_t>(part_of_triangle[t]);
    const auto p = corners(surface, t);
    parts[at].volume_m3 += (p[0] - origin).dot((p[1] - origin).cross(p[2] - origin)) / 6.0;
    if (parts[at].first_triangle < 0) parts[at].first_triangle = t;
    triangles[at].push_back(t);
    for (const Vector3d& point : p) {
      low[at] = low[at].cwiseMin(point);
      high[at] = high[at].cwiseMax(point);
    }
  }
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const Vector3d point = surface.vertices_m.row(surface.triangles(parts[part].first_triangle, 0));
    for (std::size_t other = 0; other < parts.size(); ++other) {
      if (other == part || (point.array() < low[other].array()).any() || (point.array() > high[other].array()).any())
        continue;
      double turns = 0.0;
      for (const int t : triangles[other]) turns += winding(corners(surface, t), point);
      if (!(std::abs(turns) > 0.5)) continue;
      ++parts[part].depth;
      const int within = parts[part].within;
      if (within < 0 || std::abs(parts[other].volume_m3) < std::abs(parts[within].volume_m3))
        parts[part].within = static_cast<int>(other);
    }
  }
  return parts;
}

}  // namespace klang::mesh::detail
