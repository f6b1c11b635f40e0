#include "core/foundation/la/dense_solve.hpp"

#include <cmath>
#include <complex>
#include <vector>

#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la {
namespace {

/// r = b - A x; A by rows is A^T by columns, which is how LAPACK sees it.
void residual(const RowMatrixXcd& a, const Eigen::MatrixXcd& x, const Eigen::MatrixXcd& b, Eigen::MatrixXcd& r) {
  const int n = static_cast<int>(a.rows()), columns = static_cast<int>(b.cols());
  const std::complex<double> minus = -1.0, one = 1.0;
  r = b;
  zgemm_("T", "N", &n, &columns, &n, &minus, a.data(), &n, x.data(), &n, &one, r.data(), &n);
}

double worst_ratio(const Eigen::MatrixXcd& r, const Eigen::VectorXd& scale) {
  double worst = 0.0;
  for (Eigen::Index c = 0; c < r.cols(); ++c) {
    const double ratio = r.col(c).norm() / scale[c];
    if (!(ratio <= worst)) worst = ratio;  // NaN stays
  }
  return worst;
}

}  // namespace

DenseSolution dense_solve(RowMatrixXcd& a, const Eigen::MatrixXcd& b, double tolerance, int max_refinements) {
  DenseSolution result;
  const int n = static_cast<int>(a.rows()), columns = static_cast<int>(b.cols());
  Eigen::VectorXd scale = b.colwise().norm().transpose();
  for (double& value : scale)
    if (value == 0.0) value = 1.0;
  result.x = Eigen::MatrixXcd::Zero(n, columns);
  Eigen::MatrixXcd r = b;
  std::vector<int> pivots(static_cast<std::size_t>(n));
  int info = 0;
  Stopwatch watch;
  {
    Eigen::MatrixXcf factor(n, n);
    for (int row = 0; row < n; ++row) factor.col(row) = a.row(row).cast<std::complex<float>>().transpose();
    cgetrf_(&n, &n, factor.data(), &n, pivots.data(), &info);
    result.factor_s = watch.seconds();
    watch.restart();
    double before = HUGE_VAL;
    for (int step = 0; info == 0 && step <= max_refinements; ++step) {
      // Single precision ends at 1e-38: corrections are scaled to 1.
      Eigen::MatrixXcf correction(n, columns);
      Eigen::VectorXd size = r.colwise().norm().transpose();
      for (double& value : size)
        if (value == 0.0) value = 1.0;
      for (int c = 0; c < columns; ++c) correction.col(c) = (r.col(c) / size[c]).cast<std::complex<float>>();
      cgetrs_("T", &n, &columns, factor.data(), &n, pivots.data(), correction.data(), &n, &info);
      for (int c = 0; c < columns; ++c) result.x.col(c) += size[c] * correction.col(c).cast<std::complex<double>>();
      residual(a, result.x, b, r);
      result.n_refinements = step;
      const double now = worst_ratio(r, scale);
      result.relative_residual = now;
      if (now <= tolerance) {
        result.solved = true;
        break;
      }
      if (!(now <= 0.5 * before)) break;
      before = now;
    }
  }
  result.refine_s = watch.seconds();
  if (result.solved) return result;

  watch.restart();
  result.double_factor = true;
  RowMatrixXcd factor = a;
  zgetrf_(&n, &n, factor.data(), &n, pivots.data(), &info);
  result.x = b;
  if (info == 0) zgetrs_("T", &n, &columns, factor.data(), &n, pivots.data(), result.x.data(), &n, &info);
  residual(a, result.x, b, r);
  result.relative_residual = worst_ratio(r, scale);
  result.solved = info == 0 && *result.relative_residual <= tolerance;
  result.factor_s += watch.seconds();
  return result;
}

}  // namespace klang::la
