#pragma once
#include <array>
#include <vector>

#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh::detail {

struct BlockLayout {
  std::vector<Block> blocks;
  double glue_m = 0.0;  ///< points nearer than this are one node
};

/// The blocks of every kind but revolution, for a validated spec. Counts, each raised to at least what the
/// kind needs:
///   tube        axial, around (>= 6), through the wall
///   rod         axial, along a quarter of the core (its circle has 8 times as many), across the ring
///   box         x, y, z
///   shell_box   along an edge of the hollow (made even), through the wall
///   sphere, ellipsoid   along an octant of the core (a great circle has 8 times as many), across the shell
///   bowl        along a quarter of the core (the rim has 8 times as many), across the ring, through the wall
BlockLayout shape_blocks(const ShapeSpec& spec, const std::array<int, 3>& counts);

/// Grading (block_mesh.hpp, Segment) of a box along its sides. Free edges of plates bend within about their thickness,
/// and the shear of a flat bar's torsion turns round within as much of its edges: cells there are smaller, those in the
/// middle larger, up to 1 + grading times even ones. Bars are even along their length.
std::array<double, 3> box_grading(const std::array<double, 3>& sides_m);

}  // namespace klang::mesh::detail
