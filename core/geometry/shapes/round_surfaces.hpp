#pragma once
#include <vector>

#include "core/geometry/mesh/round_surface.hpp"
#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {

/// What the hull of a round body is the hull of, so that a plane can touch it exactly: rings of a body of revolution (a round profile by
/// rings close enough that chords leave out 1e-4 of its extent), a bowl's sphere, an ellipsoid. Other bodies have none. @throws InputError for a bad spec
std::vector<RoundSurface> round_surfaces(const ShapeSpec& spec);

}  // namespace klang::mesh
