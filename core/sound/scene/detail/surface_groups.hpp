#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/surface_point.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::scene::detail {

/// A surface at rest in groups of some 32 triangles near one another, each within a ball: where the nearest point is looked for.
class SurfaceGroups {
 public:
  SurfaceGroups() = default;
  explicit SurfaceGroups(const mesh::SurfaceMesh& surface);
  /// As mesh::nearest_surface_point() of the whole surface; of equal ones one of the first group. @throws InputError where it has no triangles
  mesh::SurfacePoint nearest(const Eigen::Vector3d& point_m) const;
  /// Triangles, ascending, of groups that come within a distance of a point; all that do are among them.
  std::vector<Eigen::Index> near(const Eigen::Vector3d& point_m, double distance_m) const;

 private:
  struct Group {
    std::vector<Eigen::Index> triangles;
    mesh::SurfaceMesh part;
    std::vector<int> vertices;  ///< of the surface: for those of the part
    Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
    double reach_m = 0.0;
  };
  std::vector<Group> groups_;
};

}  // namespace klang::scene::detail
