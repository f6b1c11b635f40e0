#pragma once
#include <Eigen/Core>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::modal::detail {

/// Turns the shapes of equal frequencies (relative distance of omega^2 below 1e-8) within their space so that they do not depend
/// on how an eigensolver came by them: in each cluster the sum of u_i . u_j over the nodes in a wedge of the body that no symmetry
/// maps onto itself becomes diagonal, descending. Orthonormal shapes stay so.
/// @param omega_sq  ascending
/// @param shapes  3 n_nodes x n
void orient_clusters(const mesh::TetMesh& mesh, const Eigen::VectorXd& omega_sq, Eigen::MatrixXd& shapes);

/// Whether a vector whose sign is free is to change it, so that runs can be compared: the first of its largest components becomes
/// positive. Symmetric bodies have several that are equal to round-off.
bool turns_over(const Eigen::Ref<const Eigen::VectorXd>& vector);

}  // namespace klang::modal::detail
