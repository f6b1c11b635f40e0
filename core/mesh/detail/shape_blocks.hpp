#pragma once
#include <array>
#include <vector>

#include "core/mesh/detail/block_mesh.hpp"
#include "core/mesh/shape.hpp"

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

}  // namespace klang::mesh::detail
