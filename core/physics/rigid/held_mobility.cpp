#include "core/physics/rigid/held_mobility.hpp"

#include <Eigen/Dense>
#include <utility>

namespace klang::rigid {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSameTie = 1e-9;  // of the largest pivot: what is below is said by other ties
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

/// Ties that hold, and the impulses on them per speed; they may say the same more than once.
struct Holding {
  TieAnswer answer;
  MatrixXd across, inverse;  // speeds of ties by pushes; A_tt^+
};

Holding holding_of(std::span<const PairPush> pushes, const VectorXd& impulses, std::vector<PairPush> ties,
                   std::span<const PushedBody> bodies) {
  Holding holding;
  while (!ties.empty()) {
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> among;
    among.setThreshold(kSameTie);
    among.compute(mobility(ties, ties, bodies));
    holding.inverse = among.pseudoInverse();
    holding.across = mobility(ties, pushes, bodies);
    const VectorXd answer = -holding.inverse * (holding.across * impulses);
    const double slack = kSlack * answer.cwiseAbs().maxCoeff();
    Index slackest = -1;
    for (Index i = 0; i < answer.size(); ++i)
      if (ties[static_cast<std::size_t>(i)].only_pulls && !(answer[i] > slack) &&
          (slackest < 0 || answer[i] < answer[slackest]))
        slackest = i;
    if (slackest < 0) {
      holding.answer = {std::move(ties), answer};
      return holding;
    }
    ties.erase(ties.begin() + slackest);
  }
  return {};
}

}  // namespace

TieAnswer answer_of_ties(std::span<const PairPush> pushes, const VectorXd& impulses, std::vector<PairPush> ties,
                         std::span<const PushedBody> bodies) {
  return holding_of(pushes, impulses, std::move(ties), bodies).answer;
}

MatrixXd held_mobility(std::span<const PairPush> pushes, const VectorXd& impulses, std::vector<PairPush> ties,
                       std::span<const PushedBody> bodies) {
  const MatrixXd free = mobility(pushes, pushes, bodies);
  const Holding holding = holding_of(pushes, impulses, std::move(ties), bodies);
  if (holding.answer.ties.empty()) return free;
  MatrixXd held = free - holding.across.transpose() * holding.inverse * holding.across;
  held.diagonal() = held.diagonal().cwiseMax(kLeastGive * free.diagonal());
  return held;
}

VectorXd held_gives(std::span<const PairPush> pushes, const VectorXd& impulses, std::vector<PairPush> ties,
                    std::span<const PushedBody> bodies) {
  VectorXd free(static_cast<Index>(pushes.size()));
  for (Index i = 0; i < free.size(); ++i) {
    const PairPush& push = pushes[static_cast<std::size_t>(i)];
    free[i] = speed_between(push, push, bodies);
  }
  const Holding holding = holding_of(pushes, impulses, std::move(ties), bodies);
  if (holding.answer.ties.empty()) return free;
  const VectorXd less = (holding.inverse * holding.across).cwiseProduct(holding.across).colwise().sum().transpose();
  return (free - less).cwiseMax(kLeastGive * free);
}

}  // namespace klang::rigid
