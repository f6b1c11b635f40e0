#pragma once
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace klang::rigid::detail {

/// Faces and edges of a convex polyhedron, from which axes come that may part it from another.
struct HullFeatures {
  struct Edge {
    Eigen::Vector3d from = Eigen::Vector3d::Zero(),
                    along = Eigen::Vector3d::Zero();  ///< a corner, and the way to the other
    Eigen::Vector3d left = Eigen::Vector3d::Zero(), right = Eigen::Vector3d::Zero();  ///< normals of its two faces
    std::array<Eigen::Index, 2> faces{0, 0};  ///< of these normals among the hull's; a hull that is not whole: any
  };
  /// Faces that are one plane to the eye of contacts: corners in turn, seen from outside anticlockwise.
  struct Plate {
    Eigen::Vector3d normal = Eigen::Vector3d::Zero();
    double offset = 0.0;  ///< normal . x
    std::vector<int> corners;
  };
  Eigen::Matrix3Xd corners;
  Eigen::MatrixX3d by_axis;  ///< the same, one per row: heights along a direction are sums of columns
  Eigen::Matrix3Xd normals;  ///< of faces, unit, out of it
  Eigen::VectorXd offsets;   ///< normal . x of the face's plane
  std::vector<Edge> edges;
  std::vector<Plate> plates;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< mean of the corners
  double size = 0.0;                                 ///< of the farthest corner from the centre
  bool whole = false;  ///< every edge has its two faces; else edges holds those with one, too

  /// @param faces  corners of each face in turn; nearly coplanar triangles merged or not. One whose corners lie on a line is no face:
  ///               its neighbours along that line meet there.
  HullFeatures() = default;
  HullFeatures(const Eigen::Matrix3Xd& corners, const std::vector<std::vector<int>>& faces);
};

/// The axis along which two hulls overlap least.
struct HullAxis {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, from b to a, in the frame of the call
  double gap = 0.0;                                   ///< along it; negative: overlap
  std::optional<std::array<std::size_t, 2>> edges;    ///< of a and of b, where they cross; nothing: a face's normal
};

/// Distance of a's nearest corner over b's farthest along a unit normal that points from b to a.
/// @param b_to_a  place of b in a's frame, in which the normal is, too
double gap_along(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                 const Eigen::Vector3d& normal);

/// What is known of two hulls that touched a step ago, and spares work. The result is the same without, whatever it says.
struct HullHint {
  Eigen::Vector3d on_a = Eigen::Vector3d::Zero();  ///< a point of a, near where they touch, in a's frame
  Eigen::Vector3d on_b = Eigen::Vector3d::Zero();  ///< a point of b, in b's frame
  double gap = -HUGE_VAL;                          ///< along any axis
};

/// By the faces of the Minkowski difference: faces of either hull, and pairs of edges whose arcs of normals cross (Gregorius 2013,
/// "The separating axis test between convex polyhedra"). Ends at the first axis along which the two
/// are farther apart than near.
/// @param b_to_a  place of b in a's frame; the result is in a's frame
HullAxis hull_axis(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a, double near = 0.0,
                   const HullHint* hint = nullptr);

}  // namespace klang::rigid::detail
