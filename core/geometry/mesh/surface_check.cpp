#include "core/geometry/mesh/surface_check.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/detail/self_intersection.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector3d;

struct HalfEdge {
  int low, high, triangle;
  bool forward;  ///< the triangle runs from low to high
};

std::string face_name(int triangle) { return "face " + std::to_string(triangle); }

std::array<Vector3d, 3> corners(const SurfaceMesh& surface, Eigen::Index t) {
  return {surface.vertices_m.row(surface.triangles(t, 0)), surface.vertices_m.row(surface.triangles(t, 1)),
          surface.vertices_m.row(surface.triangles(t, 2))};
}

void check_triangles(const SurfaceMesh& surface, const std::string& name) {
  const int n_vertices = static_cast<int>(surface.vertices_m.rows());
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int v = surface.triangles(t, c);
      if (v < 0 || v >= n_vertices)
        throw InputError(name, face_name(static_cast<int>(t)) + ": vertex out of range", std::to_string(v),
                         "0 to " + std::to_string(n_vertices - 1));
      if (!surface.vertices_m.row(v).allFinite())
        throw InputError(name, face_name(static_cast<int>(t)) + ": vertex " + std::to_string(v) + " is not finite");
      if (!(surface.vertices_m.row(v).cwiseAbs().maxCoeff() <= 1e9))
        throw InputError(name, face_name(static_cast<int>(t)) + ": vertex " + std::to_string(v) + " is out of range",
                         "", "coordinates up to 1e9");
      low = low.cwiseMin(surface.vertices_m.row(v).transpose());
      high = high.cwiseMax(surface.vertices_m.row(v).transpose());
    }
  const double size = (high - low).maxCoeff();
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto v = surface.triangles.row(t);
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
      throw InputError(name, face_name(static_cast<int>(t)) + " is degenerate: a corner repeats",
                       std::to_string(v[0]) + " " + std::to_string(v[1]) + " " + std::to_string(v[2]));
    const auto p = corners(surface, t);
    const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
    const double height = (p[1] - p[0]).cross(p[2] - p[0]).norm() / longest;
    // Thinner than the rounding of its coordinates.
    if (!(height > 1e-13 * size && height > 1e-10 * longest))
      throw InputError(name, face_name(static_cast<int>(t)) + " is degenerate: no area",
                       "height " + to_text(height) + " beside edge " + to_text(longest));
  }
}

/// Parts of triangles joined over edges; throws for edges that do not close.
std::vector<int> join_over_edges(const SurfaceMesh& surface, const std::string& name, int& n_parts) {
  const int n = static_cast<int>(surface.triangles.rows());
  std::vector<HalfEdge> edges;
  edges.reserve(static_cast<std::size_t>(n) * 3);
  for (int t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) {
      const int a = surface.triangles(t, c), b = surface.triangles(t, (c + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.low, x.high, x.triangle) < std::tie(y.low, y.high, y.triangle);
  });
  std::vector<int> root(n);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](int t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  // Report the fault at the lowest face, whatever its kind.
  int bad_face = n;
  std::string problem, value;
  const auto report = [&](int face, std::string text, const HalfEdge& edge) {
    if (face >= bad_face) return;
    bad_face = face;
    problem = std::move(text);
    value = "edge of vertices " + std::to_string(edge.low) + " and " + std::to_string(edge.high);
  };
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    const HalfEdge& first = edges[i];
    if (end - i == 1) {
      report(first.triangle, " has an open edge: the surface is not closed", first);
    } else if (end - i > 2) {
      report(first.triangle, " has a non-manifold edge, shared by " + std::to_string(end - i) + " faces", first);
    } else {
      const HalfEdge& second = edges[i + 1];
      if (first.forward == second.forward)
        report(first.triangle,
               " and face " + std::to_string(second.triangle) +
                   " run their common edge the same way: orientation is inconsistent",
               first);
      root[find(first.triangle)] = find(second.triangle);
    }
    i = end;
  }
  if (bad_face < n) throw InputError(name, face_name(bad_face) + problem, value);
  std::vector<int> part(n), number(n, -1);
  n_parts = 0;
  for (int t = 0; t < n; ++t) {
    const int r = find(t);
    if (number[r] < 0) number[r] = n_parts++;
    part[t] = number[r];
  }
  return part;
}

