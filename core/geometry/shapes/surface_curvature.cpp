#include "core/geometry/shapes/surface_curvature.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/geometry/shapes/detail/profile.hpp"

namespace klang::mesh {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Found = std::optional<Matrix3d>;

constexpr double kFlatCosine = 0.9994;  // 2 degrees: a flat face's normal
constexpr double kFacetCosine = 0.978;  // 12 degrees: that of a facet of a round surface
constexpr double kTilt = 0.01;          // of a line that lies on its side
constexpr double kSmoothTurn = 0.35;    // rad between sides of a profile that stand for a curve

Matrix3d across(const Vector3d& normal) { return Matrix3d::Identity() - normal * normal.transpose(); }

/// Of a cuboid about the origin.
Found of_cuboid(const Vector3d& half_m, double edge_m, const Vector3d& place, const Vector3d& outward) {
  Eigen::Index axis = 0;
  if (!(outward.cwiseAbs().maxCoeff(&axis) > kFlatCosine)) return {};
  for (Eigen::Index i = 0; i < 3; ++i)
    if (i != axis && std::abs(place[i]) > half_m[i] - edge_m) return {};
  return Matrix3d::Zero();
}

Found of_ellipsoid(const Vector3d& axes_m, const Vector3d& place) {
  const double out = place.cwiseQuotient(axes_m).norm();
  if (!(out > 0.0)) return {};
  const Vector3d inverse_sq = axes_m.cwiseProduct(axes_m).cwiseInverse(),
                 gradient = inverse_sq.cwiseProduct(place / out);
  const Matrix3d tangents = across(gradient.normalized());
  return Matrix3d(tangents * inverse_sq.asDiagonal() * tangents / gradient.norm());
}

/// A round wall about the z axis: its radius there, negative where the normal points to the axis.
Matrix3d around_axis(const Vector3d& place, double radius_m) {
  const Vector3d along = Vector3d::UnitZ().cross(Vector3d(place.x(), place.y(), 0.0)).normalized();
  return along * along.transpose() / radius_m;
}

struct Cylinder {
  double half_length_m, inner_m, outer_m;  // inner: 0 of a rod
};

Found of_cylinder(const Cylinder& c, double edge_m, const Vector3d& place, const Vector3d& outward) {
  const double r = place.head<2>().norm();
  if (std::abs(outward.z()) > kFlatCosine) {
    if (r > c.outer_m - edge_m || (c.inner_m > 0.0 && r < c.inner_m + edge_m)) return {};
    return Matrix3d::Zero();
  }
  const bool at_rim = std::abs(place.z()) > c.half_length_m - edge_m;
  if (!(r > 0.0) || std::abs(outward.z()) > (at_rim ? kTilt : std::sqrt(1.0 - kFacetCosine * kFacetCosine))) return {};
  const double radial = outward.head<2>().dot(place.head<2>()) / r;
  if (radial > kFacetCosine) return around_axis(place, c.outer_m);
  if (radial < -kFacetCosine && c.inner_m > 0.0) return around_axis(place, -c.inner_m);
  return {};
}

struct Bowl {
  double outer_radius_m, wall_m, depth_m;
};

Found of_bowl(const Bowl& b, double edge_m, const Vector3d& place, const Vector3d& outward) {
  if (place.z() > b.depth_m - edge_m) return {};
  const Vector3d out = (place - Vector3d(0, 0, b.outer_radius_m)).normalized();
  const double along = out.dot(outward);
  if (along > kFacetCosine) return Matrix3d(across(out) / b.outer_radius_m);
  if (along < -kFacetCosine) return Matrix3d(-across(out) / (b.outer_radius_m - b.wall_m));
  return {};
}

double turn(const Vector2d& from, const Vector2d& to) {
  return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
}

/// A polygon turned about the z axis, counter-clockwise in (r, z): outward of a side (dr, dz) is (dz, -dr).
Found of_revolution(const std::vector<Vector2d>& points, double edge_m, const Vector3d& place,
                    const Vector3d& outward) {
  const Vector2d at(place.head<2>().norm(), place.z());
  const Vector3d radial =
      at.x() > 0.0 ? Vector3d(place.x() / at.x(), place.y() / at.x(), 0.0) : Vector3d(Vector3d::UnitX());
  const Vector2d normal = Vector2d(outward.dot(radial), outward.z()).normalized();
  const std::size_t n = points.size();
  const auto side = [&](std::size_t i) { return Vector2d(points[(i + 1) % n] - points[i % n]); };
  std::optional<std::size_t> best;
  double nearest = HUGE_VAL, share = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d s = side(i);
    if (!(Vector2d(s.y(), -s.x()).normalized().dot(normal) > kFacetCosine)) continue;
    const double t = std::clamp((at - points[i]).dot(s) / s.squaredNorm(), 0.0, 1.0);
    if (const double d = (points[i] + t * s - at).norm(); d < nearest) {
      nearest = d;
      best = i;
      share = t;
    }
  }
  if (!best) return {};
  const std::size_t i = *best;
  const Vector2d s = side(i);
  // Along the profile: turning of the side at either end over the lengths that turn; a sharp end near by is an edge.
  double bend = 0.0;
  int n_smooth = 0;
  const std::array<std::pair<std::size_t, double>, 2> ends = {{{i + n - 1, share}, {i + 1, 1.0 - share}}};
  for (const auto& [other, away] : ends) {
    const Vector2d o = side(other);
    const double angle = other > i && other != i + n - 1 ? turn(s, o) : turn(o, s);
    if (std::abs(angle) < kSmoothTurn) {
      bend += angle / (0.5 * (s.norm() + o.norm()));
      ++n_smooth;
    } else if (away * s.norm() < edge_m) {
      return {};
    }
  }
  const Vector2d flat = Vector2d(s.y(), -s.x()).normalized();
  const Vector3d out = flat.x() * radial + flat.y() * Vector3d::UnitZ();
  const Vector3d meridian = s.x() / s.norm() * radial + s.y() / s.norm() * Vector3d::UnitZ(),
                 around = out.cross(meridian);
  const double along = n_smooth > 0 ? bend / n_smooth : 0.0;
  // At the axis both curvatures are one.
  const double about = at.x() > 0.5 * s.norm() ? flat.x() / at.x() : along;
  return Matrix3d(along * meridian * meridian.transpose() + about * around * around.transpose());
}

}  // namespace

