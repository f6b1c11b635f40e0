#include "core/sound/bem/radiating_surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_check.hpp"

namespace klang::acoustics {

using Eigen::Vector3d;

double element_size_m(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double area = 0.5 * (b - a).cross(c - a).norm();
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return std::max(std::sqrt(4.0 * area / std::sqrt(3.0)), 0.5 * longest);
}

RadiatingSurface radiating_surface(const mesh::SurfaceMesh& surface, std::vector<int>* vertex_of) {
  RadiatingSurface result;
  const int n = static_cast<int>(surface.triangles.rows());
  std::vector<int> number(static_cast<std::size_t>(surface.vertices_m.rows()), -1);
  for (int t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) number[surface.triangles(t, c)] = 0;
  std::vector<int> kept;
  for (std::size_t v = 0; v < number.size(); ++v) {
    if (number[v] < 0) continue;
    number[v] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(v));
  }
  result.vertices_m.resize(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t v = 0; v < kept.size(); ++v)
    result.vertices_m.col(static_cast<Eigen::Index>(v)) = surface.vertices_m.row(kept[v]).transpose();
  result.triangles.resize(3, n);
  result.normals.resize(3, n);
  result.centroids_m.resize(3, n);
  result.areas_m2.resize(n);
  result.radii_m.resize(n);
  for (int t = 0; t < n; ++t) {
    for (int c = 0; c < 3; ++c) result.triangles(c, t) = number[surface.triangles(t, c)];
    const Vector3d a = result.corner(t, 0), b = result.corner(t, 1), c = result.corner(t, 2);
    const Vector3d doubled = (b - a).cross(c - a);
    result.areas_m2[t] = 0.5 * doubled.norm();
    result.normals.col(t) = doubled / doubled.norm();
    const Vector3d centroid = (a + b + c) / 3.0;
    result.centroids_m.col(t) = centroid;
    result.radii_m[t] = std::max({(a - centroid).norm(), (b - centroid).norm(), (c - centroid).norm()});
    result.largest_edge_m = std::max(result.largest_edge_m, element_size_m(a, b, c));
  }
  if (result.n_vertices() > 0) {
    const Vector3d low = result.vertices_m.rowwise().minCoeff(), high = result.vertices_m.rowwise().maxCoeff();
    result.radius_m = (result.vertices_m.colwise() - 0.5 * (low + high)).colwise().norm().maxCoeff();
  }
  if (vertex_of != nullptr) *vertex_of = std::move(kept);
  return result;
}

RadiatingSurface radiating_surface(const mesh::MirroredSurface& mirrored) {
  RadiatingSurface result = radiating_surface(mirrored.surface);
  KLANG_CHECK(result.n_vertices() == mirrored.surface.vertices_m.rows(), "every vertex is used");
  result.mirrors = {mirrored.planes, mirrored.n_own_vertices, mirrored.vertex_image};
  return result;
}

RadiatingSurface moved(const RadiatingSurface& surface, const Eigen::Matrix3Xd& vertices_m) {
  KLANG_CHECK(vertices_m.cols() == surface.n_vertices(), "a place for each vertex");
  const SurfaceMirrors& mirrors = surface.mirrors;
  mesh::SurfaceMesh mesh{vertices_m.transpose(), surface.triangles.transpose()};
  const int n_images = mirrors.planes.n_images();
  if (n_images > 1)
    for (int v = 0; v < mirrors.n_own_vertices; ++v) {
      Vector3d mean = Vector3d::Zero();
      for (int g = 0; g < n_images; ++g)
        mean += mirrors.planes.reflected(vertices_m.col(mirrors.vertex_image[g][v]), g) / n_images;
      for (int g = 0; g < n_images; ++g)
        mesh.vertices_m.row(mirrors.vertex_image[g][v]) = mirrors.planes.reflected(mean, g).transpose();
    }
  RadiatingSurface result = radiating_surface(mesh);
  result.mirrors = mirrors;
  return result;
}

RadiatingSurface checked_radiating_surface(const mesh::SurfaceMesh& surface, const std::string& name) {
  mesh::check_closed_surface(surface, name);
  return radiating_surface(surface);
}

std::vector<bool> faces_outer_fluid(const mesh::SurfaceMesh& surface) {
  const mesh::SurfaceParts parts = mesh::check_closed_surface(surface, "surface");
  const auto n = static_cast<std::size_t>(surface.triangles.rows());
  std::vector<bool> outer(n, true);
  if (parts.n_parts == 1) return outer;
  const auto at = [&](std::size_t t, int c) -> Vector3d {
    return surface.vertices_m.row(surface.triangles(static_cast<Eigen::Index>(t), c)).transpose();
  };
  std::vector<bool> part_is_outer(static_cast<std::size_t>(parts.n_parts));
  for (int part = 0; part < parts.n_parts; ++part) {
    std::size_t first = 0;
    while (parts.part_of_triangle[first] != part) ++first;
    const Vector3d point = at(first, 0);
    std::vector<double> turns(static_cast<std::size_t>(parts.n_parts), 0.0);
    for (std::size_t t = 0; t < n; ++t) {
      const int other = parts.part_of_triangle[t];
      if (other == part) continue;
      const Vector3d a = at(t, 0) - point, b = at(t, 1) - point, c = at(t, 2) - point;
      const double la = a.norm(), lb = b.norm(), lc = c.norm();
      turns[other] += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
    }
    part_is_outer[part] = std::none_of(turns.begin(), turns.end(), [](double x) { return std::abs(x) > kPi; });
  }
  for (std::size_t t = 0; t < n; ++t) outer[t] = part_is_outer[parts.part_of_triangle[t]];
  return outer;
}

