#include "core/physics/liquid/solid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"

namespace klang::liquid {

using Eigen::Vector3d;

Vector3d SolidKeys::position_at(double t) const {
  const auto later = std::upper_bound(time_s.begin(), time_s.end(), t);
  if (later == time_s.begin()) return position_m.front();
  if (later == time_s.end()) return position_m.back();
  const auto i = static_cast<std::size_t>(later - time_s.begin());
  const double share = (t - time_s[i - 1]) / (time_s[i] - time_s[i - 1]);
  return (1.0 - share) * position_m[i - 1] + share * position_m[i];
}

double Solid::distance_m(const Vector3d& x_m) const {
  const Vector3d d = x_m - position_m;
  switch (shape) {
    case SolidShape::kSphere:
      return d.norm() - radius_m;
    case SolidShape::kHalfSpace:
      return d.dot(normal);
    case SolidShape::kBox: {
      const Vector3d q = d.cwiseAbs() - 0.5 * size_m;
      return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
    }
    case SolidShape::kCylinder: {
      const double along = d.dot(normal), across = (d - along * normal).norm();
      const double qa = std::abs(along) - 0.5 * size_m.x(), qr = across - radius_m;
      return std::hypot(std::max(qa, 0.0), std::max(qr, 0.0)) + std::min(std::max(qa, qr), 0.0);
    }
  }
  return std::numeric_limits<double>::infinity();
}

bool Solid::is_outside(const Vector3d& size) const {
  switch (shape) {
    case SolidShape::kSphere:
      return (position_m - position_m.cwiseMax(0.0).cwiseMin(size)).norm() >= radius_m;
    case SolidShape::kHalfSpace: {
      double least = std::numeric_limits<double>::infinity();
      for (int c = 0; c < 8; ++c)
        least = std::min(least, distance_m(Vector3d((c & 1) != 0 ? size.x() : 0.0, (c & 2) != 0 ? size.y() : 0.0,
                                                    (c & 4) != 0 ? size.z() : 0.0)));
      return least >= 0.0;
    }
    default: {
      const Vector3d low = position_m - 0.5 * size_m, high = position_m + 0.5 * size_m;
      return (low.array() >= size.array()).any() || (high.array() <= 0.0).any();
    }
  }
}

double Solid::volume_m3() const {
  return shape == SolidShape::kSphere ? 4.0 / 3.0 * kPi * radius_m * radius_m * radius_m : size_m.prod();
}

double Solid::outer_radius_m() const {
  switch (shape) {
    case SolidShape::kSphere:
      return radius_m;
    case SolidShape::kBox:
      return 0.5 * size_m.norm();
    case SolidShape::kCylinder:
      return std::hypot(radius_m, 0.5 * size_m.x());
    case SolidShape::kHalfSpace:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

double positive_area(double a, double b, double c, double d) {
  const auto triangle = [](double p, double q, double r) {  // share of a triangle that is positive
    if (p > q) std::swap(p, q);
    if (q > r) std::swap(q, r);
    if (p > q) std::swap(p, q);
    if (p >= 0.0) return 1.0;
    if (r <= 0.0) return 0.0;
    if (q <= 0.0) return r / (r - p) * (r / (r - q));
    return 1.0 - p / (p - q) * (p / (p - r));
  };
  // Halves along both diagonals, so that no direction is preferred.
  return 0.25 * (triangle(a, b, c) + triangle(a, c, d) + triangle(a, b, d) + triangle(b, c, d));
}

namespace {

constexpr double kOnSurface = 1e-9;  // [cells]

double least_distance_m(const std::vector<Solid>& solids, const Vector3d& x_m) {
  double least = HUGE_VAL;
  for (const Solid& solid : solids) least = std::min(least, solid.distance_m(x_m));
  return least;
}

std::array<double, 4> corners_of_face(const Field& s, int axis, int i, int j, int k) {
  if (axis == 0) return {s(i, j, k), s(i, j + 1, k), s(i, j + 1, k + 1), s(i, j, k + 1)};
  if (axis == 1) return {s(i, j, k), s(i + 1, j, k), s(i + 1, j, k + 1), s(i, j, k + 1)};
  return {s(i, j, k), s(i + 1, j, k), s(i + 1, j + 1, k), s(i, j + 1, k)};
}

/// Where all corners lie on surfaces of solids the middle says: a face is closed on the surface of one and within a plate of one cell, open in
/// a slit of one.
double open_share(const std::array<double, 4>& corner_m, const std::vector<Solid>& solids, const Vector3d& middle_m,
                  double cell_m) {
  if (std::any_of(corner_m.begin(), corner_m.end(), [](double d) { return d != 0.0; }))
    return positive_area(corner_m[0], corner_m[1], corner_m[2], corner_m[3]);
  return least_distance_m(solids, middle_m) > kOnSurface * cell_m ? 1.0 : 0.0;
}

/// @param middle_m  distance of the cell's middle
double open_volume(const Field& s, const std::array<int, 3>& cell, double middle_m, double h) {
  const auto [i, j, k] = cell;
  double low = HUGE_VAL, high = -HUGE_VAL;
  for (int c = 0; c < 8; ++c) {
    const double value = s(i + (c & 1), j + ((c >> 1) & 1), k + (c >> 2));
    low = std::min(low, value);
    high = std::max(high, value);
  }
  if (low == 0.0 && high == 0.0) return middle_m > 0.0 ? 1.0 : 0.0;  // a slit, or a plate, of one cell
  if (low >= 0.0) return 1.0;
  if (high <= 0.0) return 0.0;
  constexpr int kSub = 4;
  double sum = 0.0;
  for (int c = 0; c < kSub; ++c)
    for (int b = 0; b < kSub; ++b)
      for (int a = 0; a < kSub; ++a)
        sum += std::clamp(
            0.5 + kSub / h * trilinear(s, i + (a + 0.5) / kSub, j + (b + 0.5) / kSub, k + (c + 0.5) / kSub), 0.0, 1.0);
  return sum / (kSub * kSub * kSub);
}

}  // namespace

SolidField solid_field(const GridShape& shape, const std::vector<Solid>& solids) {
  SolidField field;
  field.any = !solids.empty();
  field.distance_m = Field(shape.nx + 1, shape.ny + 1, shape.nz + 1, 1e3 * shape.cell_m);
  field.nearest = Grid3<int>(shape.nx, shape.ny, shape.nz, -1);
  field.open_volume = Field(shape.nx, shape.ny, shape.nz, 1.0);
  field.open = MacGrid(shape);
  const double h = shape.cell_m;
  if (field.any) {
    parallel_for(static_cast<std::size_t>(shape.nz) + 1, 1, [&](std::size_t begin, std::size_t) {
      const int k = static_cast<int>(begin);
      for (int j = 0; j <= shape.ny; ++j)
        for (int i = 0; i <= shape.nx; ++i) {
          double& distance = field.distance_m(i, j, k);
          for (const Solid& solid : solids) distance = std::min(distance, solid.distance_m(h * Vector3d(i, j, k)));
          if (std::abs(distance) < kOnSurface * h) distance = 0.0;  // whatever rounding says
        }
    });
    parallel_for(static_cast<std::size_t>(shape.nz), 1, [&](std::size_t begin, std::size_t) {
      const int k = static_cast<int>(begin);
      for (int j = 0; j < shape.ny; ++j)
        for (int i = 0; i < shape.nx; ++i) {
          double best = HUGE_VAL;
          for (std::size_t s = 0; s < solids.size(); ++s) {
            const double distance = solids[s].distance_m(shape.centre_m(i, j, k));
            if (distance < best) {
              best = distance;
              field.nearest(i, j, k) = static_cast<int>(s);
            }
          }
          field.open_volume(i, j, k) = open_volume(field.distance_m, {i, j, k}, best, h);
        }
    });
  }
  for (int axis = 0; axis < 3; ++axis) {
    Field& open = field.open[axis];
    parallel_for(static_cast<std::size_t>(open.nz()), 1, [&](std::size_t begin, std::size_t) {
      const int k = static_cast<int>(begin);
      for (int j = 0; j < open.ny(); ++j)
        for (int i = 0; i < open.nx(); ++i) {
          const int along = axis == 0 ? i : axis == 1 ? j : k;
          if (along == 0 || along == shape.n(axis)) continue;  // the box's walls
          Vector3d middle = h * Vector3d(i + 0.5, j + 0.5, k + 0.5);
          middle[axis] -= 0.5 * h;
          const double share =
              field.any ? open_share(corners_of_face(field.distance_m, axis, i, j, k), solids, middle, h) : 1.0;
          // Between two cells that are solid all through nothing flows, whatever corners that lie on the solid's surface say.
          const bool inside =
              field.open_volume(i, j, k) <= 0.0 &&
              field.open_volume(i - (axis == 0 ? 1 : 0), j - (axis == 1 ? 1 : 0), k - (axis == 2 ? 1 : 0)) <= 0.0;
          open(i, j, k) = inside || share < 1e-3 ? 0.0 : share;
        }
    });
  }
  return field;
}

SolidField sector_field(const GridShape& shape) {
  SolidField field = solid_field(shape, {});
  field.round = true;
  const double per = 1.0 / shape.nx;
  for (int k = 0; k <= shape.nz; ++k)
    for (int i = 0; i <= shape.nx; ++i) {
      if (k < shape.nz) field.open[0](i, 0, k) *= per * i;
      if (i == shape.nx) continue;
      field.open[2](i, 0, k) *= per * (i + 0.5);
      if (k < shape.nz) field.open_volume(i, 0, k) = per * (i + 0.5);
    }
  return field;
}

}  // namespace klang::liquid
