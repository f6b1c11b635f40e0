#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/mesh/surface_coarsening.hpp"

namespace klang::mesh {

/// Planes x, y or z = constant through the middle of a body's bounding box, in each of which the body is its own image.
/// Images are numbered by bits: bit i of g says that g reflects at plane i.
struct MirrorPlanes {
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  std::vector<int> axes;  ///< normals: 0 x, 1 y, 2 z, ascending

  int n_images() const { return 1 << axes.size(); }
  Eigen::Vector3d reflected(const Eigen::Vector3d& x, int image) const;
};

/// The planes at which the image of every vertex lies within tolerance_m of the surface.
MirrorPlanes mirror_planes(const SurfaceMesh& surface, double tolerance_m);

/// A closed surface that is made of the images of its first part: vertices 0 to n_own_vertices - 1 and triangles 0 to
/// n_own_triangles - 1.
struct MirroredSurface {
  MirrorPlanes planes;
  SurfaceMesh surface;  ///< row g n_own_triangles + t is image g of triangle t, corners 1 and 2 exchanged for odd g
  int n_own_vertices = 0;
  std::vector<std::vector<int>> vertex_image;  ///< [g][v]: where image g of each vertex of the whole is
  int n_own_triangles() const { return static_cast<int>(surface.triangles.rows()) / planes.n_images(); }
};

/// Whether an image turns triangles over: an odd number of reflections.
bool turns_over(int image);

/// As checked_coarsened: one of the parts that the planes cut the surface into is coarsened, vertices on the planes staying
/// there, and the others are its images. Nothing where there are no planes, or where the result does not close.
std::optional<MirroredSurface> mirrored_coarsened(const SurfaceMesh& surface, CoarseningOptions options,
                                                  const MirrorPlanes& planes);

}  // namespace klang::mesh
