#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

namespace klang::fracture {

using TetCorners = std::array<Eigen::Vector3d, 4>;  ///< with the volume (c1-c0) x (c2-c0) . (c3-c0) / 6 above 0

/// What two tetrahedra have in common: a convex polyhedron.
struct TetOverlap {
  double volume_m3 = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< of its volume
  /// Of the volume by the places of the corners, of the first tetrahedron and then of the second: the integral of a corner's shape function times the
  /// normal over what bounds the polyhedron of that corner's faces, exact. They sum to 0, and so do their moments, to round-off.
  std::array<Eigen::Vector3d, 8> gradient_m2;
};

/// Clips the first tetrahedron by the second. None: nothing in common but round-off (1e-14 of the smaller one).
std::optional<TetOverlap> tet_overlap(const TetCorners& first, const TetCorners& second);

/// Directions along which two tetrahedra may lie apart: outward normals of the first's four faces, of the second's, and products of edges.
inline constexpr int kSeparatingAxes = 8 + 36;
/// How far they lie apart along one of them; 0 or less: they do not.
double gap_along_m(const TetCorners& first, const TetCorners& second, int axis);
/// The one along which they are farthest apart. @param faces_only  leaves out products of edges
int widest_axis(const TetCorners& first, const TetCorners& second, bool faces_only);

}  // namespace klang::fracture
