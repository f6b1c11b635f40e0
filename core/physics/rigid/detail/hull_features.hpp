#pragma once
#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace klang::rigid::detail {

/// Faces and edges of a convex polyhedron, from which axes come that may part it from another.
struct HullFeatures {
  struct Edge {
    Eigen::Vector3d from = Eigen::Vector3d::Zero(),
                    along = Eigen::Vector3d::Zero();  ///< a corner, and the way to the other
    Eigen::Vector3d left = Eigen::Vector3d::Zero(), right = Eigen::Vector3d::Zero();  ///< normals of its two faces
    std::array<Eigen::Index, 2> faces{0, 0};  ///< of these normals among the hull's; a hull that is not whole: any
    bool along_turn = false;                  ///< along points as left x right does, not against it
  };
  /// Faces that are one plane to the eye of contacts: corners in turn, seen from outside anticlockwise.
  struct Plate {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset = 0.0;  ///< normal . x
    std::vector<int> corners;
  };
  Eigen::Matrix3Xd corners;
  Eigen::MatrixX3d by_axis;          ///< the same, one per row: heights along a direction are sums of columns
  Eigen::Matrix3Xd normals;          ///< of faces, unit, out of it
  Eigen::MatrixX3d normals_by_axis;  ///< the same, one per row
  Eigen::VectorXd offsets;           ///< normal . x of the face's plane
  std::vector<Edge> edges;
  std::vector<Plate> plates;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mean of the corners
  double size = 0.0;                                 ///< of the farthest corner from the centre
  bool whole = false;                           ///< every edge has its two faces; else edges holds those with one, too
  std::vector<std::vector<int>> edges_of_face;  ///< of a whole hull
  std::vector<std::vector<int>> plates_of_corner;

  /// @param faces  corners of each face in turn; nearly coplanar triangles merged or not. One whose corners lie on a line is no face:
  ///               its neighbours along that line meet there.
  HullFeatures() = default;
  HullFeatures(const Eigen::Matrix3Xd& corners, const std::vector<std::vector<int>>& faces);
};

/// Of corners, one per row, along a direction.
inline double lowest_along(const Eigen::MatrixX3d& by_axis, const Eigen::Vector3d& direction) {
  return (direction.x() * by_axis.col(0) + direction.y() * by_axis.col(1) + direction.z() * by_axis.col(2)).minCoeff();
}

/// Distance of a's nearest corner over b's farthest along a unit normal that points from b to a.
/// @param b_to_a  place of b in a's frame, in which the normal is, too
double gap_along(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                 const Eigen::Vector3d& normal);

}  // namespace klang::rigid::detail
