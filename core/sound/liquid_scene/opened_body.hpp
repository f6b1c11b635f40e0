#pragma once
#include "core/physics/liquid/frames.hpp"
#include "core/physics/liquid/grid.hpp"

namespace klang::liquid_scene {

/// A frame's liquid without what is thinner than twice a radius (jets, sheets, drops, crests): what balls of this radius in the liquid reach
/// (morphological opening by distances; walls count as liquid). Craters stay. Waves of few functions follow such a surface, and a bubble
/// in the body hardly hears the rest: a thin jet's sides let pressure go.
/// @param solid_m  distance to solids at centres; empty: none
liquid::LiquidSurface opened_surface(const liquid::LiquidFrames& frames, std::size_t frame,
                                     const liquid::GridShape& shape, double radius_m, const liquid::Field& solid_m);

}  // namespace klang::liquid_scene
