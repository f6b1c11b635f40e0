#pragma once
#include <array>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/geometry/shapes/detail/profile.hpp"

namespace klang::mesh::detail {

/// A flat triangulation; rows counter-clockwise in (r, z).
struct FlatMesh {
  std::vector<Eigen::Vector2d> points_m;
  std::vector<std::array<int, 3>> triangles;
};

/// Delaunay triangulation of the polygon's inside with sides cut to about edge_m.
FlatMesh mesh_profile(const Profile& profile, double edge_m);

/// Each triangle cut into four.
FlatMesh refined(const FlatMesh& mesh);

/// The profile's triangles swept around the z axis. Counts: around (>= 6), divisions of the profile's length
/// scale (edge = longest extent / count), halvings of the flat triangles. The same cut in every sector.
TetMesh mesh_revolution(const Profile& profile, const std::array<int, 3>& counts, int order);

}  // namespace klang::mesh::detail
