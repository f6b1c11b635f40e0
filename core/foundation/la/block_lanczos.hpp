#pragma once
#include <Eigen/Core>
#include <functional>

#include "core/foundation/la/block_mass.hpp"

namespace klang::la {

struct BlockLanczosResult {
  Eigen::VectorXd theta;   ///< largest eigenvalues, descending
  Eigen::MatrixXd vector;  ///< n x n_wanted, M-orthonormal
  bool converged = false;
  int n_blocks = 0;  ///< applications of the operator to a block
};

/// Told the approximations so far, descending, and the relative residual of each.
using LanczosWatch = std::function<void(const Eigen::VectorXd& theta, const Eigen::VectorXd& residual)>;

struct BlockLanczosOptions {
  Eigen::Index n_wanted = 1;
  double tolerance = 1e-10;
  int max_restarts = 100;
  LanczosWatch watch;
};

/// The n_wanted largest eigenvalues of an operator that is self-adjoint in the M inner product: block
/// Krylov-Schur (Lanczos with full orthogonalisation and thick restarts; Stewart 2001, Zhou and Saad 2008). A
/// block of b vectors costs one pass through the factor instead of b, and holds eigenvalues of multiplicity
/// up to b at once.
///   apply(X) = Op M X for a block, given M X.
/// Stops when every ||Op u - theta u||_M <= tolerance theta, or after max_restarts.
BlockLanczosResult block_lanczos(const std::function<Eigen::MatrixXd(const Eigen::MatrixXd& mass_x)>& apply,
                                 const BlockMass& mass, Eigen::MatrixXd start, const BlockLanczosOptions& options);

}  // namespace klang::la
