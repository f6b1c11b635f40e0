#include "core/sound/dual_domain/boundary_patches.hpp"

#include <algorithm>
#include <cmath>

namespace klang::bubble {

using Eigen::Vector3d;

void BoundaryPatches::add(const Patch& patch, double h_m, const std::function<Vector3d(const Vector3d& x_m)>& moved) {
  const auto n_along = [&](const Vector3d& side) {
    return std::max(1, static_cast<int>(std::lround(side.norm() / h_m)));
  };
  const int nu = n_along(patch.u_m), nv = n_along(patch.v_m);
  const int first = static_cast<int>(vertices_.size());
  for (int j = 0; j <= nv; ++j)
    for (int i = 0; i <= nu; ++i) {
      const Vector3d x = patch.corner_m + patch.u_m * i / nu + patch.v_m * j / nv;
      vertices_.push_back(moved ? moved(x) : x);
    }
  for (int j = 0; j < nv; ++j)
    for (int i = 0; i < nu; ++i) {
      const int a = first + j * (nu + 1) + i, b = a + 1, c = a + nu + 1, d = c + 1;
      const bool even = (i + j) % 2 == 0;
      triangles_.emplace_back(a, b, even ? d : c);
      triangles_.emplace_back(even ? a : b, d, c);
      region_.insert(region_.end(), 2, patch.region);
    }
}

void BoundaryPatches::add_tank(const Vector3d& low_m, const Vector3d& size_m, double h_m,
                               const std::function<Vector3d(const Vector3d& x_m)>& moved) {
  const Vector3d x(size_m.x(), 0, 0), y(0, size_m.y(), 0), z(0, 0, size_m.z());
  add({low_m + z, x, y, 0}, h_m, moved);
  for (const Patch& rigid :
       {Patch{low_m, y, x, 1}, {low_m, x, z, 1}, {low_m + y, z, x, 1}, {low_m, z, y, 1}, {low_m + x, y, z, 1}})
    add(rigid, h_m, moved);
}

BoundaryMesh BoundaryPatches::mesh(const std::string& name) const {
  BoundaryMesh mesh;
  mesh.name = name;
  mesh.region = region_;
  mesh.surface.vertices_m.resize(static_cast<Eigen::Index>(vertices_.size()), 3);
  for (std::size_t i = 0; i < vertices_.size(); ++i)
    mesh.surface.vertices_m.row(static_cast<Eigen::Index>(i)) = vertices_[i].transpose();
  mesh.surface.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
  for (std::size_t i = 0; i < triangles_.size(); ++i)
    mesh.surface.triangles.row(static_cast<Eigen::Index>(i)) = triangles_[i].transpose();
  return mesh;
}

}  // namespace klang::bubble
