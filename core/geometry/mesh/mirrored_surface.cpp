#include "core/geometry/mesh/mirrored_surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <unordered_map>
#include <utility>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/triangle_distance.hpp"

namespace klang::mesh {
namespace {

using Eigen::Vector3d;

constexpr double kOnPlane = 1e-9;  ///< of the body's size

std::array<Vector3d, 3> corner_points(const SurfaceMesh& surface, Eigen::Index t) {
  std::array<Vector3d, 3> p;
  for (int c = 0; c < 3; ++c) p[c] = surface.vertices_m.row(surface.triangles(t, c)).transpose();
  return p;
}

/// Triangles by the cubic cells that their boxes touch.
class Cells {
 public:
  Cells(const SurfaceMesh& surface, double reach_m) : surface_(surface), reach_m_(reach_m) {
    double edges_m = 0.0;
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      const auto p = corner_points(surface, t);
      edges_m += (p[1] - p[0]).norm();
    }
    cell_m_ = std::max(edges_m / static_cast<double>(surface.triangles.rows()), 4.0 * reach_m);
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
      const auto p = corner_points(surface, t);
      const auto low = cell(p[0].cwiseMin(p[1]).cwiseMin(p[2]).array() - reach_m),
                 high = cell(p[0].cwiseMax(p[1]).cwiseMax(p[2]).array() + reach_m);
      for (long x = low[0]; x <= high[0]; ++x)
        for (long y = low[1]; y <= high[1]; ++y)
          for (long z = low[2]; z <= high[2]; ++z) lists_[key({x, y, z})].push_back(t);
    }
  }

  bool near(const Vector3d& p) const {
    const auto found = lists_.find(key(cell(p)));
    return found != lists_.end() && std::any_of(found->second.begin(), found->second.end(), [&](Eigen::Index t) {
             return distance_sq(p, corner_points(surface_, t)) <= reach_m_ * reach_m_;
           });
  }

 private:
  using Cell = std::array<long, 3>;
  Cell cell(const Vector3d& p) const {
    Cell at;
    for (int axis = 0; axis < 3; ++axis) at[axis] = std::lround(std::floor(p[axis] / cell_m_));
    return at;
  }
  static std::size_t key(const Cell& c) {  // cells that share a key only cost time
    std::size_t h = 0;
    for (const long x : c) h = (h ^ static_cast<std::size_t>(x)) * 0x9e3779b97f4a7c15ULL;
    return h ^ (h >> 29);
  }
  const SurfaceMesh& surface_;
  double reach_m_, cell_m_ = 0.0;
  std::unordered_map<std::size_t, std::vector<Eigen::Index>> lists_;
};

Eigen::Matrix<double, 3, 2> box_of(const SurfaceMesh& surface) {
  Eigen::Matrix<double, 3, 2> box;
  box.col(0).setConstant(HUGE_VAL);
  box.col(1).setConstant(-HUGE_VAL);
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (const Vector3d& p : corner_points(surface, t)) {
      box.col(0) = box.col(0).cwiseMin(p);
      box.col(1) = box.col(1).cwiseMax(p);
    }
  return box;
}

/// The part of a surface at or above a plane across an axis, open there.
SurfaceMesh upper_part(const SurfaceMesh& surface, int axis, double level_m, double on_m) {
  std::vector<Vector3d> points(static_cast<std::size_t>(surface.vertices_m.rows()));
  for (std::size_t v = 0; v < points.size(); ++v) {
    points[v] = surface.vertices_m.row(static_cast<Eigen::Index>(v)).transpose();
    if (std::abs(points[v][axis] - level_m) <= on_m) points[v][axis] = level_m;
  }
  std::map<std::pair<int, int>, int> cuts;
  const auto cut = [&](int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [found, fresh] = cuts.try_emplace({a, b}, static_cast<int>(points.size()));
    if (fresh) {
      const double share = (level_m - points[a][axis]) / (points[b][axis] - points[a][axis]);
      Vector3d x = points[a] + share * (points[b] - points[a]);
      x[axis] = level_m;
      points.push_back(x);
    }
    return found->second;
  };
  std::vector<std::array<int, 3>> kept;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    std::vector<int> polygon;
    bool above = false;
    for (int c = 0; c < 3; ++c) {
      const int v = surface.triangles(t, c), next = surface.triangles(t, (c + 1) % 3);
      const double here = points[v][axis] - level_m, there = points[next][axis] - level_m;
      above |= here > 0.0;
      if (here >= 0.0) polygon.push_back(v);
      if (here * there < 0.0) polygon.push_back(cut(v, next));
    }
    if (!above) continue;
    for (std::size_t i = 2; i < polygon.size(); ++i) kept.push_back({polygon[0], polygon[i - 1], polygon[i]});
  }
  SurfaceMesh part;
  part.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
  std::vector<int> number(points.size(), -1);
  std::vector<Vector3d> used;
  for (std::size_t t = 0; t < kept.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      int& n = number[static_cast<std::size_t>(kept[t][c])];
      if (n < 0) {
        n = static_cast<int>(used.size());
        used.push_back(points[static_cast<std::size_t>(kept[t][c])]);
      }
      part.triangles(static_cast<Eigen::Index>(t), c) = n;
    }
  part.vertices_m.resize(static_cast<Eigen::Index>(used.size()), 3);
  for (std::size_t v = 0; v < used.size(); ++v) part.vertices_m.row(static_cast<Eigen::Index>(v)) = used[v].transpose();
  return part;
}

