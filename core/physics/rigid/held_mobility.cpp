#include "core/physics/rigid/held_mobility.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>

namespace klang::rigid {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSameTie = 1e-9;  // eigenvalues below, of the largest: ties that say the same
constexpr double kLeastGive = 1e-3;
constexpr double kSlack = 1e-9;

/// Speed that a unit push y gives along x.
double speed_between(const PairPush& x, const PairPush& y, std::span<const PushedBody> bodies) {
  double sum = 0.0;
  const auto add = [&](int body_x, const Vector3d& at_x, int body_y, const Vector3d& at_y, double sign) {
    if (body_x < 0 || body_x != body_y) return;
    const PushedBody& body = bodies[static_cast<std::size_t>(body_x)];
    sum += sign * (body.inverse_mass * x.along.dot(y.along) +
                   (at_x - body.centre).cross(x.along).dot(body.inverse_inertia * (at_y - body.centre).cross(y.along)));
  };
  add(x.a, x.at_a, y.a, y.at_a, 1.0);
  add(x.b, x.at_b, y.b, y.at_b, 1.0);
  add(x.a, x.at_a, y.b, y.at_b, -1.0);
  add(x.b, x.at_b, y.a, y.at_a, -1.0);
  return sum;
}

MatrixXd mobility(std::span<const PairPush> rows, std::span<const PairPush> columns,
                  std::span<const PushedBody> bodies) {
  MatrixXd all(static_cast<Index>(rows.size()), static_cast<Index>(columns.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t j = 0; j < columns.size(); ++j)
      all(static_cast<Index>(i), static_cast<Index>(j)) = speed_between(rows[i], columns[j], bodies);
  return all;
}

/// Of ties that may say the same more than once.
MatrixXd pseudo_inverse(const MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(symmetric);
  VectorXd inverse = eigen.eigenvalues();
  const double largest = inverse.maxCoeff();
  for (double& value : inverse) value = value > kSameTie * largest ? 1 / value : 0.0;
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

}  // namespace

MatrixXd free_mobility(std::span<const PairPush> pushes, std::span<const PushedBody> bodies) {
  return mobility(pushes, pushes, bodies);
}

MatrixXd held_mobility(std::span<const PairPush> pushes, const VectorXd& impulses, std::vector<PairPush> ties,
                       std::span<const PushedBody> bodies) {
  const MatrixXd free = free_mobility(pushes, bodies);
  MatrixXd held = free;
  while (!ties.empty()) {
    const MatrixXd across = mobility(ties, pushes, bodies),
                   answer = pseudo_inverse(free_mobility(ties, bodies)) * across;
    const VectorXd pulls = -answer * impulses;
    Index slackest = -1;
    for (Index i = 0; i < pulls.size(); ++i)
      if (ties[static_cast<std::size_t>(i)].only_pulls && !(pulls[i] > kSlack * pulls.cwiseAbs().maxCoeff()) &&
          (slackest < 0 || pulls[i] < pulls[slackest]))
        slackest = i;
    if (slackest < 0) {
      held -= across.transpose() * answer;
      break;
    }
    ties.erase(ties.begin() + slackest);
  }
  for (Index i = 0; i < held.rows(); ++i) held(i, i) = std::max(held(i, i), kLeastGive * free(i, i));
  return held;
}

}  // namespace klang::rigid
