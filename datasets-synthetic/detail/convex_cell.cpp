#include "datasets-synthetic/detail/convex_cell.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace klang::datasets::detail {
namespace {

double size_of(const ConvexCell& cell) {
  double size = 0.0;
  for (const Eigen::Vector3d& v : cell.vertices_m) size = std::max(size, (v - cell.vertices_m[0]).norm());
  return size;
}

/// The points of a plane convex polygon in counter-clockwise order seen along -normal.
void sort_around(std::vector<int>& loop, const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& normal) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const int i : loop) middle += points[static_cast<std::size_t>(i)] / static_cast<double>(loop.size());
  const Eigen::Vector3d e = normal.unitOrthogonal(), f = normal.cross(e);
  const auto angle = [&](int i) {
    const Eigen::Vector3d d = points[static_cast<std::size_t>(i)] - middle;
    return std::atan2(d.dot(f), d.dot(e));
  };
  std::sort(loop.begin(), loop.end(), [&](int a, int b) { return angle(a) < angle(b); });
}

}  // namespace

double ConvexCell::volume_m3() const {
  if (empty()) return 0.0;
  const Eigen::Vector3d from = vertices_m[static_cast<std::size_t>(faces[0][0])];
  double six = 0.0;
  for (const auto& face : faces)
    for (std::size_t c = 1; c + 1 < face.size(); ++c) {
      const Eigen::Vector3d a = vertices_m[static_cast<std::size_t>(face[0])] - from,
                            b = vertices_m[static_cast<std::size_t>(face[c])] - from,
                            d = vertices_m[static_cast<std::size_t>(face[c + 1])] - from;
      six += a.dot(b.cross(d));
    }
  return six / 6.0;
}

double ConvexCell::shortest_edge_m() const {
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& face : faces)
    for (std::size_t c = 0; c < face.size(); ++c)
      shortest = std::min(shortest, (vertices_m[static_cast<std::size_t>(face[c])] -
                                     vertices_m[static_cast<std::size_t>(face[(c + 1) % face.size()])])
                                        .norm());
  return shortest;
}

ConvexCell box_cell(const Eigen::Vector3d& size_m) {
  ConvexCell cell;
  for (int i = 0; i < 8; ++i)
    cell.vertices_m.push_back(
        0.5 * size_m.cwiseProduct(Eigen::Vector3d(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0)));
  cell.faces = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  return cell;
}

ConvexCell clipped(const ConvexCell& cell, const Eigen::Vector3d& normal, double offset_m) {
  if (cell.empty()) return cell;
  const double near = 1e-12 * size_of(cell);
  std::vector<double> height;
  for (const Eigen::Vector3d& v : cell.vertices_m) {
    const double h = normal.dot(v) - offset_m;
    height.push_back(std::abs(h) <= near ? 0.0 : h);
  }
  double lowest = 0.0, highest = 0.0;  // of the vertices in use: those that earlier cuts took off are still in the list
  for (const auto& face : cell.faces)
    for (const int v : face) {
      lowest = std::min(lowest, height[static_cast<std::size_t>(v)]);
      highest = std::max(highest, height[static_cast<std::size_t>(v)]);
    }
  if (highest == 0.0) return cell;
  if (lowest == 0.0) return {};
  ConvexCell out{cell.vertices_m, {}};
  std::map<std::pair<int, int>, int> cut;  // the edge's point on the plane, the same for both of its faces
  const auto point_on = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [it, fresh] = cut.try_emplace({a, b}, static_cast<int>(out.vertices_m.size()));
    if (fresh) {
      const double ha = height[static_cast<std::size_t>(a)], hb = height[static_cast<std::size_t>(b)],
                   t = ha / (ha - hb);
      out.vertices_m.push_back((1.0 - t) * cell.vertices_m[static_cast<std::size_t>(a)] +
                               t * cell.vertices_m[static_cast<std::size_t>(b)]);
    }
    return it->second;
  };
  std::vector<int> cap;
  for (const auto& face : cell.faces) {
    std::vector<int> kept;
    bool inside = false;
    for (std::size_t c = 0; c < face.size(); ++c) {
      const int a = face[c], b = face[(c + 1) % face.size()];
      const double ha = height[static_cast<std::size_t>(a)], hb = height[static_cast<std::size_t>(b)];
      inside = inside || ha < 0.0;
      if (ha <= 0.0) kept.push_back(a);
      if (ha == 0.0) cap.push_back(a);
      if ((ha < 0.0 && hb > 0.0) || (ha > 0.0 && hb < 0.0)) {
        kept.push_back(point_on(a, b));
        cap.push_back(kept.back());
      }
    }
    if (inside) out.faces.push_back(std::move(kept));
  }
  std::sort(cap.begin(), cap.end());
  cap.erase(std::unique(cap.begin(), cap.end()), cap.end());
  sort_around(cap, out.vertices_m, normal);
  out.faces.push_back(std::move(cap));
  return out;
}

std::vector<ConvexCell> voronoi_cells(const Eigen::Vector3d& box_m, const std::vector<Eigen::Vector3d>& seeds_m) {
  std::vector<ConvexCell> cells;
  for (const Eigen::Vector3d& seed : seeds_m) {
    ConvexCell cell = box_cell(box_m);
    // The nearest first, and none that is too far to cut anything.
    std::vector<std::size_t> others(seeds_m.size());
    std::iota(others.begin(), others.end(), 0u);
    std::stable_sort(others.begin(), others.end(), [&](std::size_t a, std::size_t b) {
      return (seeds_m[a] - seed).norm() < (seeds_m[b] - seed).norm();
    });
    for (std::size_t k = 1; k < others.size() && !cell.empty(); ++k) {
      const Eigen::Vector3d& other = seeds_m[others[k]];
      const double distance = (other - seed).norm();
      double radius = 0.0;
      for (const auto& face : cell.faces)
        for (const int v : face)
          radius = std::max(radius, (cell.vertices_m[static_cast<std::size_t>(v)] - seed).norm());
      if (distance > 2.0 * radius) break;
      const Eigen::Vector3d normal = (other - seed) / distance;
      cell = clipped(cell, normal, normal.dot(0.5 * (seed + other)));
    }
    cells.push_back(std::move(cell));
  }
  return cells;
}

mesh::SurfaceMesh surface_of(const ConvexCell& cell) {
  std::vector<int> row(cell.vertices_m.size(), -1);
  int n_rows = 0, n_triangles = 0;
  for (const auto& face : cell.faces) {
    n_triangles += static_cast<int>(face.size()) - 2;
    for (const int v : face)
      if (row[static_cast<std::size_t>(v)] < 0) row[static_cast<std::size_t>(v)] = n_rows++;
  }
  mesh::SurfaceMesh surface{mesh::Points(n_rows, 3), mesh::IndexRows(n_triangles, 3)};
  for (std::size_t v = 0; v < row.size(); ++v)
    if (row[v] >= 0) surface.vertices_m.row(row[v]) = cell.vertices_m[v];
  int t = 0;
  for (const auto& face : cell.faces)
    for (std::size_t c = 1; c + 1 < face.size(); ++c)
      surface.triangles.row(t++) << row[static_cast<std::size_t>(face[0])], row[static_cast<std::size_t>(face[c])],
          row[static_cast<std::size_t>(face[c + 1])];
  return surface;
}

}  // namespace klang::datasets::detail
