#include "core/physics/liquid/distance_grid.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/physics/liquid/level_set.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Distance to a triangle (its plane, edges or corners).
double triangle_distance(const Vector3d& x, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d ab = b - a, ac = c - a, n = ab.cross(ac);
  const double area = n.squaredNorm();
  if (area > 0.0) {
    const Vector3d ax = x - a;
    const double v = ax.cross(ac).dot(n) / area, w = ab.cross(ax).dot(n) / area;
    if (v >= 0.0 && w >= 0.0 && v + w <= 1.0) return std::abs(ax.dot(n)) / std::sqrt(area);
  }
  const auto edge = [&](const Vector3d& p, const Vector3d& q) {
    const Vector3d d = q - p;
    const double length = d.squaredNorm();
    const double t = length > 0.0 ? std::clamp((x - p).dot(d) / length, 0.0, 1.0) : 0.0;
    return (x - p - t * d).norm();
  };
  return std::min({edge(a, b), edge(b, c), edge(c, a)});
}

/// On which side of the line from p to q a point lies; the same for both triangles of an edge.
bool left_of(const Vector3d& p, const Vector3d& q, const Vector2d& x) {
  const bool turn = std::lexicographical_compare(q.data(), q.data() + 3, p.data(), p.data() + 3);
  const Vector3d& a = turn ? q : p;
  const Vector3d& b = turn ? p : q;
  const double side = (b.x() - a.x()) * (x.y() - a.y()) - (b.y() - a.y()) * (x.x() - a.x());
  return (side >= 0.0) != turn;
}

class Voxeliser {
 public:
  Voxeliser(const GridShape& shape, const Vector3d& low_m, const LiquidSurface& surface)
      : shape_(shape), low_(low_m), surface_(surface) {
    for (const int region : surface.region) any_free_ = any_free_ || region == 0;
  }

  Field run() {
    const double reach = shape_.size_m().norm();
    Field phi(shape_.nx, shape_.ny, shape_.nz, reach);
    std::vector<std::vector<double>> crossings(static_cast<std::size_t>(shape_.nx) * shape_.ny);
    for (Eigen::Index t = 0; t < surface_.surface.triangles.rows(); ++t) {
      const int region = surface_.region.empty() ? 0 : surface_.region[static_cast<std::size_t>(t)];
      if (region == 0 || !any_free_) near(t, phi);
      if (region != 3) cross(t, crossings);
    }
    for (int j = 0; j < shape_.ny; ++j)
      for (int i = 0; i < shape_.nx; ++i) {
        auto& column = crossings[static_cast<std::size_t>(i) + static_cast<std::size_t>(shape_.nx) * j];
        std::sort(column.begin(), column.end());
        std::size_t passed = 0;
        for (int k = 0; k < shape_.nz; ++k) {
          const double z = low_.z() + (k + 0.5) * shape_.cell_m;
          while (passed < column.size() && column[passed] < z) ++passed;
          if (passed % 2 == 1) phi(i, j, k) = -phi(i, j, k);
        }
      }
    redistance(shape_, 1.5 * shape_.cell_m, reach, phi);
    return phi;
  }

 private:
  Vector3d corner(Eigen::Index t, int c) const {
    return surface_.surface.vertices_m.row(surface_.surface.triangles(t, c)).transpose();
  }
  /// Cells whose centres are within a margin of an interval.
  std::pair<int, int> cells(double low, double high, int axis, double margin) const {
    const double h = shape_.cell_m;
    const auto to_cell = [&](double x) { return std::clamp(x, -1e6, 1e6); };
    return {
        std::max(0, static_cast<int>(std::ceil(to_cell((low - margin - low_[axis]) / h - 0.5)))),
        std::min(shape_.n(axis) - 1, static_cast<int>(std::floor(to_cell((high + margin - low_[axis]) / h - 0.5))))};
  }

  void near(Eigen::Index t, Field& phi) const {
    const Vector3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const Vector3d least = a.cwiseMin(b).cwiseMin(c), most = a.cwiseMax(b).cwiseMax(c);
    const double margin = 2.0 * shape_.cell_m;
    const auto [i0, i1] = cells(least.x(), most.x(), 0, margin);
    const auto [j0, j1] = cells(least.y(), most.y(), 1, margin);
    const auto [k0, k1] = cells(least.z(), most.z(), 2, margin);
    for (int k = k0; k <= k1; ++k)
      for (int j = j0; j <= j1; ++j)
        for (int i = i0; i <= i1; ++i) {
          const double distance = triangle_distance(low_ + shape_.centre_m(i, j, k), a, b, c);
          if (distance < margin) phi(i, j, k) = std::min(phi(i, j, k), distance);
        }
  }

  void cross(Eigen::Index t, std::vector<std::vector<double>>& crossings) const {
    const Vector3d p[3] = {corner(t, 0), corner(t, 1), corner(t, 2)};
    const Vector3d least = p[0].cwiseMin(p[1]).cwiseMin(p[2]), most = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    const auto [i0, i1] = cells(least.x(), most.x(), 0, shape_.cell_m);
    const auto [j0, j1] = cells(least.y(), most.y(), 1, shape_.cell_m);
    const Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) {
        // Beside the centre by next to nothing: surfaces made on a grid have their corners there.
        const Vector2d x(low_.x() + (i + 0.5 + 0.37e-7) * shape_.cell_m,
                         low_.y() + (j + 0.5 + 0.71e-7) * shape_.cell_m);
        const bool first = left_of(p[0], p[1], x);
        if (left_of(p[1], p[2], x) != first || left_of(p[2], p[0], x) != first) continue;
        double z = (p[0].z() + p[1].z() + p[2].z()) / 3.0;
        if (std::abs(normal.z()) > 0.0)
          z = p[0].z() - (normal.x() * (x.x() - p[0].x()) + normal.y() * (x.y() - p[0].y())) / normal.z();
        crossings[static_cast<std::size_t>(i) + static_cast<std::size_t>(shape_.nx) * j].push_back(
            std::clamp(z, least.z(), most.z()));
      }
  }

  const GridShape& shape_;
  const Vector3d low_;
  const LiquidSurface& surface_;
  bool any_free_ = false;
};

}  // namespace

void distance_from_zero_set(const GridShape& shape, Field& value) {
  const double h = shape.cell_m, reach = shape.size_m().norm();
  Field distance(shape.nx, shape.ny, shape.nz, reach);
  for (int k = 0; k < shape.nz; ++k)
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        const double here = value(i, j, k);
        double inverse_sq = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          double nearest = HUGE_VAL;
          for (const int step : {-1, 1}) {
            const double there =
                value.clamped(i + (axis == 0 ? step : 0), j + (axis == 1 ? step : 0), k + (axis == 2 ? step : 0));
            if ((here < 0.0) != (there < 0.0))
              nearest = std::min(nearest, h * std::abs(here) / (std::abs(here) + std::abs(there)));
          }
          if (nearest < HUGE_VAL) inverse_sq += 1.0 / std::max(nearest * nearest, 1e-18 * h * h);
        }
        if (inverse_sq > 0.0) distance(i, j, k) = 1.0 / std::sqrt(inverse_sq);
        if (here < 0.0) distance(i, j, k) = -distance(i, j, k);
      }
  redistance(shape, 1.5 * h, reach, distance);
  value = std::move(distance);
}

Field surface_distance(const GridShape& shape, const Vector3d& low_m, const LiquidSurface& surface) {
  return Voxeliser(shape, low_m, surface).run();
}

}  // namespace klang::liquid
