#include "core/geometry/mesh/quality.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector3d;

struct Straight {
  double radius_ratio;
  double min_dihedral_deg, max_dihedral_deg;
  double shortest_m, longest_m;
};

Straight straight_tet(const TetMesh& mesh, int e) {
  std::array<Vector3d, 4> p;
  for (int c = 0; c < 4; ++c) p[c] = mesh.nodes_m.row(mesh.elements(e, c));
  Straight result{0.0, 180.0, 0.0, HUGE_VAL, 0.0};
  std::array<Vector3d, 4> area;  // outward area vectors
  double total_area = 0.0;
  for (int f = 0; f < 4; ++f) {
    const auto& c = kTetFaces[f];
    area[f] = 0.5 * (p[c[1]] - p[c[0]]).cross(p[c[2]] - p[c[0]]);
    total_area += area[f].norm();
  }
  for (int f = 0; f < 4; ++f)
    for (int g = f + 1; g < 4; ++g) {
      const double angle = std::atan2(area[f].cross(area[g]).norm(), -area[f].dot(area[g])) * 180.0 / kPi;
      result.min_dihedral_deg = std::min(result.min_dihedral_deg, angle);
      result.max_dihedral_deg = std::max(result.max_dihedral_deg, angle);
    }
  for (const auto& edge : kTetEdges) {
    const double length = (p[edge[0]] - p[edge[1]]).norm();
    result.shortest_m = std::min(result.shortest_m, length);
    result.longest_m = std::max(result.longest_m, length);
  }
  const Vector3d a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
  const double det = a.dot(b.cross(c));
  const double inradius = det / (2.0 * total_area);
  const double circumradius =
      (a.squaredNorm() * b.cross(c) + b.squaredNorm() * c.cross(a) + c.squaredNorm() * a.cross(b)).norm() /
      (2.0 * std::abs(det));
  result.radius_ratio = det > 0.0 ? 3.0 * inradius / circumradius : 0.0;
  return result;
}

template <class Allowed>
int nearest(const TetMesh& mesh, const Vector3d& point_m, Allowed allowed) {
  if (!point_m.allFinite()) throw InputError("nearest node", "point is not finite");
  int best = -1;
  double best_sq = HUGE_VAL;
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    if (!allowed(i)) continue;
    const double distance_sq = (mesh.nodes_m.row(i).transpose() - point_m).squaredNorm();
    if (distance_sq < best_sq) {
      best_sq = distance_sq;
      best = i;
    }
  }
  if (best < 0) throw InputError("nearest node", "the mesh has no nodes");
  return best;
}

}  // namespace

double mesh_volume_m3(const TetMesh& mesh) {
  double volume = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) volume += tet_volume_m3(mesh, e);
  return volume;
}

double surface_area_m2(const SurfaceMesh& surface) {
  // Gauss-Legendre in (s, t) on the square, folded onto the triangle: l1 = s, l2 = t (1 - s).
  static constexpr double kAt[5] = {0.046910077030668, 0.230765344947158, 0.5, 0.769234655052842, 0.953089922969332};
  static constexpr double kWeight[5] = {0.118463442528095, 0.239314335249683, 0.284444444444444, 0.239314335249683,
                                        0.118463442528095};
  double total = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Vector3d, 6> p;
    for (Eigen::Index c = 0; c < surface.triangles.cols(); ++c) p[c] = surface.vertices_m.row(surface.triangles(t, c));
    if (surface.triangles.cols() == 3) {
      total += 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
      continue;
    }
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) {
        const double l1 = kAt[i], l2 = kAt[j] * (1.0 - l1), l0 = 1.0 - l1 - l2;
        // Shape functions l (2 l - 1) and 4 l l'; derivatives along l1 and l2 with l0 = 1 - l1 - l2.
        const Vector3d d0 = (4.0 * l0 - 1.0) * p[0] + 4.0 * (l1 * p[3] + l2 * p[5]);
        const Vector3d d1 = (4.0 * l1 - 1.0) * p[1] + 4.0 * (l0 * p[3] + l2 * p[4]);
        const Vector3d d2 = (4.0 * l2 - 1.0) * p[2] + 4.0 * (l1 * p[4] + l0 * p[5]);
        total += kWeight[i] * kWeight[j] * (1.0 - l1) * (d1 - d0).cross(d2 - d0).norm();
      }
  }
  return total;
}

MeshQuality mesh_quality(const TetMesh& mesh) {
  if (mesh.n_elements() == 0) throw InputError("mesh", "no elements");
  MeshQuality quality;
  quality.n_nodes = mesh.n_nodes();
  quality.n_elements = mesh.n_elements();
  quality.order = mesh.order();
  quality.min_dihedral_deg = 180.0;
  quality.radius_ratio_min = quality.min_scaled_jacobian = HUGE_VAL;
  quality.shortest_edge_m = HUGE_VAL;
  double ratio_sum = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const Straight straight = straight_tet(mesh, e);
    quality.min_dihedral_deg = std::min(quality.min_dihedral_deg, straight.min_dihedral_deg);
    quality.max_dihedral_deg = std::max(quality.max_dihedral_deg, straight.max_dihedral_deg);
    quality.shortest_edge_m = std::min(quality.shortest_edge_m, straight.shortest_m);
    quality.longest_edge_m = std::max(quality.longest_edge_m, straight.longest_m);
    ratio_sum += straight.radius_ratio;
    if (straight.radius_ratio < quality.radius_ratio_min) {
      quality.radius_ratio_min = straight.radius_ratio;
      quality.worst_element = e;
    }
    const double volume = tet_volume_m3(mesh, e);
    quality.volume_m3 += volume;
    const double scaled = volume > 0.0 ? smallest_jacobian(mesh, e) / (6.0 * volume) : -1.0;
    if (scaled < quality.min_scaled_jacobian) {
      quality.min_scaled_jacobian = scaled;
      quality.most_curved_element = e;
    }
  }
  quality.radius_ratio_mean = ratio_sum / mesh.n_elements();
  quality.surface_area_m2 = surface_area_m2(boundary_surface(mesh));
  return quality;
}

std::string MeshQuality::brief() const {
  return std::to_string(n_elements) + (order == 2 ? " quadratic" : " linear") + " tetrahedra, " +
         std::to_string(n_nodes) + " nodes, dihedral angles " + to_text(std::round(10.0 * min_dihedral_deg) / 10.0) +
         " to " + to_text(std::round(10.0 * max_dihedral_deg) / 10.0) + " deg, least radius ratio " +
         to_text(std::round(1000.0 * radius_ratio_min) / 1000.0) + ", volume " + to_text(volume_m3) + " m^3, surface " +
         to_text(surface_area_m2) + " m^2";
}

std::optional<int> first_folded_element(const TetMesh& mesh) {
  for (int e = 0; e < mesh.n_elements(); ++e)
    if (!(smallest_jacobian(mesh, e) > 0.0)) return e;
  return std::nullopt;
}

int nearest_node(const TetMesh& mesh, const Vector3d& point_m) {
  return nearest(mesh, point_m, [](int) { return true; });
}

int nearest_surface_node(const TetMesh& mesh, const Vector3d& point_m) {
  const SurfaceMesh surface = boundary_surface(mesh);
  std::vector<char> on_surface(mesh.n_nodes(), 0);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (Eigen::Index c = 0; c < surface.triangles.cols(); ++c) on_surface[surface.triangles(t, c)] = 1;
  return nearest(mesh, point_m, [&](int i) { return on_surface[i] != 0; });
}

}  // namespace klang::mesh
