#include "core/physics/modal/constraints/friction_barrier.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

namespace klang::modal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kFirst = 1.0, kLast = 1e-10, kFall = 0.1;  ///< of the barrier, of force times speed
constexpr int kMostSteps = 8;                               ///< of each
constexpr double kNearly = 1e-3;                            ///< of the decrement: the next barrier

/// mu^2 f_n^2 - |f_t|^2; not above 0: outside.
double room(const Vector3d& f, double mu) {
  return f[0] > 0.0 ? mu * mu * f[0] * f[0] - f.tail<2>().squaredNorm() : -1.0;
}

struct Barrier {
  const FrictionProblem& problem;
  const MatrixXd& root;
  double weight = kFirst;
  VectorXd lifted;  ///< b with De Saxce's term

  double value(const VectorXd& f) const {
    double sum = 0.5 * (root.transpose() * f).squaredNorm() + lifted.dot(f);
    for (Index i = 0; i < problem.friction.size(); ++i) {
      const double c = room(f.segment<3>(3 * i), problem.friction[i]);
      if (!(c > 0.0)) return HUGE_VAL;
      sum -= weight * std::log(c);
    }
    return sum;
  }

  /// Newton's step and how much it promises.
  VectorXd step(const VectorXd& f, double& decrement) const {
    VectorXd slope = root * (root.transpose() * f) + lifted;
    MatrixXd soft_root(root.rows(), root.cols());  // D R
    VectorXd soft_slope(f.size());                 // D slope
    std::vector<Matrix3d> soft;
    for (Index i = 0; i < problem.friction.size(); ++i) {
      const double mu_sq = problem.friction[i] * problem.friction[i];
      const Vector3d own = f.segment<3>(3 * i), bend(2.0 * mu_sq, -2.0, -2.0), by = bend.cwiseProduct(own);
      const double c = room(own, problem.friction[i]);
      slope.segment<3>(3 * i) -= weight / c * by;
      const Matrix3d hessian = by * by.transpose() / (c * c) - Matrix3d(bend.asDiagonal()) / c;
      soft.push_back(hessian.inverse() / weight);
      soft_root.middleRows<3>(3 * i) = soft.back() * root.middleRows<3>(3 * i);
      soft_slope.segment<3>(3 * i) = soft.back() * slope.segment<3>(3 * i);
    }
    MatrixXd inner = root.transpose() * soft_root;
    inner.diagonal().array() += 1.0;
    const VectorXd by = soft_root * inner.llt().solve(root.transpose() * soft_slope) - soft_slope;
    decrement = -by.dot(slope);
    return by;
  }
};

}  // namespace

VectorXd forces_within(const FrictionProblem& problem, const MatrixXd& root) {
  const Index n = problem.friction.size();
  const double speed = problem.b.cwiseAbs().maxCoeff(),
               force = speed / (problem.a.diagonal().mean() * static_cast<double>(n));
  VectorXd f = VectorXd::Zero(3 * n);
  for (Index i = 0; i < n; ++i) f[3 * i] = force;
  Barrier barrier{problem, root, {}};
  for (double share = kFirst; share >= kLast; share *= kFall) {
    barrier.weight = share * force * speed;
    barrier.lifted = problem.b;
    const VectorXd w = root * (root.transpose() * f) + problem.b;
    for (Index i = 0; i < n; ++i) barrier.lifted[3 * i] += problem.friction[i] * w.segment<2>(3 * i + 1).norm();
    for (int k = 0; k < kMostSteps; ++k) {
      double promised = 0.0;
      const VectorXd by = barrier.step(f, promised);
      if (!(promised > kNearly * barrier.weight) || !by.allFinite()) break;
      const double now = barrier.value(f);
      double part = 1.0;
      while (part > 1e-6 && !(barrier.value(f + part * by) <= now - 0.1 * part * promised)) part *= 0.5;
      if (!(part > 1e-6)) break;
      f += part * by;
    }
  }
  return f;
}

}  // namespace klang::modal
