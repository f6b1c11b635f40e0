#include "core/geometry/mesh/surface_check.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/detail/self_intersection.hpp"
#include "core/geometry/mesh/detail/surface_edges.hpp"

namespace klang::mesh {
namespace {

using detail::HalfEdge;
using Eigen::Vector3d;

std::string face_name(int triangle) { return "face " + std::to_string(triangle); }

std::array<Vector3d, 3> corners(const SurfaceMesh& surface, Eigen::Index t) {
  return {surface.vertices_m.row(surface.triangles(t, 0)), surface.vertices_m.row(surface.triangles(t, 1)),
          surface.vertices_m.row(surface.triangles(t, 2))};
}

double longest_edge(const std::array<Vector3d, 3>& p) {
  return std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
}

double height(const std::array<Vector3d, 3>& p) { return (p[1] - p[0]).cross(p[2] - p[0]).norm() / longest_edge(p); }

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
    if (is_flat_triangle(p, size))
      throw InputError(name, face_name(static_cast<int>(t)) + " is degenerate: no area",
                       "height " + to_text(height(p)) + " beside edge " + to_text(longest_edge(p)));
  }
}

std::string point_text(const SurfaceMesh& surface, int v) {
  const Eigen::RowVector3d p = surface.vertices_m.row(v);
  return "(" + to_text(p[0]) + " " + to_text(p[1]) + " " + to_text(p[2]) + ")";
}

/// Throws for edges that do not close; open ones first, with their number.
void check_edges(const SurfaceMesh& surface, const std::string& name, const std::vector<HalfEdge>& edges) {
  // Of each kind of fault the lowest face that has it.
  struct Fault {
    long n = 0;
    HalfEdge first{-1, -1, std::numeric_limits<int>::max(), true};
    std::ptrdiff_t n_faces = 0;
    int other = -1;
  } open, crowded, turned;
  detail::for_each_edge(edges, [&](const HalfEdge* first, const HalfEdge* end) {
    const auto n_faces = end - first;
    if (n_faces == 2 && first->forward != first[1].forward) return;
    Fault& fault = n_faces == 1 ? open : n_faces > 2 ? crowded : turned;
    ++fault.n;
    if (first->triangle >= fault.first.triangle) return;
    fault = {fault.n, *first, n_faces, n_faces == 2 ? first[1].triangle : -1};
  });
  const auto where = [&](const HalfEdge& edge) {
    return "edge of vertices " + std::to_string(edge.low) + " and " + std::to_string(edge.high) + ", from " +
           point_text(surface, edge.low) + " to " + point_text(surface, edge.high);
  };
  const auto face = [](const Fault& fault) { return face_name(fault.first.triangle); };
  if (open.n > 0)
    throw InputError(
        name, face(open) + " has an open edge: the surface is not closed",
        std::to_string(open.n) + (open.n == 1 ? " open edge; " : " open edges; the first: ") + where(open.first));
  if (crowded.n > 0)
    throw InputError(
        name, face(crowded) + " has a non-manifold edge, shared by " + std::to_string(crowded.n_faces) + " faces",
        std::to_string(crowded.n) + (crowded.n == 1 ? " such edge; " : " such edges; the first: ") +
            where(crowded.first));
  if (turned.n > 0)
    throw InputError(name,
                     face(turned) + " and " + face_name(turned.other) +
                         " run their common edge the same way: orientation is inconsistent",
                     where(turned.first));
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

bool is_flat_triangle(const std::array<Eigen::Vector3d, 3>& p, double size_m) {
  const double high = height(p);
  return !(high > 1e-13 * size_m && high > 1e-10 * longest_edge(p));
}

SurfaceParts check_closed_surface(const SurfaceMesh& surface, const std::string& name) {
  const int n = static_cast<int>(surface.triangles.rows());
  if (n == 0) throw InputError(name, "the surface has no faces");
  check_triangles(surface, name);
  const std::vector<HalfEdge> edges = detail::sorted_half_edges(surface.triangles);
  check_edges(surface, name, edges);
  SurfaceParts parts;
  parts.part_of_triangle = detail::parts_over_edges(edges, n, parts.n_parts);
  if (parts.n_parts > kMostSurfaceParts)
    throw InputError(name, "the surface falls into too many parts", std::to_string(parts.n_parts),
                     "up to " + std::to_string(kMostSurfaceParts));
  if (const auto pair = detail::first_self_intersection(surface))
    throw InputError(name, face_name((*pair)[0]) + " and face " + std::to_string((*pair)[1]) + " intersect or touch",
                     "the surface cuts itself");
  for (const detail::PartGeometry& part : detail::part_geometry(surface, parts.part_of_triangle, parts.n_parts)) {
    const bool is_hollow = part.depth % 2 == 1;
    parts.is_hollow.push_back(is_hollow);
    if (!(std::abs(part.volume_m3) > 0.0))
      throw InputError(name, face_name(part.first_triangle) + " belongs to a part that encloses no volume");
    if ((part.volume_m3 < 0.0) != is_hollow)
      throw InputError(name, face_name(part.first_triangle) + " faces the wrong way: its part is inside-out",
                       "enclosed volume " + to_text(part.volume_m3),
                       is_hollow ? "normals into the hollow" : "normals out of the body");
    parts.volume_m3 += part.volume_m3;
    if (!is_hollow) continue;
    const int t = part.first_triangle;
    const auto p = corners(surface, t);
    const Vector3d centre = (p[0] + p[1] + p[2]) / 3.0;
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    const double distance = nearest_hit(surface, t, centre, normal);
    const double step =
        std::isfinite(distance) ? 0.5 * distance : 1e-3 * std::sqrt((p[1] - p[0]).cross(p[2] - p[0]).norm());
    parts.point_in_hollow.push_back(centre + step * normal);
  }
  return parts;
}

}  // namespace klang::mesh
