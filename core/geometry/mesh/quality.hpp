#pragma once
#include <optional>
#include <string>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// What a mesh is worth. Angles, ratios and edges are those of the straight corner tetrahedra; volume, area
/// and Jacobian are those of the curved elements.
struct MeshQuality {
  int n_nodes = 0;
  int n_elements = 0;
  int order = 0;
  double min_dihedral_deg = 0.0;  ///< regular tetrahedron: 70.53
  double max_dihedral_deg = 0.0;
  double radius_ratio_min = 0.0;  ///< 3 x insphere radius / circumsphere radius: 1 regular, 0 flat
  double radius_ratio_mean = 0.0;
  int worst_element = 0;             ///< 0-based, of the smallest radius ratio
  double min_scaled_jacobian = 0.0;  ///< smallest det J over its mean in the element; 1 straight, <= 0 folded
  int most_curved_element = 0;       ///< where that is
  double volume_m3 = 0.0;
  double surface_area_m2 = 0.0;
  double shortest_edge_m = 0.0;
  double longest_edge_m = 0.0;

  double mass_kg(double density_kg_m3) const { return density_kg_m3 * volume_m3; }
  /// One line: counts, worst angle and ratio, volume, area.
  std::string brief() const;
};

/// @throws InputError for a mesh without elements
MeshQuality mesh_quality(const TetMesh& mesh);

/// Volume [m^3] of the curved elements, exact (det J is a cubic polynomial).
double mesh_volume_m3(const TetMesh& mesh);
/// Surface [m^2] of the curved triangles, by a 25-point rule.
double surface_area_m2(const SurfaceMesh& surface);

/// The first element whose Jacobian is not positive at one of its nodes and inner points; none for a sound
/// mesh.
std::optional<int> first_folded_element(const TetMesh& mesh);

/// The node, or the node on the boundary, nearest to a point; the lowest index among equals.
/// @throws InputError for a point that is not finite or a mesh without nodes
int nearest_node(const TetMesh& mesh, const Eigen::Vector3d& point_m);
int nearest_surface_node(const TetMesh& mesh, const Eigen::Vector3d& point_m);

}  // namespace klang::mesh