/// Solid angle of a triangle seen from a point over 4 pi (van Oosterom and Strackee 1983).
double winding(const std::array<Vector3d, 3>& p, const Vector3d& from) {
  const Vector3d a = p[0] - from, b = p[1] - from, c = p[2] - from;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double up = a.dot(b.cross(c));
  const double down = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  return 2.0 * std::atan2(up, down) / (4.0 * kPi);
}

/// Distance along a ray to the nearest triangle but its own.
double nearest_hit(const SurfaceMesh& surface, int own, const Vector3d& from, const Vector3d& direction) {
  double nearest = HUGE_VAL;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    if (t == own) continue;
    const auto p = corners(surface, t);
    const Vector3d e1 = p[1] - p[0], e2 = p[2] - p[0], h = direction.cross(e2);
    const double det = e1.dot(h);
    if (det == 0.0) continue;
    const Vector3d s = from - p[0];
    const double u = s.dot(h) / det, v = direction.dot(s.cross(e1)) / det, at = e2.dot(s.cross(e1)) / det;
    if (u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && at > 0.0) nearest = std::min(nearest, at);
  }
  return nearest;
}

}  // namespace

SurfaceParts check_closed_surface(const SurfaceMesh& surface, const std::string& name) {
  const int n = static_cast<int>(surface.triangles.rows());
  if (n == 0) throw InputError(name, "the surface has no faces");
  check_triangles(surface, name);
  SurfaceParts parts;
  parts.part_of_triangle = join_over_edges(surface, name, parts.n_parts);
  if (parts.n_parts > 1000)
    throw InputError(name, "the surface falls into too many parts", std::to_string(parts.n_parts), "up to 1000");
  if (const auto pair = detail::first_self_intersection(surface))
    throw InputError(name, face_name((*pair)[0]) + " and face " + std::to_string((*pair)[1]) + " intersect or touch",
                     "the surface cuts itself");

  std::vector<double> volume(parts.n_parts, 0.0);
  std::vector<int> first_triangle(parts.n_parts, -1);
  std::vector<Vector3d> low(parts.n_parts, Vector3d::Constant(HUGE_VAL)),
      high(parts.n_parts, Vector3d::Constant(-HUGE_VAL));
  const Vector3d origin = surface.vertices_m.row(surface.triangles(0, 0));
  for (int t = 0; t < n; ++t) {
    const int part = parts.part_of_triangle[t];
    const auto p = corners(surface, t);
    volume[part] += (p[0] - origin).dot((p[1] - origin).cross(p[2] - origin)) / 6.0;
    if (first_triangle[part] < 0) first_triangle[part] = t;
    for (const Vector3d& point : p) {
      low[part] = low[part].cwiseMin(point);
      high[part] = high[part].cwiseMax(point);
    }
  }
  parts.is_hollow.assign(parts.n_parts, false);
  for (int part = 0; part < parts.n_parts; ++part) {
    const Vector3d point = surface.vertices_m.row(surface.triangles(first_triangle[part], 0));
    int depth = 0;
    for (int other = 0; other < parts.n_parts; ++other) {
      if (other == part || (point.array() < low[other].array()).any() || (point.array() > high[other].array()).any())
        continue;
      double turns = 0.0;
      for (int t = 0; t < n; ++t)
        if (parts.part_of_triangle[t] == other) turns += winding(corners(surface, t), point);
      if (std::abs(turns) > 0.5) ++depth;
    }
    parts.is_hollow[part] = depth % 2 == 1;
    const bool faces_in = volume[part] < 0.0;
    if (!(std::abs(volume[part]) > 0.0))
      throw InputError(name, face_name(first_triangle[part]) + " belongs to a part that encloses no volume");
    if (faces_in != parts.is_hollow[part])
      throw InputError(name, face_name(first_triangle[part]) + " faces the wrong way: its part is inside-out",
                       "enclosed volume " + to_text(volume[part]),
                       parts.is_hollow[part] ? "normals into the hollow" : "normals out of the body");
    parts.volume_m3 += volume[part];
    if (parts.is_hollow[part]) {
      const int t = first_triangle[part];
      const auto p = corners(surface, t);
      const Vector3d centre = (p[0] + p[1] + p[2]) / 3.0;
      const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
      const double distance = nearest_hit(surface, t, centre, normal);
      const double step =
          std::isfinite(distance) ? 0.5 * distance : 1e-3 * std::sqrt((p[1] - p[0]).cross(p[2] - p[0]).norm());
      parts.point_in_hollow.push_back(centre + step * normal);
    }
  }
  return parts;
}

}  // namespace klang::mesh
