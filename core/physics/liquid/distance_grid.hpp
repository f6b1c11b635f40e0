#pragma once
#include "core/physics/liquid/frames.hpp"
#include "core/physics/liquid/grid.hpp"

namespace klang::liquid {

/// Signed distance at cell centres to the free part of a liquid's surface (region 0; to all of it where there is none), below 0 in the
/// liquid, to full depth: exact next to the surface, beyond by fast sweeping. Inside is where a line upwards crosses the closed
/// surface (regions 0, 1, 2) an odd number of times. @param low_m  the box's low corner in the surface's coordinates
Field surface_distance(const GridShape& shape, const Eigen::Vector3d& low_m, const LiquidSurface& surface);

/// Makes a distance of any field that is below 0 in the liquid and 0 at its surface (a share of liquid, say), whatever its slope: next to the
/// surface by where straight lines between centres cross it, exact for planes; beyond by fast sweeping.
void distance_from_zero_set(const GridShape& shape, Field& value);

}  // namespace klang::liquid
