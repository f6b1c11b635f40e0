#pragma once
#include <vector>

#include "core/geometry/mesh/round_surface.hpp"
#include "core/geometry/shapes/shape_kind.hpp"

namespace klang::mesh::detail {

/// The eight corners between two opposite ones.
Eigen::Matrix3Xd cuboid_corners(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m);

/// Convex pieces of a body of revolution: the whole body as one hull of rings where its section with its mirror image is
/// convex; else the cells of the section turned through a twelfth of a turn. Round sides of the section are cut until chords leave
/// out less than 1 % of its extent.
std::vector<Eigen::Matrix3Xd> convex_wedges(const std::vector<SectionPatch>& patches);

/// A circle about the z axis.
RoundSurface ring(double radius_m, double z_m);
/// Rings of which the hull of the body of revolution is the hull; round sides are cut until chords leave out 1e-4 of its extent.
std::vector<RoundSurface> outline_rings(const std::vector<SectionPatch>& patches);

}  // namespace klang::mesh::detail
