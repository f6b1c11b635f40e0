#include "core/modal/detail/block_lanczos.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

namespace klang::modal::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// X := X R^-1 with X^T M X = 1; returns R (upper triangular). mass_x follows X. Cholesky QR, twice for orthogonality
// to round-off. False when the columns are dependent to round-off.
bool orthonormalise(MatrixXd& x, MatrixXd& mass_x, const BlockMass& mass, MatrixXd& r) {
  r = MatrixXd::Identity(x.cols(), x.cols());
  for (int pass = 0; pass < 2; ++pass) {
    mass_x = mass.times(x);
    MatrixXd gram = x.transpose() * mass_x;
    const Eigen::VectorXd scale = gram.diagonal().cwiseSqrt().cwiseInverse();
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    const Eigen::LLT<MatrixXd> factor(gram);
    if (factor.info() != Eigen::Success || !gram.allFinite()) return false;
    const MatrixXd upper = MatrixXd(factor.matrixU()) * scale.cwiseInverse().asDiagonal();
    factor.matrixU().solveInPlace<Eigen::OnTheRight>(x = x * scale.asDiagonal());
    r = upper * r;
  }
  mass_x = mass.times(x);
  return true;
}

}  // namespace

BlockLanczosResult block_lanczos(const std::function<MatrixXd(const MatrixXd&)>& apply, const BlockMass& mass,
                                 MatrixXd start, Index n_wanted, double tolerance, int max_restarts) {
  BlockLanczosResult result;
  const Index n = start.rows(), b = start.cols();
  const Index n_kept_max = n_wanted + std::max<Index>(b, n_wanted / 4);
  const Index n_space = n_kept_max + std::max<Index>(4 * b, n_wanted);
  MatrixXd basis(n, n_space + b);
  MatrixXd projected = MatrixXd::Zero(n_space + b, n_space + b);  // basis^T M Op basis
  MatrixXd mass_x, r;
  if (!orthonormalise(start, mass_x, mass, r)) return result;
  basis.leftCols(b) = start;
  Index n_done = 0;  // columns of the basis that Op has been applied to
  for (int restart = 0; restart <= max_restarts; ++restart) {
    while (n_done + b <= n_space) {
      // The newest block is basis[n_done, n_done + b), with mass_x its product with M.
      MatrixXd next = apply(mass_x);
      ++result.n_blocks;
      const Index used = n_done + b;
      const auto old = basis.leftCols(used);
      MatrixXd mass_next = mass.times(next);
      MatrixXd h = old.transpose() * mass_next;
      next.noalias() -= old * h;
      mass_next = mass.times(next);
      const MatrixXd correction = old.transpose() * mass_next;  // once more: Lanczos vectors lose orthogonality
      next.noalias() -= old * correction;
      h += correction;
      projected.block(0, n_done, used, b) = h;
      projected.block(n_done, 0, b, used) = h.transpose();
      n_done = used;
      if (!orthonormalise(next, mass_x, mass, r)) return result;  // the space is exhausted: the caller goes dense
      basis.middleCols(used, b) = next;

      // Test now and then, and at the end of the space.
      if (n_done < n_wanted + b || (result.n_blocks % 2 != 0 && n_done + b <= n_space)) continue;
      const MatrixXd part = projected.topLeftCorner(n_done, n_done);
      const Eigen::SelfAdjointEigenSolver<MatrixXd> ritz(0.5 * (part + part.transpose()));
      const MatrixXd coupling = r * ritz.eigenvectors().bottomRows(b);  // rows: the part of Op u outside the space
      bool all = true;
      for (Index k = n_done - n_wanted; k < n_done; ++k) {
        all = all && coupling.col(k).norm() <= tolerance * ritz.eigenvalues()(k);
      }
      const bool full = n_done + b > n_space;
      if (!all && !full) continue;
      const Index keep = all ? n_wanted : n_kept_max;
      const MatrixXd turned = basis.leftCols(n_done) * ritz.eigenvectors().rightCols(keep);
      if (all || restart == max_restarts) {
        result.theta = ritz.eigenvalues().tail(n_wanted).reverse();
        result.vector = turned.rightCols(n_wanted).rowwise().reverse();
        result.converged = all;
        return result;
      }
      basis.middleCols(keep, b) = next;
      basis.leftCols(keep) = turned;
      projected.setZero();
      projected.topLeftCorner(keep, keep) = ritz.eigenvalues().tail(keep).asDiagonal();
      n_done = keep;
      break;
    }
  }
  return result;
}

}  // namespace klang::modal::detail