OuterSurface outer_surface(const mesh::SurfaceMesh& surface) {
  const std::vector<bool> outer = faces_outer_fluid(surface);
  OuterSurface result;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    if (outer[static_cast<std::size_t>(t)]) result.triangles.push_back(t);
  result.mesh = {surface.vertices_m, mesh::IndexRows(static_cast<Eigen::Index>(result.triangles.size()), 3)};
  for (Eigen::Index row = 0; row < result.mesh.triangles.rows(); ++row)
    result.mesh.triangles.row(row) = surface.triangles.row(result.triangles[static_cast<std::size_t>(row)]).head<3>();
  return result;
}

Eigen::VectorXcd corner_values(const mesh::SurfaceMesh& surface, const OuterSurface& outer,
                               const Eigen::VectorXcd& values) {
  const bool by_triangle = values.size() == surface.triangles.rows();
  KLANG_CHECK(by_triangle || values.size() == surface.vertices_m.rows(), "one value per triangle or per vertex");
  Eigen::VectorXcd corners(3 * outer.mesh.triangles.rows());
  Eigen::Index at = 0;
  for (const Eigen::Index t : outer.triangles)
    for (int c = 0; c < 3; ++c) corners[at++] = values[by_triangle ? t : surface.triangles(t, c)];
  return corners;
}

mesh::SurfaceMesh geodesic_sphere(double radius_m, int n) {
  checked("geodesic_sphere", "radius_m", radius_m, 1e-9, 1e9);
  if (n < 1 || n > 200) throw InputError("geodesic_sphere", "n", std::to_string(n), "1 to 200");
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vector3d> corners;
  for (const double one : {-1.0, 1.0})
    for (const double phi : {-golden, golden}) {
      corners.emplace_back(0.0, one, phi);
      corners.emplace_back(one, phi, 0.0);
      corners.emplace_back(phi, 0.0, one);
    }
  std::vector<std::array<int, 3>> faces;
  const auto joined = [&](int a, int b) { return std::abs((corners[a] - corners[b]).norm() - 2.0) < 1e-9; };
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c)
        if (joined(a, b) && joined(b, c) && joined(a, c)) {
          const bool out = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
          faces.push_back(out ? std::array{a, b, c} : std::array{a, c, b});
        }
  // A vertex is named by its integer weights on the corners: the same on both faces of an edge.
  std::map<std::array<int, 6>, int> numbers;
  std::vector<Vector3d> points;
  const auto vertex = [&](const std::array<int, 3>& face, std::array<int, 3> weights) {
    std::array<std::array<int, 2>, 3> terms;
    for (int i = 0; i < 3; ++i) terms[i] = {weights[i] > 0 ? face[i] : -1, weights[i]};
    std::sort(terms.begin(), terms.end());
    std::array<int, 6> key;
    for (int i = 0; i < 3; ++i) key[2 * i] = terms[i][0], key[2 * i + 1] = terms[i][1];
    const auto [found, fresh] = numbers.try_emplace(key, static_cast<int>(points.size()));
    if (fresh) {
      Vector3d p = Vector3d::Zero();
      for (const auto& [corner, weight] : terms)
        if (weight > 0) p += weight * corners[corner];
      points.push_back(p.normalized());
    }
    return found->second;
  };
  std::vector<std::array<int, 3>> triangles;
  for (const auto& face : faces)
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        const auto at = [&](int u, int v) { return vertex(face, {n - u - v, u, v}); };
        triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < n) triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
  double volume = 0.0;
  for (const auto& t : triangles) volume += points[t[0]].dot(points[t[1]].cross(points[t[2]])) / 6.0;
  const double scale_m = radius_m * std::cbrt(4.0 * kPi / 3.0 / volume);
  mesh::SurfaceMesh surface;
  surface.vertices_m.resize(static_cast<Eigen::Index>(points.size()), 3);
  surface.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    surface.vertices_m.row(static_cast<Eigen::Index>(v)) = scale_m * points[v].transpose();
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (int c = 0; c < 3; ++c) surface.triangles(static_cast<Eigen::Index>(t), c) = triangles[t][c];
  return surface;
}

}  // namespace klang::acoustics
