#pragma once
#include <functional>
#include <vector>

#include "core/geometry/shapes/detail/profile.hpp"
#include "core/geometry/shapes/shape_kind.hpp"

namespace klang::mesh::detail {

/// Divisions of a length into elements no longer than edge_m. @throws InputError where its square is too many
int section_divided(double length_m, double edge_m, int at_least = 1);

/// Layers at a free end that double from thick_m on until they are as long as edge_m, or an eighth of the body.
int section_layers(double thick_m, double length_m, double edge_m);

/// Borders of n even cells of [0, length] between layers that double in length from the ends on, the first thick_m long:
/// at a free end of a thin wall the plate's edge layer is as wide as the wall.
std::vector<double> layered_borders(double length_m, double thick_m, int n, int layers_low, int layers_high);

/// Piecewise linear through the borders, s on [0, 1] with an equal part for each cell.
double along(const std::vector<double>& border, double s);

/// The rectangle inner_m to outer_m in r, length_m in z about 0; n: axial, radial, layers at an end.
std::vector<SectionPatch> straight_section(double length_m, double inner_m, double outer_m,
                                           const std::array<int, 3>& n);

/// Half a unit disk (x >= 0) as four patches of a square and its surroundings, placed by a map; the point's polar map is
/// smooth in each.
std::vector<SectionPatch> half_disk(int n, const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& place);

/// The polygon's triangles of edge_m, three quadrilaterals each.
std::vector<SectionPatch> profile_patches(const Profile& profile, double edge_m);

}  // namespace klang::mesh::detail
