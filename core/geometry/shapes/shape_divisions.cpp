#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/profile.hpp"
#include "core/geometry/shapes/detail/shape_blocks.hpp"
#include "core/geometry/shapes/shape.hpp"

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

/// Graded cells are up to 1 + grading times as long as even ones.
int graded_divided(double length_m, double edge_m, double grading) {
  const int even = divided(length_m, edge_m);
  return even <= 2 ? even : divided((1.0 + grading) * length_m, edge_m);
}

/// Counts by the order of the sides: bars (one long side) get them along it and, where they are flat, across, for
/// their torsion; plates (one short side) in both others and four through the thickness, blocks about even ones.
/// Measured: first 15 modes of the plate 100 x 100 x 8, the block 30 x 40 x 50 and the bars 150 x 25 x 10 and 300 x 30
/// x 5 mm within 0.05 %.
std::array<int, 3> default_box(const std::array<double, 3>& sides) {
  std::array<int, 3> rank{0, 1, 2};
  std::stable_sort(rank.begin(), rank.end(), [&](int a, int b) { return sides[a] > sides[b]; });
  const double longest = sides[rank[0]], middle = sides[rank[1]], shortest = sides[rank[2]];
  std::array<int, 3> n;
  n[rank[0]] = 2 * rounded(5.0 + 11.0 * std::min(1.0, 0.08 * longest / shortest), 5, 16);
  if (longest > 4.0 * middle) {
    n[rank[0]] = 2 * rounded(25.0 * std::cbrt(longest / (15.0 * shortest)), 20, 60);
    n[rank[1]] = middle > 1.5 * shortest ? 10 : 6;
    n[rank[2]] = 4;
    return n;
  }
  n[rank[1]] = 2 * rounded(0.5 * n[rank[0]] * middle / longest, 4, 16);
  n[rank[2]] = 2 * rounded(0.5 * n[rank[0]] * shortest / longest, 2, 16);
  return n;
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
      n = {2 * rounded(4.6 * std::sqrt(dim("length_m") / middle_m), 4, 60), 20,
           rounded(4.0 * dim("wall_m") / middle_m, 1, 4)};
  } else if (spec.kind == "rod") {
    const double radius_m = dim("radius_m");
    if (by_edge)
      n = {divided(dim("length_m"), edge_m), divided(0.25 * kPi * radius_m, edge_m), divided(0.5 * radius_m, edge_m)};
    else
      n = {2 * rounded(4.0 * std::sqrt(dim("length_m") / radius_m), 3, 60), 2, 2};
  } else if (spec.kind == "box") {
    const std::array<double, 3> sides{dim("length_m"), dim("width_m"), dim("height_m")};
    const std::array<double, 3> grading = detail::box_grading(sides);
    n = default_box(sides);
    for (int i = 0; by_edge && i < 3; ++i) n[i] = graded_divided(sides[i], edge_m, grading[i]);
  } else if (spec.kind == "shell_box") {
    const double inner_m = dim("edge_m") - 2.0 * dim("wall_m");
    n = by_edge ? std::array<int, 3>{2 * divided(0.5 * inner_m, edge_m), divided(dim("wall_m"), edge_m), 1}
                : std::array<int, 3>{12, rounded(4.0 * dim("wall_m") / inner_m, 1, 4), 1};
  } else if (spec.kind == "sphere" || spec.kind == "ellipsoid") {
    const double largest_m = spec.kind == "sphere" ? dim("radius_m") : std::max({dim("a_m"), dim("b_m"), dim("c_m")});
    if (by_edge)
      n = {divided(0.25 * kPi * largest_m, edge_m), divided(0.5 * largest_m, edge_m), 1};
    else
      n = {4, 3, 1};
  } else if (spec.kind == "bowl") {
    const double outer_m = dim("outer_radius_m"), arc_m = outer_m * std::acos(1.0 - dim("depth_m") / outer_m);
    const double widest_m = dim("depth_m") >= outer_m ? outer_m : outer_m * std::sin(arc_m / outer_m);
    if (by_edge)
      n = {std::max(divided(0.25 * kPi * widest_m, edge_m), divided(0.5 * arc_m, edge_m)), divided(0.5 * arc_m, edge_m),
           divided(dim("wall_m"), edge_m)};
    else
      n = {12, 10, rounded(2.0 * dim("wall_m") / outer_m, 1, 2)};
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