SurfaceCurvature surface_curvature(const ShapeSpec& spec, double edge_m) {
  const auto& dims = spec.dims;
  const auto dim = [&](const char* name) { return dims.at(name); };
  if (spec.kind == "box" || spec.kind == "shell_box") {
    const Vector3d half_m = 0.5 * (spec.kind == "box" ? Vector3d(dim("length_m"), dim("width_m"), dim("height_m"))
                                                      : Vector3d(Vector3d::Constant(dim("edge_m"))));
    return [=](const Vector3d& place, const Vector3d& outward) { return of_cuboid(half_m, edge_m, place, outward); };
  }
  if (spec.kind == "sphere" || spec.kind == "ellipsoid") {
    const Vector3d axes_m = spec.kind == "sphere" ? Vector3d(Vector3d::Constant(dim("radius_m")))
                                                  : Vector3d(dim("a_m"), dim("b_m"), dim("c_m"));
    return [=](const Vector3d& place, const Vector3d&) { return of_ellipsoid(axes_m, place); };
  }
  if (spec.kind == "rod" || spec.kind == "tube") {
    const bool tube = spec.kind == "tube";
    const double outer_m = dim(tube ? "outer_radius_m" : "radius_m");
    const Cylinder cylinder{0.5 * dim("length_m"), tube ? outer_m - dim("wall_m") : 0.0, outer_m};
    return
        [=](const Vector3d& place, const Vector3d& outward) { return of_cylinder(cylinder, edge_m, place, outward); };
  }
  if (spec.kind == "bowl") {
    const Bowl bowl{dim("outer_radius_m"), dim("wall_m"), dim("depth_m")};
    return [=](const Vector3d& place, const Vector3d& outward) { return of_bowl(bowl, edge_m, place, outward); };
  }
  if (spec.kind == "revolution" && dims.empty()) {
    return
        [points = detail::read_profile(spec.profile_csv).points_m, edge_m](
            const Vector3d& place, const Vector3d& outward) { return of_revolution(points, edge_m, place, outward); };
  }
  return {};
}

}  // namespace klang::mesh
