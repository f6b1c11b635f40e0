#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/fracture/quasistatic/stress_field.hpp"
#include "core/physics/fracture/quasistatic/surface_places.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::fracture {

/// The tension by which a body breaks, from a field of element stresses.
///
/// A tabulated strength is the stress at the surface of a bent bar or plate. An element's mean is not that: through one element it is
/// about half of it. Here the elements' stresses at a corner, weighted by volume, are averaged at that node, which for a plate of two
/// quadratic elements through its thickness t and edges of t gives plate theory's stress across from a load within some 5 %.
///
/// A point force has a stress of its own besides, which grows without bound as the mesh is refined and is the contact's (rings and
/// cones), not the body's: what it makes in a half-space, |F| / (2 pi r^2), weighted by kOwnTension (1 - cos), is taken off. The
/// angle is that between the force and the way from it: nothing is taken off straight ahead of it, where a plate bends open. Elements that
/// hold a pushed node have several times Boussinesq's radial tension, (1 - 2 nu) |F| / (2 pi r^2), hence the factor.
class BreakingStress {
 public:
  static constexpr double kOwnTension = 2.0;

  /// Keeps a reference to the mesh.
  explicit BreakingStress(const mesh::TetMesh& mesh);

  /// Largest principal value at the mesh's corner nodes [Pa], without the forces' own; 0 at other nodes and at pushed ones.
  /// @param pushed  the same forces as the mesh has them (SurfacePlaces::at_nodes)
  Eigen::VectorXd at_nodes_pa(const StressField& field, const std::vector<PointForce>& forces,
                              const std::vector<NodeForce>& pushed) const;
  /// Of each element that at the corner where it is largest.
  Eigen::VectorXd by_element_pa(const StressField& field, const std::vector<PointForce>& forces,
                                const std::vector<NodeForce>& pushed) const;

  /// Strain energy [J] of the whole body below which no node's value reaches strength_pa, whatever the load. With C Hooke's law
  /// anywhere n . sigma n = eps : C : (n x n) <= sqrt(2 w (lambda + 2 mu)), w the energy density; and the stress of an element at a
  /// corner is its product with a linear function k over the element, int k^2 dV = (M^-1)_cc, M the Gram matrix of the
  /// barycentric coordinates (16 / V where edges are straight). So by Cauchy and Schwarz, with the weights w_e of a node's elements,
  ///
  ///     n . sigma n <= sqrt(2 (lambda + 2 mu) E_S sum_e w_e^2 (M_e^-1)_cc).
  ///
  /// What is taken off for the forces' own makes it no larger. A part in 1e9 is left for round-off.
  double least_energy_j(const solid::Material& material, double strength_pa) const;

 private:
  const mesh::TetMesh& mesh_;
  Eigen::VectorXd volume_m3_;       // by element
  Eigen::VectorXd node_volume_m3_;  // of the elements that have the node as a corner
  double largest_norm_sq_1_m3_ = 0.0;
};

}  // namespace klang::fracture
