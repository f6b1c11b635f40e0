#pragma once
#include <Eigen/Core>

#include "core/physics/fracture/quasistatic/free_body_solver.hpp"

namespace klang::fracture {

struct PlaceCompliance {
  /// Displacement along the normal under a unit force along it, in the mean over a small round area, less what a half-space of the
  /// material gives way there: what is left when the dent is someone else's (Hertz'). It does not depend on the area.
  double beyond_dent_m_per_n = 0.0;
  double of_mesh_m_per_n = 0.0;  ///< of these, what the mesh has under the same load, dent included
  double dent_m_per_n = 0.0;     ///< of the half-space: 3 (1 - nu^2) / (5 E b)
  double area_radius_m = 0.0;    ///< b
  double edge_m = 0.0;           ///< of the mesh there
  int n_cut_elements = 0;        ///< of the finer mesh about the place
};

/// A free body's static compliance at a place of its surface. Under a force at one node a mesh gives way by what that node's elements
/// are, which has nothing to do with the body: the force is spread as Hertz' pressure over a circle of a sixth of the edges there, or of the
/// thickness below, and elements about it are cut until they resolve it, those four edges around in halves at least. Between the mesh and these corrections go to and fro
/// (an overlapping two-level method), each of which adds what energy it frees, so that the compliance comes up from below.
/// @param outward  unit normal
PlaceCompliance place_compliance(FreeBodySolver& solver, const solid::Material& material,
                                 const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward);

}  // namespace klang::fracture
