#include "datasets-synthetic/detail/legendre.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"

extern "C" void dsyevr_(const char* jobz, const char* range, const char* uplo, const int* n, double* a, const int* lda,
                        const double* vl, const double* vu, const int* il, const int* iu, const double* abstol, int* m,
                        double* w, double* z, const int* ldz, int* isuppz, double* work, const int* lwork, int* iwork,
                        const int* liwork, int* info);

namespace klang::datasets::detail {
namespace {

double norm(int degree, double length_m) { return std::sqrt((2.0 * degree + 1.0) / length_m); }

}  // namespace

LegendreIntegrals::LegendreIntegrals(int order, double length_m)
    : value_slope(Eigen::MatrixXd::Zero(order + 1, order + 1)),
      slope_slope(Eigen::MatrixXd::Zero(order + 1, order + 1)) {
  // On [-1, 1]: int P_i P_k' = 2 for i < k of the other parity, int P_i' P_k' = m (m + 1), m = min(i, k), for
  // equal parity.
  for (int i = 0; i <= order; ++i) {
    for (int k = 0; k <= order; ++k) {
      const double scale = norm(i, length_m) * norm(k, length_m);
      const int least = std::min(i, k);
      if (i < k && (k - i) % 2 == 1) value_slope(i, k) = 2.0 * scale;
      if ((i + k) % 2 == 0) slope_slope(i, k) = least * (least + 1.0) * scale * 2.0 / length_m;
    }
  }
}

Eigen::VectorXd legendre_values(int order, double length_m, double x_m) {
  const double t = 2.0 * x_m / length_m;
  Eigen::VectorXd p(order + 1);
  p[0] = 1.0;
  if (order > 0) p[1] = t;
  for (int k = 2; k <= order; ++k) p[k] = ((2.0 * k - 1.0) * t * p[k - 1] - (k - 1.0) * p[k - 2]) / k;
  for (int k = 0; k <= order; ++k) p[k] *= norm(k, length_m);
  return p;
}

Eigen::VectorXd legendre_slopes(int order, double length_m, double x_m) {
  // P_{k+1}' = P_{k-1}' + (2 k + 1) P_k.
  const Eigen::VectorXd p = legendre_values(order, length_m, x_m);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(order + 1);
  for (int k = 1; k <= order; ++k) {
    slope[k] = (k >= 2 ? slope[k - 2] : 0.0) + (2.0 * k - 1.0) * p[k - 1] / norm(k - 1, length_m);
  }
  for (int k = 0; k <= order; ++k) slope[k] *= norm(k, length_m) * 2.0 / length_m;
  return slope;
}

GaussRule::GaussRule(int n, double low, double high) : points(n), weights(n) {
  for (int i = 0; i < n; ++i) {
    double t = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {  // Newton; converges in about five
      double before = 1.0, value = t;
      for (int k = 2; k <= n; ++k) {
        const double next = ((2.0 * k - 1.0) * t * value - (k - 1.0) * before) / k;
        before = value;
        value = next;
      }
      slope = n * (t * value - before) / (t * t - 1.0);
      const double step = value / slope;
      t -= step;
      if (std::abs(step) < 1e-16) break;
    }
    points[i] = 0.5 * (low + high) + 0.5 * (high - low) * t;
    weights[i] = (high - low) / ((1.0 - t * t) * slope * slope);
  }
}

EigenPairs lowest_eigenpairs(Eigen::MatrixXd matrix, int count) {
  KLANG_CHECK(matrix.rows() == matrix.cols() && count >= 0, "square matrix");
  const int n = static_cast<int>(matrix.rows());
  count = std::min(count, n);
  EigenPairs pairs{Eigen::VectorXd(n), Eigen::MatrixXd(n, count)};
  if (count == 0) return {Eigen::VectorXd(0), Eigen::MatrixXd(n, 0)};
  const int first = 1;
  const double unused = 0.0, tolerance = 0.0;
  std::vector<int> support(2 * static_cast<std::size_t>(n)), iwork(10 * static_cast<std::size_t>(n));
  std::vector<double> work(static_cast<std::size_t>(n) * 64 + 1024);
  const int lwork = static_cast<int>(work.size()), liwork = static_cast<int>(iwork.size());
  int found = 0, info = 0;
  dsyevr_("V", "I", "L", &n, matrix.data(), &n, &unused, &unused, &first, &count, &tolerance, &found,
          pairs.values.data(), pairs.vectors.data(), &n, support.data(), work.data(), &lwork, iwork.data(), &liwork,
          &info);
  KLANG_CHECK(info == 0 && found == count, "dsyevr failed on a finite symmetric matrix");
  pairs.values.conservativeResize(count);
  for (int k = 0; k < count; ++k) {
    Eigen::Index at = 0;
    pairs.vectors.col(k).cwiseAbs().maxCoeff(&at);
    if (pairs.vectors(at, k) < 0) pairs.vectors.col(k) *= -1.0;
  }
  return pairs;
}

}  // namespace klang::datasets::detail
