#pragma once
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/pattern/pattern.hpp"
#include "core/physics/rigid/rigid_body.hpp"

namespace klang::fracture {

/// A piece, in the frame of the body that it comes from.
struct FragmentBody {
  mesh::TetMesh
      mesh;  ///< straight, as it was cut: thin tetrahedra beside cracks; for mass and for breaking again after remeshing
  std::vector<int> element;  ///< of the body that broke, by element of mesh
  double volume_m3 = 0.0;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre
  std::vector<rigid::ConvexPart> parts;                     ///< what collides
  /// By how much the parts are larger than the piece, as a share of them: 0 for cells of convex parts, up to 1e-4 of rounding. What
  /// has more collides where nothing is.
  double concavity = 0.0;
};

/// The pieces of a body. Where a piece is a cell of planes, its convex parts are those of the body clipped by the cell's half-spaces (each goes to the
/// piece whose elements are nearest to its middle), else the hulls of what of it lies in each of the body's parts: 60 directions' farthest
/// corners. Of a body of one part, one hull: 200 directions' farthest corners.
/// @param parts  convex parts of the body; empty: of each piece the hull
std::vector<FragmentBody> fragment_bodies(const FracturePattern& pattern, const std::vector<rigid::ConvexPart>& parts,
                                          double density_kg_m3);
/// The same without what collides, for patterns that are only tried: parts of round bodies take far longer than all the rest.
std::vector<FragmentBody> fragment_bodies(const FracturePattern& pattern, double density_kg_m3);
void give_parts(const FracturePattern& pattern, const std::vector<rigid::ConvexPart>& parts,
                std::vector<FragmentBody>& bodies);

/// A closed surface of the piece for a mesher (mesh::mesh_surface): thin triangles beside cracks are collapsed into ones of about
/// edge_m as long as no vertex leaves the planes that it stands for by more than 1e-6 of the piece's size. Where a piece touches
/// itself along an edge no mesher takes it: mesh::check_closed_surface says so.
mesh::SurfaceMesh fragment_surface(const FragmentBody& piece, double edge_m);

}  // namespace klang::fracture
