#include "core/physics/modal/constraints/friction_statuses.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/physics/modal/constraints/friction_barrier.hpp"

namespace klang::modal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostGuesses = 30, kMostWithoutGain = 6;
constexpr double kRank = 1e-13, kDependent = 1e-10;
constexpr double kMostWork = 3e7;  ///< operations of a system: above, sweeps are cheaper

/// R with A = R R^T, as many columns as A has rank: Cholesky's with pivots.
MatrixXd root_of(const MatrixXd& a) {
  const Index n = a.rows();
  VectorXd left = a.diagonal();
  const double least = kRank * left.maxCoeff();
  MatrixXd root(n, n);
  Index rank = 0;
  for (; rank < n; ++rank) {
    Index pivot = 0;
    const double most = left.maxCoeff(&pivot);
    if (!(most > least)) break;
    const VectorXd column =
        (a.col(pivot) - root.leftCols(rank) * root.row(pivot).head(rank).transpose()) / std::sqrt(most);
    root.col(rank) = column;
    left -= column.cwiseAbs2();
    left[pivot] = 0.0;
  }
  return root.leftCols(rank);
}

Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposed(const MatrixXd& matrix) {
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(kDependent);
  decomposition.compute(matrix);
  return decomposition;
}

/// Which forces are free and which speeds are to vanish, by the natural map of forces and speeds.
struct Statuses {
  std::vector<Index> still;      ///< rows whose speed vanishes, one for each free force
  std::vector<Vector3d> forces;  ///< what one of each free force is, at its contact
};

Statuses guessed(const FrictionProblem& problem, const VectorXd& forces, const VectorXd& speeds) {
  Statuses statuses;
  for (Index i = 0; i < problem.friction.size(); ++i) {
    const Eigen::Matrix3d own = problem.a.block<3, 3>(3 * i, 3 * i);
    const double normal = forces[3 * i] - speeds[3 * i] / own(0, 0);
    if (!(normal > 0.0)) continue;
    const Vector2d along =
        forces.segment<2>(3 * i + 1) - speeds.segment<2>(3 * i + 1) / own.bottomRightCorner<2, 2>().norm();
    const double most = problem.friction[i] * normal, size = along.norm();
    statuses.still.push_back(3 * i);
    if (size <= most && problem.friction[i] > 0.0) {
      for (int axis = 0; axis < 3; ++axis) statuses.forces.push_back(Vector3d::Unit(axis));
      statuses.still.push_back(3 * i + 1);
      statuses.still.push_back(3 * i + 2);
      continue;
    }
    Vector3d force = Vector3d::UnitX();
    if (size > 0.0) force.tail<2>() = problem.friction[i] / size * along;
    statuses.forces.push_back(force);
  }
  return statuses;
}

}  // namespace

double friction_residual(const FrictionProblem& problem, const VectorXd& forces) {
  const VectorXd w = problem.a * forces + problem.b;
  const double scale_w = std::max(problem.b.cwiseAbs().maxCoeff(), 1e-300), scale_f = forces.cwiseAbs().maxCoeff();
  double worst = 0.0;
  if (!(scale_f > 0.0)) {  // nothing has been pushed yet: what comes together should be
    for (Index i = 0; i < problem.friction.size(); ++i) worst = std::max(worst, -w[3 * i] / scale_w);
    return worst;
  }
  const double unit = scale_f / scale_w;
  for (Index i = 0; i < problem.friction.size(); ++i) {
    const Vector3d f = forces.segment<3>(3 * i), v = w.segment<3>(3 * i);
    Vector3d next = f;
    next[0] = std::max(0.0, f[0] - unit * v[0]);
    next.tail<2>() -= unit * v.tail<2>();
    const double most = problem.friction[i] * f[0], slip = next.tail<2>().norm();
    if (slip > most) next.tail<2>() *= slip > 0.0 ? most / slip : 0.0;
    worst = std::max(worst, (next - f).norm() / scale_f);
  }
  return worst;
}

namespace {

/// From some forces on, by guesses.
ContactForces guess_from(const FrictionProblem& problem, const MatrixXd& root, const VectorXd& start,
                         double tolerance) {
  ContactForces best;
  best.forces = start;
  best.residual = friction_residual(problem, start);
  VectorXd forces = start;
  int without_gain = 0;
  while (best.iterations++ < kMostGuesses && without_gain < kMostWithoutGain && !(best.residual <= tolerance)) {
    const Statuses statuses = guessed(problem, forces, root * (root.transpose() * forces) + problem.b);
    const auto m = static_cast<Index>(statuses.still.size());
    if (m == 0) {
      forces.setZero();
    } else {
      // Forces from free ones, and what those of now are.
      MatrixXd spread = MatrixXd::Zero(forces.size(), m);
      VectorXd now(m);
      for (Index k = 0; k < m; ++k) {
        const Index row = statuses.still[static_cast<std::size_t>(k)], first = row - row % 3;
        spread.block<3, 1>(first, k) = statuses.forces[static_cast<std::size_t>(k)];
        now[k] = forces[row];
      }
      const MatrixXd moves = root(statuses.still, Eigen::all), shared = root.transpose() * spread;
      const auto sharing = decomposed(shared);
      const MatrixXd reached =
          sharing.householderQ() * MatrixXd::Identity(root.cols(), sharing.rank());  // by free forces
      const VectorXd wanted = reached * decomposed(moves * reached).solve(-problem.b(statuses.still));
      forces = spread * (now + sharing.solve(wanted - shared * now));
    }
    const double residual = friction_residual(problem, forces);
    ++without_gain;
    if (!(residual < best.residual)) continue;
    if (residual < 0.5 * best.residual) without_gain = 0;
    best.residual = residual;
    best.forces = forces;
  }
  return best;
}

}  // namespace

ContactForces solve_by_statuses(const FrictionProblem& problem, const VectorXd& start, double tolerance,
                                double enough) {
  const MatrixXd root = root_of(problem.a);
  const auto rows = static_cast<double>(root.rows()), rank = static_cast<double>(root.cols());
  if (rows * rank * rank > kMostWork) return {start, friction_residual(problem, start), 0};
  ContactForces found = guess_from(problem, root, start, tolerance);
  if (found.residual <= enough || !(problem.friction.array() > 0.0).all()) return found;
  ContactForces within = guess_from(problem, root, forces_within(problem, root), tolerance);
  within.iterations += found.iterations;
  return within.residual < found.residual ? within : found;
}

}  // namespace klang::modal