/// Moves what lies on planes but for round-off onto them. Bit 0, 1, 2: the vertex lies on the plane across x, y, z.
std::vector<int> settle_on_planes(SurfaceMesh& part, const MirrorPlanes& planes, double on_m) {
  std::vector<int> on(static_cast<std::size_t>(part.vertices_m.rows()), 0);
  for (std::size_t v = 0; v < on.size(); ++v)
    for (const int axis : planes.axes) {
      double& x = part.vertices_m(static_cast<Eigen::Index>(v), axis);
      if (std::abs(x - planes.middle_m[axis]) > on_m) continue;
      x = planes.middle_m[axis];
      on[v] |= 1 << axis;
    }
  return on;
}

/// @param axes_of_vertex  as settle_on_planes() gives them
MirroredSurface with_images(const SurfaceMesh& part, const MirrorPlanes& planes,
                            const std::vector<int>& axes_of_vertex) {
  MirroredSurface result;
  result.planes = planes;
  const int n = static_cast<int>(part.vertices_m.rows());
  const Eigen::Index n_triangles = part.triangles.rows();
  const int n_images = planes.n_images();
  std::vector<int> on(static_cast<std::size_t>(n), 0);  // bit i: plane i
  for (int v = 0; v < n; ++v)
    for (std::size_t i = 0; i < planes.axes.size(); ++i) on[v] |= (axes_of_vertex[v] >> planes.axes[i] & 1) << i;
  result.n_own_vertices = n;
  std::vector<std::vector<int>> at(static_cast<std::size_t>(n_images), std::vector<int>(static_cast<std::size_t>(n)));
  std::vector<std::pair<int, int>> made;  // image and vertex of the part
  for (int g = 0; g < n_images; ++g)
    for (int v = 0; v < n; ++v) {
      const int first = g & ~on[v];  // a vertex on a plane is its own image there
      if (first == g) made.emplace_back(g, v);
      at[g][v] = first == g ? static_cast<int>(made.size()) - 1 : at[first][v];
    }
  result.surface.vertices_m.resize(static_cast<Eigen::Index>(made.size()), 3);
  result.vertex_image.assign(static_cast<std::size_t>(n_images), std::vector<int>(made.size()));
  for (std::size_t w = 0; w < made.size(); ++w) {
    const auto [g, v] = made[w];
    result.surface.vertices_m.row(static_cast<Eigen::Index>(w)) =
        planes.reflected(part.vertices_m.row(v).transpose(), g).transpose();
    for (int image = 0; image < n_images; ++image) result.vertex_image[image][w] = at[g ^ image][v];
  }
  result.surface.triangles.resize(n_images * n_triangles, 3);
  for (int g = 0; g < n_images; ++g)
    for (Eigen::Index t = 0; t < n_triangles; ++t)
      for (int c = 0; c < 3; ++c)
        result.surface.triangles(g * n_triangles + t, c) = at[g][part.triangles(t, turns_over(g) ? (3 - c) % 3 : c)];
  return result;
}

}  // namespace

Vector3d MirrorPlanes::reflected(const Vector3d& x, int image) const {
  Vector3d result = x;
  for (std::size_t i = 0; i < axes.size(); ++i)
    if ((image >> i & 1) != 0) result[axes[i]] = 2.0 * middle_m[axes[i]] - x[axes[i]];
  return result;
}

bool turns_over(int image) {
  bool odd = false;
  for (; image != 0; image &= image - 1) odd = !odd;
  return odd;
}

MirrorPlanes mirror_planes(const SurfaceMesh& surface, double tolerance_m) {
  MirrorPlanes planes;
  if (surface.triangles.rows() == 0) return planes;
  const Eigen::Matrix<double, 3, 2> box = box_of(surface);
  planes.middle_m = 0.5 * (box.col(0) + box.col(1));
  const Cells cells(surface, std::max(tolerance_m, kOnPlane * (box.col(1) - box.col(0)).norm()));
  for (int axis = 0; axis < 3; ++axis) {
    const MirrorPlanes one{planes.middle_m, {axis}};
    bool same = true;
    for (Eigen::Index t = 0; t < surface.triangles.rows() && same; ++t)
      for (const Vector3d& p : corner_points(surface, t)) same = same && cells.near(one.reflected(p, 1));
    if (same) planes.axes.push_back(axis);
  }
  return planes;
}

std::optional<MirroredSurface> mirrored_coarsened(const SurfaceMesh& surface, CoarseningOptions options,
                                                  const MirrorPlanes& planes) {
  if (planes.axes.empty()) return {};
  const Eigen::Matrix<double, 3, 2> box = box_of(surface);
  const double on_m = kOnPlane * (box.col(1) - box.col(0)).norm();
  SurfaceMesh part{surface.vertices_m, surface.triangles.leftCols(3)};
  for (const int axis : planes.axes) part = upper_part(part, axis, planes.middle_m[axis], on_m);
  const std::vector<int> open_at = settle_on_planes(part, planes, on_m);
  for (int attempt = 0; attempt < 3; ++attempt) {
    SurfaceMesh coarse = coarsened(part, options, open_at);
    const std::vector<int> on = settle_on_planes(coarse, planes, on_m);
    MirroredSurface result = with_images(coarse, planes, on);
    try {
      check_closed_surface(result.surface, "mirrored surface");
      return result;
    } catch (const InputError&) {
      options.tolerance_m *= 0.25;
    }
  }
  return {};
}

}  // namespace klang::mesh
