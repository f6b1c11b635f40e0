#include "core/sound/dual_domain/detail/liquid_functions.hpp"

#include <algorithm>
#include <cmath>

namespace klang::bubble::detail {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;

FluidFunctions::FluidFunctions(Complex k, int order, const std::vector<Vector3d>& points,
                               const std::vector<Vector3d>& solid)
    : k_(k), points_(points), solid_(solid) {
  if (order >= 0) rows_.emplace(order, k);
}

Index FluidFunctions::size() const { return n_regular() + kQuadrupoleSize * static_cast<Index>(solid_.size()); }
std::optional<RegularRows::Scratch> FluidFunctions::scratch() const {
  return rows_ ? std::optional(rows_->scratch()) : std::nullopt;
}

void FluidFunctions::row(const Vector3d& x, const Vector3d* normal, std::optional<RegularRows::Scratch>& scratch,
                         double* out) const {
  const double k = k_.real();
  regular_row(k, x, normal, scratch, out);
  out += n_regular();
  std::array<Complex, kQuadrupoleSize> wave;
  for (const Vector3d& point : solid_) {
    if (normal == nullptr) {
      singular_quadrupole(k, x - point, wave.data());
    } else {
      singular_quadrupole_slopes(k, x - point, *normal, wave.data());
    }
    for (const Complex& value : wave) *out++ = -value.imag();  // h^(2) = j - i y
  }
}

void FluidFunctions::row(const Vector3d& x, const Vector3d* normal, std::optional<RegularRows::Scratch>& scratch,
                         Complex* out) const {
  regular_row(k_, x, normal, scratch, out);
  out += n_regular();
  for (const Vector3d& point : solid_) {
    standing_quadrupole(k_, x - point, normal, out);
    out += kQuadrupoleSize;
  }
}

Index FluidFunctions::n_regular() const {
  return rows_ ? rows_->size() : kQuadrupoleSize * static_cast<Index>(points_.size());
}

template <class Number, class Scalar>
void FluidFunctions::regular_row(Number k, const Vector3d& x, const Vector3d* normal,
                                 std::optional<RegularRows::Scratch>& scratch, Scalar* out) const {
  if (rows_) {
    if (normal == nullptr) {
      rows_->values(x - points_[0], *scratch, out);
    } else {
      rows_->slopes(x - points_[0], *normal, *scratch, out);
    }
    return;
  }
  for (std::size_t s = 0; s < points_.size(); ++s, out += kQuadrupoleSize) {
    if (normal == nullptr) {
      regular_quadrupole(k, x - points_[s], out);
    } else {
      regular_quadrupole_slopes(k, x - points_[s], *normal, out);
    }
  }
}

Complex incident(const FluidField& field, const Vector3d& x, const Vector3d* normal) {
  const auto one = [&](const Vector3d& at) {
    return normal == nullptr ? monopole(field.wavenumber_per_m, x - at)
                             : monopole_slope(field.wavenumber_per_m, x - at, *normal);
  };
  Complex sum = one(field.bubble_m);
  for (const FluidField::Image& image : field.images) sum += image.amplitude * one(image.position_m);
  return sum;
}

namespace {

/// Image in the nearest point of a region. Before a plane it is the mirror image, of a pressure-release ball of radius A the
/// exact static one: with the distance d, at A d / (A - d) behind the surface, amplitude A / (A - d). The curvature is that of
/// samples up to 2 d around (walls: plane). It fades out between a quarter and half of the radius of the liquid, and is left out
/// where it would stand in the liquid (a crown, a dimple).
std::optional<FluidField::Image> image_of(const LiquidBoundary& boundary, const Vector3d& x, bool free_surface) {
  const std::optional<Vector3d> nearest = boundary.nearest_point_m(x, free_surface);
  if (!nearest) return std::nullopt;
  const double distance = (*nearest - x).norm(), full = 0.25 * boundary.radius_m();
  const double fade = std::clamp((2.0 * full - distance) / full, 0.0, 1.0);
  if (!(fade > 0.0) || !(distance > 0.0)) return std::nullopt;
  const Vector3d out = (*nearest - x) / distance;
  double above = 0.0, weight = 0.0;  // height = curvature / 2 rho^2 by least squares
  if (free_surface) {
    for (const BoundarySample& s : boundary.samples()) {
      const Vector3d r = s.point_m - *nearest;
      const double near = 1.0 - r.squaredNorm() / (4.0 * distance * distance);
      if (s.region != BoundaryRegion::kFreeSurface || near <= 0.0 || s.normal.dot(out) < 0.3) continue;
      const double height = r.dot(out), rho_sq = r.squaredNorm() - height * height, w = near * near * s.area_m2;
      above += w * rho_sq * height;
      weight += 0.5 * w * rho_sq * rho_sq;
    }
  }
  const double curvature = weight > 0.0 ? std::clamp(above / weight, -0.8 / distance, 2.0 / distance) : 0.0;
  const double stretch = 1.0 / (1.0 + distance * curvature);
  const Vector3d at = *nearest + stretch * distance * out;
  if (boundary.inside_liquid(at) || boundary.distance_m(at) < 0.5 * distance * stretch) return std::nullopt;
  return FluidField::Image{at, free_surface ? -fade * stretch : fade};
}

}  // namespace

void add_images(const LiquidBoundary& boundary, FluidField& field) {
  const auto free = image_of(boundary, field.bubble_m, true), rigid = image_of(boundary, field.bubble_m, false);
  if (free) field.images.push_back(*free);
  if (!rigid) return;
  field.images.push_back(*rigid);
  if (!free) return;
  const Vector3d across = (rigid->position_m - field.bubble_m).normalized();
  const Vector3d wall = 0.5 * (rigid->position_m + field.bubble_m);
  const Vector3d both = free->position_m - 2.0 * across.dot(free->position_m - wall) * across;
  if (!boundary.inside_liquid(both) && boundary.distance_m(both) > 0.5 * (wall - field.bubble_m).norm())
    field.images.push_back({both, free->amplitude * rigid->amplitude});
}

}  // namespace klang::bubble::detail
