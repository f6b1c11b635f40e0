#pragma once
#include <Eigen/Core>

#include "core/physics/solid/assembly.hpp"

namespace klang::solid {

/// Basis (n_dofs x n_rigid, not normalised) of the motions of the free nodes that strain nothing:
/// translations and rotations of each part of the mesh, parts being joined where elements share a face. Parts
/// that share only nodes (a hinge) and held nodes give linear constraints on these motions; an SVD of them
/// leaves what is free, so the dimension follows from geometry and not from the size of computed eigenvalues.
/// 6 columns for a free connected body.
/// @throws InputError when the mesh falls apart into more than 100 pieces
Eigen::MatrixXd rigid_modes(const mesh::TetMesh& mesh, const AssembledSolid& assembled);

}  // namespace klang::solid
