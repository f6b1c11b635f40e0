#pragma once
#include <Eigen/Core>
#include <functional>
#include <optional>

#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {

/// How a surface bends at a place: k1 e1 e1^T + k2 e2 e2^T [1/m], e1 and e2 tangents along the principal directions, positive where the
/// body is convex. Nothing: an edge, a corner, or no place of the surface with that normal.
using SurfaceCurvature =
    std::function<std::optional<Eigen::Matrix3d>(const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward)>;

/// That of a shape, in closed form; of a revolution along its profile by the turning of neighbouring sides.
/// @param edge_m  places of a flat face that are nearer than that to its rim are edges
/// Places may lie off the surface by what flat facets leave out; normals may differ by a facet's.
SurfaceCurvature surface_curvature(const ShapeSpec& spec, double edge_m);

}  // namespace klang::mesh
