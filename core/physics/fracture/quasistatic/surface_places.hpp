#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::fracture {

/// A force [N] at a place [m] of a body's surface, both in the body's frame.
struct PointForce {
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
};

/// A force at a node.
struct NodeForce {
  int node = 0;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
};

/// A point of the meshed surface as a weighted mean of nodes: place = sum w x. A force with these weights has the force's
/// resultant and its moment about any point exactly, as if it acted at place_m.
struct SurfacePlace {
  std::vector<int> nodes;  ///< up to 3 of a straight mesh, up to 6 of a quadratic one: those of weight 0 are left out
  Eigen::VectorXd weights;
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  double distance_m = 0.0;  ///< of the wanted place from it
};

/// The surface of a mesh, made once, to take places to.
class SurfacePlaces {
 public:
  /// Share of the diagonal of the body's box by which a place may lie off the surface (rounded numbers, facets for curves).
  static constexpr double kTolerance = 0.01;

  explicit SurfacePlaces(const mesh::TetMesh& mesh);

  double tolerance_m() const { return tolerance_m_; }
  /// The nearest point of the surface, curved sides taken as they are.
  /// @throws InputError for a place that is not finite or further from the surface, outside or inside, than tolerance_m()
  SurfacePlace at(const Eigen::Vector3d& place_m) const;
  /// The forces at nodes, in the order of nodes, each node once.
  /// @throws InputError as at(), or for a force that is not finite, with the force's number (from 1)
  std::vector<NodeForce> at_nodes(const std::vector<PointForce>& forces) const;

 private:
  mesh::SurfaceMesh surface_;
  double tolerance_m_ = 0.0;
};

/// 3 n_nodes numbers.
Eigen::VectorXd nodal_force_n(const mesh::TetMesh& mesh, const std::vector<NodeForce>& forces);

}  // namespace klang::fracture
