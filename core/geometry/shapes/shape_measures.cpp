#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/profile.hpp"
#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {
namespace {

/// Volume of a spherical cap of radius r and height h: pi h^2 (3 r - h) / 3.
double cap_volume_m3(double radius_m, double height_m) {
  return kPi * height_m * height_m * (3.0 * radius_m - height_m) / 3.0;
}

/// Legendre's form, a >= b >= c: S = 2 pi c^2 + 2 pi a b (E sin^2 phi + F cos^2 phi) / sin phi, cos phi = c /
/// a.
double ellipsoid_area_m2(double x, double y, double z) {
  std::array<double, 3> axes{x, y, z};
  std::sort(axes.begin(), axes.end());
  const double a = axes[2], b = axes[1], c = axes[0];
  const double sine_sq = (a - c) * (a + c) / (a * a);
  if (sine_sq < 1e-12) return 4.0 * kPi * a * b;  // a sphere to 1e-12
  const double modulus_sq = std::clamp((b - c) * (b + c) / (sine_sq * b * b), 0.0, 1.0);
  const double sine = std::sqrt(sine_sq), phi = std::asin(std::min(1.0, sine));
  const double first = std::ellint_1(std::sqrt(modulus_sq), phi), second = std::ellint_2(std::sqrt(modulus_sq), phi);
  return 2.0 * kPi * c * c + 2.0 * kPi * a * b * (second * sine_sq + first * (c / a) * (c / a)) / sine;
}

}  // namespace

double shape_volume_m3(const ShapeSpec& spec) {
  validate(spec);
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  if (spec.kind == "tube") return kPi * dim("wall_m") * (2.0 * dim("outer_radius_m") - dim("wall_m")) * dim("length_m");
  if (spec.kind == "rod") return kPi * dim("radius_m") * dim("radius_m") * dim("length_m");
  if (spec.kind == "box") return dim("length_m") * dim("width_m") * dim("height_m");
  if (spec.kind == "shell_box") return std::pow(dim("edge_m"), 3) - std::pow(dim("edge_m") - 2.0 * dim("wall_m"), 3);
  if (spec.kind == "sphere") return 4.0 / 3.0 * kPi * std::pow(dim("radius_m"), 3);
  if (spec.kind == "ellipsoid") return 4.0 / 3.0 * kPi * dim("a_m") * dim("b_m") * dim("c_m");
  if (spec.kind == "bowl")
    return cap_volume_m3(dim("outer_radius_m"), dim("depth_m")) -
           cap_volume_m3(dim("outer_radius_m") - dim("wall_m"), dim("depth_m") - dim("wall_m"));
  return detail::profile_volume_m3(detail::read_profile(spec.profile_csv));
}

double shape_area_m2(const ShapeSpec& spec) {
  validate(spec);
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  if (spec.kind == "tube") {
    const double sum = 2.0 * dim("outer_radius_m") - dim("wall_m");  // of both radii
    return 2.0 * kPi * sum * (dim("length_m") + dim("wall_m"));
  }
  if (spec.kind == "rod") return 2.0 * kPi * dim("radius_m") * (dim("radius_m") + dim("length_m"));
  if (spec.kind == "box")
    return 2.0 *
           (dim("length_m") * dim("width_m") + dim("width_m") * dim("height_m") + dim("height_m") * dim("length_m"));
  if (spec.kind == "shell_box") {
    const double inner = dim("edge_m") - 2.0 * dim("wall_m");
    return 6.0 * (dim("edge_m") * dim("edge_m") + inner * inner);
  }
  if (spec.kind == "sphere") return 4.0 * kPi * dim("radius_m") * dim("radius_m");
  if (spec.kind == "ellipsoid") return ellipsoid_area_m2(dim("a_m"), dim("b_m"), dim("c_m"));
  if (spec.kind == "bowl") {
    // Caps 2 pi r h, and the flat rim between the circles in its plane.
    const double outer = dim("outer_radius_m"), wall = dim("wall_m"), depth = dim("depth_m");
    return 2.0 * kPi * (outer * depth + (outer - wall) * (depth - wall)) + kPi * wall * (2.0 * outer - wall);
  }
  return detail::profile_area_m2(detail::read_profile(spec.profile_csv));
}

}  // namespace klang::mesh
