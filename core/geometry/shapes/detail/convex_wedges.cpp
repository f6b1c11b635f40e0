#include "core/geometry/shapes/detail/convex_wedges.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Cell = std::array<Vector2d, 4>;  // (r, z) in turn around the cell

constexpr double kLeftOut = 0.01;  // of the section's extent
constexpr int kSectors = 12;
constexpr int kRingCorners = 32;

double extent_m(const std::vector<SectionPatch>& patches) {
  double extent = 0.0;
  for (const SectionPatch& patch : patches)
    for (const double u : {0.0, 0.5, 1.0})
      for (const double v : {0.0, 0.5, 1.0}) extent = std::max(extent, patch.map(u, v).cwiseAbs().maxCoeff());
  return extent;
}

/// Into how many parts the sides along u (or v) must be cut: the sagitta falls with the square of the number.
int divisions(const SectionPatch& patch, bool along_u, double left_out_m) {
  double sagitta = 0.0;
  for (const double across : {0.0, 1.0}) {
    const auto at = [&](double t) { return along_u ? patch.map(t, across) : patch.map(across, t); };
    for (const double t : {0.25, 0.5, 0.75})
      sagitta = std::max(sagitta, (at(t) - (1.0 - t) * at(0.0) - t * at(1.0)).norm());
  }
  return std::max(1, static_cast<int>(std::ceil(std::sqrt(sagitta / left_out_m))));
}

std::vector<Cell> cells_of(const std::vector<SectionPatch>& patches, double left_out) {
  const double left_out_m = left_out * extent_m(patches);
  std::vector<Cell> cells;
  for (const SectionPatch& patch : patches) {
    const int n_u = divisions(patch, true, left_out_m), n_v = divisions(patch, false, left_out_m);
    for (int i = 0; i < n_u; ++i) {
      for (int j = 0; j < n_v; ++j) {
        const auto at = [&](int a, int b) { return patch.map((i + a) / double(n_u), (j + b) / double(n_v)); };
        cells.push_back({at(0, 0), at(1, 0), at(1, 1), at(0, 1)});
      }
    }
  }
  return cells;
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double area(const std::vector<Vector2d>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * std::abs(twice);
}

/// Andrew's chain, counter-clockwise.
std::vector<Vector2d> hull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  std::vector<Vector2d> chain;
  for (int side = 0; side < 2; ++side) {
    const std::size_t begin = chain.size();
    for (const Vector2d& point : points) {
      while (chain.size() >= begin + 2 && cross(chain.back() - chain[chain.size() - 2], point - chain.back()) <= 0.0)
        chain.pop_back();
      chain.push_back(point);
    }
    chain.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return chain;
}

Eigen::Matrix3Xd columns(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Matrix3Xd matrix(3, static_cast<Eigen::Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) matrix.col(static_cast<Eigen::Index>(i)) = points[i];
  return matrix;
}

void add_arc(const Vector2d& point, const std::vector<double>& angles, std::vector<Eigen::Vector3d>& corners) {
  if (point.x() == 0.0) {
    const Eigen::Vector3d on_axis(0.0, 0.0, point.y());
    if (std::find(corners.begin(), corners.end(), on_axis) == corners.end()) corners.push_back(on_axis);
    return;
  }
  for (const double angle : angles)
    corners.emplace_back(point.x() * std::cos(angle), point.x() * std::sin(angle), point.y());
}

}  // namespace

Eigen::Matrix3Xd cuboid_corners(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m) {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i)
    for (int axis = 0; axis < 3; ++axis) corners(axis, i) = ((i >> axis) & 1) != 0 ? high_m[axis] : low_m[axis];
  return corners;
}

RoundSurface ring(double radius_m, double z_m) {
  RoundSurface surface;
  surface.centre_m.z() = z_m;
  surface.axes_m(0, 0) = surface.axes_m(1, 1) = radius_m;
  return surface;
}

std::vector<RoundSurface> outline_rings(const std::vector<SectionPatch>& patches) {
  constexpr double kFine = 1e-4;
  const double on_axis_m = 1e-9 * extent_m(patches);
  std::vector<Vector2d> both_sides;
  for (const Cell& cell : cells_of(patches, kFine)) {
    for (const Vector2d& point : cell) {
      const double r = std::abs(point.x()) <= on_axis_m ? 0.0 : point.x();
      both_sides.emplace_back(r, point.y());
      both_sides.emplace_back(-r, point.y());
    }
  }
  std::vector<RoundSurface> rings;
  for (const Vector2d& point : hull(both_sides))
    if (point.x() >= 0.0) rings.push_back(ring(point.x(), point.y()));
  return rings;
}

std::vector<Eigen::Matrix3Xd> convex_wedges(const std::vector<SectionPatch>& patches) {
  std::vector<Cell> cells = cells_of(patches, kLeftOut);
  const double on_axis_m = 1e-9 * extent_m(patches);
  double filled_m2 = 0.0;
  std::vector<Vector2d> both_sides;
  for (Cell& cell : cells) {
    for (Vector2d& point : cell) {
      if (std::abs(point.x()) <= on_axis_m) point.x() = 0.0;
      both_sides.push_back(point);
      both_sides.emplace_back(-point.x(), point.y());
    }
    filled_m2 += 2.0 * area({cell.begin(), cell.end()});
  }
  const std::vector<Vector2d> outline = hull(both_sides);
  if (area(outline) <= (1.0 + 1e-6) * filled_m2) {
    std::vector<double> angles;
    for (int i = 0; i < kRingCorners; ++i) angles.push_back(2.0 * kPi * i / kRingCorners);
    std::vector<Eigen::Vector3d> corners;
    for (const Vector2d& point : outline)
      if (point.x() >= 0.0) add_arc(point, angles, corners);
    return {columns(corners)};
  }
  std::vector<Eigen::Matrix3Xd> parts;
  for (const Cell& cell : cells) {
    for (int sector = 0; sector < kSectors; ++sector) {
      std::vector<double> angles;
      for (int half = 0; half < 3; ++half) angles.push_back(kPi * (2 * sector + half) / kSectors);
      std::vector<Eigen::Vector3d> corners;
      for (const Vector2d& point : cell) add_arc(point, angles, corners);
      parts.push_back(columns(corners));
    }
  }
  return parts;
}

}  // namespace klang::mesh::detail
