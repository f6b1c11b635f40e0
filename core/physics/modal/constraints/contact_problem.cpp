#include "core/physics/modal/constraints/contact_problem.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/constraints/friction_statuses.hpp"

namespace klang::modal {
namespace {

double lcp_residual(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& f) {
  const Eigen::VectorXd w = a * f + b;
  const double scale_w = std::max(b.cwiseAbs().maxCoeff(), 1e-300), scale_f = std::max(f.cwiseAbs().maxCoeff(), 1e-300);
  double worst = 0.0;
  for (Eigen::Index i = 0; i < b.size(); ++i)
    worst = std::max({worst, -w[i] / scale_w, -f[i] / scale_f, std::min(w[i] / scale_w, f[i] / scale_f)});
  return worst;
}

}  // namespace

ContactForces solve_lcp(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = b.size();
  ContactForces result;
  result.forces = Eigen::VectorXd::Zero(n);
  if (n == 0) return result;
  KLANG_CHECK(a.rows() == n && a.cols() == n, "A and b belong together");
  const double tiny = 1e-10 * std::max(b.cwiseAbs().maxCoeff(), 1e-300);
  std::vector<Eigen::Index> active;
  const int most = 50 + 20 * static_cast<int>(n);
  while (result.iterations++ < most) {
    const Eigen::VectorXd w = a * result.forces + b;
    Eigen::Index worst = -1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (std::find(active.begin(), active.end(), i) == active.end() && w[i] < -tiny && (worst < 0 || w[i] < w[worst]))
        worst = i;
    if (worst < 0) {
      result.residual = lcp_residual(a, b, result.forces);
      return result;
    }
    active.push_back(worst);
    for (;;) {  // Lawson and Hanson's inner loop
      const Eigen::MatrixXd inner = a(active, active);
      const Eigen::VectorXd right = -b(active);
      const Eigen::VectorXd wanted = inner.completeOrthogonalDecomposition().solve(right);
      double step = 1.0;
      for (std::size_t k = 0; k < active.size(); ++k) {
        const double now = result.forces[active[k]], then = wanted[static_cast<Eigen::Index>(k)];
        if (then <= 0.0) step = std::min(step, now / (now - then));
      }
      for (std::size_t k = 0; k < active.size(); ++k)
        result.forces[active[k]] += step * (wanted[static_cast<Eigen::Index>(k)] - result.forces[active[k]]);
      if (step == 1.0) break;
      const double gone = 1e-14 * result.forces.cwiseAbs().maxCoeff();
      active.erase(std::remove_if(active.begin(), active.end(),
                                  [&](Eigen::Index i) {
                                    if (result.forces[i] > gone) return false;
                                    result.forces[i] = 0.0;
                                    return true;
                                  }),
                   active.end());
      if (active.empty()) break;
    }
  }
  throw NumericalError("contact: the complementarity problem did not end after " + std::to_string(most) + " steps");
}

ContactForces solve_contact_lp(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  // Dual simplex on s = b + A f from f = 0: costs are positive, so that it starts dual feasible.
  const Eigen::Index n = b.size();
  Eigen::MatrixXd table(n + 1, n + 1);  // rows: basic variables, then the cost; columns: constants, then free variables
  table.topLeftCorner(n, 1) = b;
  table.topRightCorner(n, n) = a;
  table(n, 0) = 0.0;
  table.bottomRightCorner(1, n).setOnes();
  std::vector<Eigen::Index> basic, out;
  for (Eigen::Index i = 0; i < n; ++i) {
    basic.push_back(n + i);  // slacks
    out.push_back(i);
  }
  ContactForces result;
  const double tiny = 1e-12 * std::max(b.cwiseAbs().maxCoeff(), 1e-300);
  for (;; ++result.iterations) {
    Eigen::Index row = -1, column = -1;
    for (Eigen::Index i = 0; i < n; ++i)
      if (table(i, 0) < -tiny && (row < 0 || table(i, 0) < table(row, 0))) row = i;
    if (row < 0) break;
    for (Eigen::Index j = 1; j <= n; ++j)
      if (table(row, j) > 1e-13 && (column < 0 || table(n, j) / table(row, j) < table(n, column) / table(row, column)))
        column = j;
    if (column < 0 || result.iterations > 100 * n)
      throw NumericalError("contact: no forces keep the bodies apart (linear program)");
    const double pivot = table(row, column);
    Eigen::RowVectorXd entering = -table.row(row) / pivot;
    entering[column] = 1.0 / pivot;
    for (Eigen::Index i = 0; i <= n; ++i) {
      if (i == row) continue;
      const double factor = table(i, column);
      table(i, column) = 0.0;
      table.row(i) += factor * entering;
    }
    table.row(row) = entering;
    std::swap(basic[static_cast<std::size_t>(row)], out[static_cast<std::size_t>(column - 1)]);
  }
  result.forces = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i)
    if (const Eigen::Index k = basic[static_cast<std::size_t>(i)]; k < n) result.forces[k] = table(i, 0);
  result.residual = lcp_residual(a, b, result.forces);
  return result;
}

ContactForces solve_friction(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::VectorXd& friction,
                             const FrictionSweeps& sweeps) {
  const Eigen::Index n = friction.size();
  KLANG_CHECK(b.size() == 3 * n, "three rows per contact");
  const FrictionProblem problem = {a, b, friction};
  ContactForces result;
  result.forces = sweeps.start.size() == 3 * n ? sweeps.start : Eigen::VectorXd(Eigen::VectorXd::Zero(3 * n));
  if (n == 0) return result;
  const double enough = sweeps.fine > 0 ? sweeps.tolerance : sweeps.enough;
  result = solve_by_statuses(problem, result.forces, sweeps.tolerance, enough);
  if (result.residual <= enough) return result;
  const auto projected = [&](Eigen::Index i, Eigen::Vector3d f) {
    f[0] = std::max(0.0, f[0]);
    const double slip = f.tail<2>().norm(), most = friction[i] * f[0];
    if (slip > most) f.tail<2>() *= slip > 0.0 ? most / slip : 0.0;
    return f;
  };
  for (result.iterations = 0; result.iterations < sweeps.most; ++result.iterations) {
    for (Eigen::Index i = 0; i < n; ++i) {
      // Local problem with fixed forces elsewhere: fixed point of projections, normal first, then tangents.
      const Eigen::Vector3d rest = b.segment<3>(3 * i) + a.middleRows(3 * i, 3) * result.forces -
                                   a.block<3, 3>(3 * i, 3 * i) * result.forces.segment<3>(3 * i);
      const Eigen::Matrix3d own = a.block<3, 3>(3 * i, 3 * i);
      Eigen::Vector3d f = result.forces.segment<3>(3 * i);
      const double normal_step = 1.0 / own(0, 0), along_step = 1.0 / own.bottomRightCorner<2, 2>().norm();
      for (int k = 0; k < 200; ++k) {
        const Eigen::Vector3d before = f;
        f[0] = std::max(0.0, f[0] - normal_step * (rest + own * f)[0]);
        f.tail<2>() -= along_step * (rest + own * f).tail<2>();
        f = projected(i, f);
        if ((f - before).norm() <= 1e-14 * (f.norm() + 1e-300)) break;
      }
      result.forces.segment<3>(3 * i) = f;
    }
    result.residual = friction_residual(problem, result.forces);
    if (result.residual <= (result.iterations < sweeps.fine ? sweeps.tolerance : sweeps.enough)) break;
  }
  return result;
}

}  // namespace klang::modal
