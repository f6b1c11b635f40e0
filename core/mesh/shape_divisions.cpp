#include <algorithm>
#include <cmath>

#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"
#include "core/mesh/detail/block_mesh.hpp"
#include "core/mesh/detail/profile.hpp"
#include "core/mesh/shape.hpp"

namespace klang::mesh {
namespace {

void check_options(const ShapeMeshOptions& options) {
  const std::string place = "shape mesh options";
  if (options.order != 1 && options.order != 2)
    throw InputError(place, "order", std::to_string(options.order), "1 or 2");
  checked(place, "max_edge_m", options.max_edge_m, 0.0, 1e6);
  checked(place, "wavelength_m", options.wavelength_m, 0.0, 1e6);
  checked(place, "elements_per_wavelength", options.elements_per_wavelength, 0.5, 1000.0);
  if (options.refinement < 0 || options.refinement > 8)
    throw InputError(place, "refinement", std::to_string(options.refinement), "0 to 8");
}

/// The longest edge asked for, 0 where none was.
double wanted_edge_m(const ShapeMeshOptions& options) {
  double edge_m = options.max_edge_m;
  if (options.wavelength_m > 0.0) {
    const double from_wavelength =
        options.wavelength_m / (options.elements_per_wavelength * (options.order == 1 ? 2.0 : 1.0));
    edge_m = edge_m > 0.0 ? std::min(edge_m, from_wavelength) : from_wavelength;
  }
  return edge_m;
}

/// Divisions of a length by an edge length; checked before it becomes an int.
int divided(double length_m, double edge_m, int at_least = 1) {
  const double count = std::ceil(length_m / edge_m * (1.0 - 1e-12));
  if (!(count <= 1e6))
    throw InputError("shape mesh options", "edge length too small", to_text(edge_m), "up to 1e6 divisions");
  return std::max(at_least, static_cast<int>(count));
}

int rounded(double count, int low, int high) {
  return static_cast<int>(std::clamp(std::round(count), static_cast<double>(low), static_cast<double>(high)));
}

}  // namespace

ShapeDivisions shape_divisions(const ShapeSpec& spec, const ShapeMeshOptions& options) {
  validate(spec);
  check_options(options);
  const double edge_m = wanted_edge_m(options);
  const bool by_edge = edge_m > 0.0;
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  std::array<int, 3> n{1, 1, 1};

  if (spec.kind == "tube") {
    const double middle_m = dim("outer_radius_m") - 0.5 * dim("wall_m");
    if (by_edge)
      n = {divided(dim("length_m"), edge_m), divided(2.0 * kPi * dim("outer_radius_m"), edge_m, 12),
           divided(dim("wall_m"), edge_m)};
    else
      n = {rounded(2.0 * dim("length_m") / middle_m, 8, 48), 16,
           rounded(4.0 * dim("wall_m") / middle_m, 1, 3)};
  } else if (spec.kind == "rod") {
    const double radius_m = dim("radius_m");
    if (by_edge)
      n = {divided(dim("length_m"), edge_m), divided(0.25 * kPi * radius_m, edge_m),
           divided(0.5 * radius_m, edge_m)};
    else
      n = {rounded(1.5 * dim("length_m") / radius_m, 4, 40), dim("length_m") > 8.0 * radius_m ? 1 : 2, 1};
  } else if (spec.kind == "box") {
    const std::array<double, 3> sides{dim("length_m"), dim("width_m"), dim("height_m")};
    const double longest = *std::max_element(sides.begin(), sides.end());
    const double volume_edge = std::cbrt(sides[0] * sides[1] * sides[2]);
    for (int i = 0; i < 3; ++i)
      n[i] = by_edge ? divided(sides[i], edge_m)
                     : 2 * rounded(0.5 * std::min(24.0 * sides[i] / longest, 5.0 * sides[i] / volume_edge), 1,
                                   16);
    if (!by_edge)
      for (int i = 0; i < 3; ++i)
        if (sides[i] < 0.15 * longest) n[i] = 1;
  } else if (spec.kind == "shell_box") {
    const double inner_m = dim("edge_m") - 2.0 * dim("wall_m");
    n = by_edge ? std::array<int, 3>{2 * divided(0.5 * inner_m, edge_m), divided(dim("wall_m"), edge_m), 1}
                : std::array<int, 3>{8, rounded(4.0 * dim("wall_m") / inner_m, 1, 3), 1};
  } else if (spec.kind == "sphere" || spec.kind == "ellipsoid") {
    const double largest_m =
        spec.kind == "sphere" ? dim("radius_m") : std::max({dim("a_m"), dim("b_m"), dim("c_m")});
    if (by_edge)
      n = {divided(0.25 * kPi * largest_m, edge_m), divided(0.5 * largest_m, edge_m), 1};
    else
      n = {2, 2, 1};
  } else if (spec.kind == "bowl") {
    const double outer_m = dim("outer_radius_m"), arc_m = outer_m * std::acos(1.0 - dim("depth_m") / outer_m);
    const double widest_m = dim("depth_m") >= outer_m ? outer_m : outer_m * std::sin(arc_m / outer_m);
    if (by_edge)
      n = {std::max(divided(0.25 * kPi * widest_m, edge_m), divided(0.5 * arc_m, edge_m)),
           divided(0.5 * arc_m, edge_m), divided(dim("wall_m"), edge_m)};
    else
      n = {4, 4, rounded(2.0 * dim("wall_m") / outer_m, 1, 2)};
  } else {
    const detail::Profile profile = detail::read_profile(spec.profile_csv);
    Eigen::Vector2d low = profile.points_m[0], high = low;
    double perimeter_m = 0.0, area_m2 = 0.0;
    for (std::size_t i = 0; i < profile.points_m.size(); ++i) {
      const Eigen::Vector2d& a = profile.points_m[i];
      const Eigen::Vector2d& b = profile.points_m[(i + 1) % profile.points_m.size()];
      low = low.cwiseMin(a);
      high = high.cwiseMax(a);
      perimeter_m += (b - a).norm();
      area_m2 += 0.5 * (a.x() * b.y() - a.y() * b.x());
    }
    const double extent_m = (high - low).maxCoeff();
    const double thickness_m = 2.0 * area_m2 / perimeter_m;
    if (by_edge)
      n = {divided(2.0 * kPi * high.x(), edge_m, 12), divided(extent_m, edge_m), 0};
    else
      n = {24, rounded(std::max(8.0, 0.5 * extent_m / thickness_m), 8, 60), 0};
    n[0] <<= options.refinement;
    n[2] = options.refinement;
    detail::check_element_count(static_cast<double>(n[0]) * n[1]);
    return {n};
  }
  double n_cells = 1.0;
  for (int& count : n) {
    n_cells *= std::ldexp(count, options.refinement);
    detail::check_element_count(n_cells);
    count <<= options.refinement;
  }
  return {n};
}

}  // namespace klang::mesh
