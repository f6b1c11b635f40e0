#include "core/physics/modal/detail/ball_basis.hpp"

#include <Eigen/QR>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/math/quadrature.hpp"

namespace klang::modal::detail {
namespace {

/// P_0 ... P_degree and their slopes at t.
void legendre(int degree, double t, double* value, double* slope) {
  value[0] = 1.0;
  slope[0] = 0.0;
  if (degree == 0) return;
  value[1] = t;
  slope[1] = 1.0;
  for (int k = 2; k <= degree; ++k) {
    value[k] = ((2.0 * k - 1.0) * t * value[k - 1] - (k - 1.0) * value[k - 2]) / k;
    slope[k] = slope[k - 2] + (2.0 * k - 1.0) * value[k - 1];
  }
}

struct BallRule {
  Eigen::Matrix3Xd points;
  Eigen::VectorXd weights;
};

/// Exact on the ball for polynomials of twice the degree that are even in every axis; points of one octant only.
BallRule octant_rule(int degree) {
  const QuadratureRule radial = gauss_rule(degree + 2), polar = gauss_rule(2 * (degree / 2 + 1));
  const int n_quarter = degree / 2 + 1, n_polar = static_cast<int>(polar.points.size()) / 2;
  BallRule rule{Eigen::Matrix3Xd(3, radial.points.size() * n_polar * n_quarter), {}};
  rule.weights.resize(rule.points.cols());
  Eigen::Index at = 0;
  for (Eigen::Index i = 0; i < radial.points.size(); ++i) {
    const double r = 0.5 * (1.0 + radial.points[i]), weight_r = 0.5 * radial.weights[i] * r * r;
    for (int j = n_polar; j < 2 * n_polar; ++j) {
      const double z = polar.points[j], s = std::sqrt((1.0 - z) * (1.0 + z));
      for (int k = 0; k < n_quarter; ++k) {
        const double phi = (k + 0.5) * 0.5 * kPi / n_quarter;
        rule.points.col(at) = r * Eigen::Vector3d(s * std::cos(phi), s * std::sin(phi), z);
        rule.weights[at++] = 8.0 * weight_r * polar.weights[j] * 0.5 * kPi / n_quarter;
      }
    }
  }
  return rule;
}

/// Products of Legendre polynomials at points; axis >= 0: their slopes along that axis.
Eigen::MatrixXd products(const std::vector<std::array<int, 3>>& degrees, int degree, const Eigen::Matrix3Xd& points,
                         int axis) {
  Eigen::MatrixXd table(points.cols(), static_cast<Eigen::Index>(degrees.size()));
  std::array<std::vector<double>, 3> value, slope;
  for (int d = 0; d < 3; ++d) value[d].resize(degree + 2), slope[d].resize(degree + 2);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    for (int d = 0; d < 3; ++d) legendre(degree, points(d, p), value[d].data(), slope[d].data());
    for (std::size_t f = 0; f < degrees.size(); ++f) {
      double product = 1.0;
      for (int d = 0; d < 3; ++d) product *= (d == axis ? slope : value)[d][degrees[f][d]];
      table(p, static_cast<Eigen::Index>(f)) = product;
    }
  }
  return table;
}

}  // namespace

BallBasis::BallBasis(int degree) : degree_(degree) {
  KLANG_CHECK(degree >= 3 && degree <= 24, "degree of the polynomials within 3 to 24");
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; i + j <= degree; ++j)
      for (int k = 0; i + j + k <= degree; ++k) degrees_[(i & 1) | (j & 1) << 1 | (k & 1) << 2].push_back({i, j, k});

  const BallRule rule = octant_rule(degree);
  const Eigen::VectorXd root = rule.weights.cwiseSqrt();
  std::array<Eigen::MatrixXd, kParities> values;
  for (Parity p = 0; p < kParities; ++p) {
    const Eigen::MatrixXd weighted = root.asDiagonal() * products(degrees_[p], degree, rule.points, -1);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(weighted);
    const Eigen::Index n = weighted.cols();
    const Eigen::MatrixXd r = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
    to_orthonormal_[p] = r.triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(n, n));
    values[p] = weighted * to_orthonormal_[p];
  }
  for (Parity p = 0; p < kParities; ++p)
    for (int axis = 0; axis < 3; ++axis)
      slope_[p][axis] = values[p ^ (1 << axis)].transpose() *
                        (root.asDiagonal() * products(degrees_[p], degree, rule.points, axis) * to_orthonormal_[p]);
}

Eigen::MatrixXd BallBasis::values(Parity parity, const Eigen::Matrix3Xd& points) const {
  return products(degrees_[parity], degree_, points, -1) * to_orthonormal_[parity];
}

const BallBasis& ball_basis(int degree) {
  static std::mutex mutex;
  static std::map<int, std::unique_ptr<const BallBasis>> made;
  const std::lock_guard lock(mutex);
  std::unique_ptr<const BallBasis>& basis = made[degree];
  if (!basis) basis = std::make_unique<const BallBasis>(degree);
  return *basis;
}

}  // namespace klang::modal::detail
