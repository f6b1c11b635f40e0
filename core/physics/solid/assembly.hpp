#pragma once
#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::solid {

using la::SparseMatrix;

enum class MassKind { kConsistent, kLumped };

/// K = lambda K_lambda + mu K_mu and M = rho M_1 of a mesh: a step in the material costs no assembly.
/// Only the lower triangle is stored; the three matrices share one pattern (lumped mass: explicit zeros).
/// Degree of freedom 3 * node + axis among the free nodes, in the mesh's order; held nodes are left out.
///   K_lambda = int div(u) div(v),  K_mu = int 2 sym grad u : sym grad v,  M_1 = int u . v
/// Factor 1 (not S02 eq. 12's printed -1/2): docs/errata.md item 1.
struct AssembledSolid {
  SparseMatrix stiffness_lambda;  ///< [m], times Pa gives N/m
  SparseMatrix stiffness_mu;
  SparseMatrix mass_unit_density;  ///< [m^3]
  std::vector<int> free_nodes;     ///< mesh node of each free node
  int n_mesh_nodes = 0;

  Eigen::Index n_dofs() const { return stiffness_mu.rows(); }
};

/// Parallel over elements; the result has the same bits on any number of threads.
/// @throws InputError: an element of volume <= 0 (its number), a mesh that the support holds everywhere.
AssembledSolid assemble(const mesh::TetMesh& mesh, const Support& support = {}, MassKind mass = MassKind::kConsistent);

/// lambda K_lambda + mu K_mu, lower triangle.
SparseMatrix stiffness(const AssembledSolid& solid, double lame_lambda_pa, double lame_mu_pa);

}  // namespace klang::solid
