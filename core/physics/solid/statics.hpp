#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>

#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::solid {

/// Nodal forces (3 n_nodes) of a traction [N/m^2] on the whole boundary: f = int N^T t(x, n) dA, consistent
/// with the elements, over the curved faces of quadratic ones (7 points, degree 5). n is the outward unit
/// normal.
Eigen::VectorXd traction_force_n(
    const mesh::TetMesh& mesh,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d& x_m, const Eigen::Vector3d& normal)>& traction_pa);

enum class StaticStatus { kNotRun, kSolved, kFailed };

struct StaticResult {
  StaticStatus status = StaticStatus::kNotRun;
  std::string message;
  Eigen::MatrixXd displacement_m;     ///< 3 n_mesh_nodes x n_loads; held nodes 0; no rigid part (M-orthogonal to it)
  Eigen::VectorXd energy_j;           ///< n_loads, u . K u / 2
  Eigen::VectorXd relative_residual;  ///< n_loads, ||K u - f'|| / ||f'||
  int n_rigid_modes = 0;
  bool usable() const { return status == StaticStatus::kSolved; }
};

/// K u = f' for each column of force_n (3 n_mesh_nodes x n_loads). Where the support leaves rigid motions R
/// the body accelerates as a whole, and what strains it is the inertia-relief load f' = f - M R (R^T M R)^-1
/// R^T f. (The Euclidean projection of the soundbank paper's eqs. 2 and 3 is this only for equal nodal
/// masses: docs/errata.md item 47.) u is then the solution without rigid part. Without rigid motions f' = f.
/// @throws InputError when force_n has the wrong number of rows or is not finite
StaticResult solve_statics(const mesh::TetMesh& mesh, const AssembledSolid& assembled, const Material& material,
                           const Eigen::MatrixXd& force_n);

}  // namespace klang::solid
