#pragma once
#include <Eigen/Core>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Volume, centre and inertia of a body of density 1.
struct MassProperties {
  double volume_m3 = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  /// About the centre: int (|r|^2 I - r r^T) dV, r = x - centre. Times the density: [kg m^2].
  Eigen::Matrix3d inertia_m5 = Eigen::Matrix3d::Zero();
};

/// Of the body inside a closed surface with outward normals, by the divergence theorem (V = 1/3 int x . n,
/// int x V = 1/4 int x (x . n), int x x^T dV = 1/5 int x x^T (x . n)). Exact for straight and for quadratic triangles: on those the
/// integrand is a polynomial of degree 8, for which the rule is exact.
/// @throws InputError where the volume is not positive (inward normals)
MassProperties mass_properties(const SurfaceMesh& surface);
/// Of a mesh, its curved sides taken as they are.
MassProperties mass_properties(const TetMesh& mesh);

/// Ascending principal moments about the centre, of density 1 [m^5].
Eigen::Vector3d principal_moments(const MassProperties& mass);

}  // namespace klang::mesh
