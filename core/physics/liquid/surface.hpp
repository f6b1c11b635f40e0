#pragma once
#include <functional>

#include "core/physics/liquid/frames.hpp"
#include "core/physics/liquid/grid.hpp"

namespace klang::liquid {

/// The surface of the liquid in a box with walls and solids: marching tetrahedra on Kuhn's split of the cubes between cell centres, with one
/// layer of wall around. Each centre is liquid (phi < 0), air, solid (solid_m < 0 goes first) or wall; a tetrahedron that holds several of
/// them is cut into its shares, so that where three meet they share their line. Closed, oriented and without edges of more than two
/// triangles, as liquid (regions 0, 1, 2) and as liquid with the solids (0, 1, 3), for any phi.
/// @param solid_m  distance to the solids at centres, below 0 inside; empty: none
LiquidSurface liquid_surface(const GridShape& shape, const Field& phi_m, const Field& solid_m);

}  // namespace klang::liquid
