#include "core/physics/rigid/held_mobility.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <utility>

namespace klang::rigid {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSameTie = 1e-9;  // of the largest pivot: what is below is said by other ties
constexpr double kLeastGive = 1e-3;
constexpr double kSlack = 1e-9, kLengthens = 1e-9;

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

/// Which ties hold: impulses x of cords that pull, x >= 0, speeds w = A x + b at which cords shorten, w >= 0, and one of both 0; hinges
/// have w = 0. As A = J M^-1 J^T has no negative eigenvalue that is the least of x.(A x)/2 + b.x. First all hold and the slackest is let
/// go until none pushes; what would lengthen then is taken back (Lawson and Hanson 1974, chapter 23), each time for less of that sum.
class HeldTies {
 public:
  HeldTies(const MatrixXd& among, const VectorXd& speeds, std::vector<char> is_cord)
      : among_(among),
        speeds_(speeds),
        is_cord_(std::move(is_cord)),
        barred_(is_cord_.size(), 0),
        x_(VectorXd::Zero(speeds.size())) {
    for (Index i = 0; i < speeds.size(); ++i) held_.push_back(i);
  }

  void find() {
    for (Index worst = solve(); worst >= 0; worst = solve()) held_.erase(held_.begin() + worst);
    keep();
    for (Index turn = 0; turn < 4 * speeds_.size(); ++turn) {
      const Index taken = most_lengthened();
      if (taken < 0) return;
      held_.insert(std::lower_bound(held_.begin(), held_.end(), taken), taken);
      if (!let_go(taken)) barred_[static_cast<std::size_t>(taken)] = 1;
    }
  }

  const std::vector<Index>& held() const { return held_; }
  const VectorXd& answer() const { return answer_; }    ///< of those
  const MatrixXd& inverse() const { return inverse_; }  ///< A^+ among those

 private:
  /// @return place in held_ of the cord that pushes most; -1: none
  Index solve() {
    if (held_.empty()) {
      inverse_.resize(0, 0);
      answer_.resize(0);
      return -1;
    }
    Eigen::CompleteOrthogonalDecomposition<MatrixXd> part;
    part.setThreshold(kSameTie);
    part.compute(MatrixXd(among_(held_, held_)));
    inverse_ = part.pseudoInverse();
    answer_ = -inverse_ * speeds_(held_);
    const double slack = kSlack * answer_.cwiseAbs().maxCoeff();
    Index worst = -1;
    for (Index i = 0; i < answer_.size(); ++i)
      if (is_cord_[static_cast<std::size_t>(held_[static_cast<std::size_t>(i)])] != 0 && !(answer_[i] > slack) &&
          (worst < 0 || answer_[i] < answer_[worst]))
        worst = i;
    return worst;
  }
  void keep() {
    x_.setZero();
    x_(held_) = answer_;
  }
  Index most_lengthened() const {
    const VectorXd w = among_ * x_ + speeds_;
    const double least = -kLengthens * speeds_.cwiseAbs().maxCoeff();
    Index found = -1;
    for (Index i = 0; i < w.size(); ++i)
      if (is_cord_[static_cast<std::size_t>(i)] != 0 && barred_[static_cast<std::size_t>(i)] == 0 && w[i] < least &&
          (found < 0 || w[i] < w[found]) && !std::binary_search(held_.begin(), held_.end(), i))
        found = i;
    return found;
  }
  /// From x as far towards the answer of those that hold as none pushes, letting go of the first that would. @return whether the cord
  /// that was taken back still holds
  bool let_go(Index taken) {
    for (Index worst = solve(); worst >= 0; worst = solve()) {
      double part = 1.0;
      std::size_t first = static_cast<std::size_t>(worst);
      for (std::size_t i = 0; i < held_.size(); ++i) {
        const Index tie = held_[i];
        const double to = answer_[static_cast<Index>(i)];
        if (is_cord_[static_cast<std::size_t>(tie)] == 0 || to > 0.0 || !(x_[tie] - to > 0.0)) continue;
        if (const double way = x_[tie] / (x_[tie] - to); way < part) {
          part = way;
          first = i;
        }
      }
      for (std::size_t i = 0; i < held_.size(); ++i)
        x_[held_[i]] += part * (answer_[static_cast<Index>(i)] - x_[held_[i]]);
      const Index gone = held_[first];
      x_[gone] = 0.0;
      held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(first));
      if (gone == taken) {  // to round-off it neither lengthens nor pulls
        solve();
        keep();
        return false;
      }
    }
    keep();
    return true;
  }

  const MatrixXd& among_;
  const VectorXd& speeds_;
  std::vector<char> is_cord_, barred_;
  std::vector<Index> held_;
  VectorXd x_, answer_;
  MatrixXd inverse_;
};

Holding holding_of(std::span<const PairPush> pushes, const VectorXd& impulses, const std::vector<PairPush>& ties,
                   std::span<const PushedBody> bodies) {
  Holding holding;
  if (ties.empty()) return holding;
  const MatrixXd among = mobility(ties, ties, bodies), across = mobility(ties, pushes, bodies);
  const VectorXd speeds = across * impulses;
  std::vector<char> is_cord;
  for (const PairPush& tie : ties) is_cord.push_back(tie.only_pulls ? 1 : 0);
  HeldTies found(among, speeds, std::move(is_cord));
  found.find();
  for (const Index tie : found.held()) holding.answer.ties.push_back(ties[static_cast<std::size_t>(tie)]);
  holding.answer.impulses = found.answer();
  holding.across = across(found.held(), Eigen::all);
  holding.inverse = found.inverse();
  return holding;
}

}  // namespace

TieAnswer answer_of_ties(std::span<const PairPush> pushes, const VectorXd& impulses, const std::vector<PairPush>& ties,
                         std::span<const PushedBody> bodies) {
  return holding_of(pushes, impulses, ties, bodies).answer;
}

MatrixXd held_mobility(std::span<const PairPush> pushes, const VectorXd& impulses, const std::vector<PairPush>& ties,
                       std::span<const PushedBody> bodies) {
  const MatrixXd free = mobility(pushes, pushes, bodies);
  const Holding holding = holding_of(pushes, impulses, ties, bodies);
  if (holding.answer.ties.empty()) return free;
  MatrixXd held = free - holding.across.transpose() * holding.inverse * holding.across;
  held.diagonal() = held.diagonal().cwiseMax(kLeastGive * free.diagonal());
  return held;
}

VectorXd held_gives(std::span<const PairPush> pushes, const VectorXd& impulses, const std::vector<PairPush>& ties,
                    std::span<const PushedBody> bodies) {
  VectorXd free(static_cast<Index>(pushes.size()));
  for (Index i = 0; i < free.size(); ++i) {
    const PairPush& push = pushes[static_cast<std::size_t>(i)];
    free[i] = speed_between(push, push, bodies);
  }
  const Holding holding = holding_of(pushes, impulses, ties, bodies);
  if (holding.answer.ties.empty()) return free;
  const VectorXd less = (holding.inverse * holding.across).cwiseProduct(holding.across).colwise().sum().transpose();
  return (free - less).cwiseMax(kLeastGive * free);
}

}  // namespace klang::rigid
