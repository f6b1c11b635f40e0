#pragma once
#include <map>
#include <string>

#include "core/geometry/shapes/shape.hpp"

/// Bodies that are drawn as a profile, and what of them can be changed (docs/shapes.md). Each dimension may stand in spec.dims.
namespace klang::mesh {

/// Dimensions as drawn, whatever spec.dims says: size_m, and wall_N_m of each zone of the wall. Empty for kinds without a profile.
std::map<std::string, double> drawn_dimensions_m(const ShapeSpec& spec);

/// The profile with spec.dims applied, as a file of r_m, z_m, zone. @throws InputError for a kind without a profile
std::string profile_csv(const ShapeSpec& spec);

}  // namespace klang::mesh
