#include "core/foundation/la/block_lanczos.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>

#include "core/foundation/base/huge_pages.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// c = alpha op(a) b + beta c through BLAS: these products are most of what is done besides the solves.
void multiply(char op_a, double alpha, const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b,
              double beta, Eigen::Ref<MatrixXd> c) {
  const auto as_int = [](Index i) { return static_cast<int>(i); };
  const int m = as_int(c.rows()), n = as_int(c.cols()), k = as_int(b.rows());
  const int lda = as_int(a.outerStride()), ldb = as_int(b.outerStride()), ldc = as_int(c.outerStride());
  dgemm_(&op_a, "N", &m, &n, &k, &alpha, a.data(), &lda, b.data(), &ldb, &beta, c.data(), &ldc);
}

MatrixXd transpose_times(const Eigen::Ref<const MatrixXd>& a, const Eigen::Ref<const MatrixXd>& b) {
  MatrixXd c(a.cols(), b.cols());
  multiply('T', 1, a, b, 0, c);
  return c;
}

// X := X R^-1 with X^T M X = 1; returns R (upper triangular) in r. mass_x must hold M X and follows X.
// Cholesky QR, twice for orthogonality to round-off. False when the columns are dependent to round-off.
bool orthonormalise(MatrixXd& x, MatrixXd& mass_x, const BlockMass& mass, MatrixXd& r) {
  r = MatrixXd::Identity(x.cols(), x.cols());
  for (int pass = 0; pass < 2; ++pass) {
    if (pass == 1) mass_x = mass.times(x);
    MatrixXd gram = transpose_times(x, mass_x);
    const Eigen::VectorXd scale = gram.diagonal().cwiseSqrt().cwiseInverse();
    gram = scale.asDiagonal() * gram * scale.asDiagonal();
    if (!gram.allFinite()) return false;
    const Eigen::LLT<MatrixXd> factor(gram);
    if (factor.info() != Eigen::Success) return false;
    const MatrixXd upper = MatrixXd(factor.matrixU()) * scale.cwiseInverse().asDiagonal();
    const MatrixXd inverse = upper.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(x.cols(), x.cols()));
    MatrixXd turned(x.rows(), x.cols());
    multiply('N', 1, x, inverse, 0, turned);
    x.swap(turned);
    if (pass == 1) {
      multiply('N', 1, mass_x, inverse, 0, turned);
      mass_x.swap(turned);
    }
    r = upper * r;
  }
  return true;
}

}  // namespace

BlockLanczosResult block_lanczos(const std::function<MatrixXd(const MatrixXd&)>& apply, const BlockMass& mass,
                                 MatrixXd start, const BlockLanczosOptions& options) {
  const Index n_wanted = options.n_wanted;
  BlockLanczosResult result;
  const Index n = start.rows(), b = start.cols();
  const Index n_kept_max = n_wanted + std::max<Index>(b, n_wanted / 4);
  const Index n_space = n_kept_max + std::max<Index>(6 * b, 3 * n_wanted);
  MatrixXd basis(n, n_space + b);
  advise_huge_pages(basis.data(), static_cast<std::size_t>(basis.size()) * sizeof(double));
  MatrixXd projected = MatrixXd::Zero(n_space + b, n_space + b);  // basis^T M Op basis
  MatrixXd mass_x = mass.times(start), r;
  if (!orthonormalise(start, mass_x, mass, r)) return result;
  basis.leftCols(b) = start;
  Index n_done = 0;  // columns of the basis that Op has been applied to
  for (int restart = 0; restart <= options.max_restarts; ++restart) {
    while (n_done + b <= n_space) {
      // The newest block is basis[n_done, n_done + b), with mass_x its product with M.
      MatrixXd next = apply(mass_x);
      ++result.n_blocks;
      const Index used = n_done + b;
      const auto old = basis.leftCols(used);
      MatrixXd mass_next = mass.times(next);
      MatrixXd h = transpose_times(old, mass_next);
      multiply('N', -1, old, h, 1, next);
      mass_next = mass.times(next);
      const MatrixXd correction = transpose_times(old, mass_next);  // once more: one pass loses orthogonality
      multiply('N', -1, old, correction, 1, next);
      h += correction;
      mass_x.swap(mass_next);  // M next but for the correction, which the second pass of Cholesky QR sees
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
      const Eigen::VectorXd theta = ritz.eigenvalues().tail(n_wanted).reverse();
      const Eigen::VectorXd residual =
          coupling.rightCols(n_wanted).colwise().norm().transpose().reverse().cwiseQuotient(theta);
      const bool all = (residual.array() <= options.tolerance).all();
      if (options.watch && !all) options.watch(theta, residual);
      const bool full = n_done + b > n_space;
      if (!all && !full) continue;
      const Index keep = all ? n_wanted : n_kept_max;
      MatrixXd turned(n, keep);
      multiply('N', 1, basis.leftCols(n_done), ritz.eigenvectors().rightCols(keep), 0, turned);
      if (all || restart == options.max_restarts) {
        result.theta = theta;
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

}  // namespace klang::la
