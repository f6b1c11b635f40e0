#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "core/physics/liquid/frames.hpp"

namespace klang::liquid_scene::detail {

/// 1 for each cell whose centre is in a solid: within the liquid with its solids (regions 0, 1, 3) and not within the liquid (0, 1, 2).
/// Cells in the order of x, then y, then z.
std::vector<std::uint8_t> solid_cells(const liquid::LiquidSurface& surface, const Eigen::Vector3d& low_m, double cell_m,
                                      const std::array<int, 3>& n);

}  // namespace klang::liquid_scene::detail
