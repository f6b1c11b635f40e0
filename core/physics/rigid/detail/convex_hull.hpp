#pragma once
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::rigid::detail {

/// Triangles with outward normals around the corners, by Bullet's exact integer hull. Corners inside are left out.
/// @throws InputError where the corners span no volume
mesh::SurfaceMesh convex_hull(const Eigen::Matrix3Xd& corners_m);

}  // namespace klang::rigid::detail
