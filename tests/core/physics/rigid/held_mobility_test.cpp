#include "core/physics/rigid/held_mobility.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <optional>

#include "core/foundation/base/random.hpp"

namespace klang::rigid {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d drawn(RandomStream& random) {
  return Vector3d(random.uniform(), random.uniform(), random.uniform()) - Vector3d::Constant(0.5);
}

/// What a body of mass 1 with its centre at 0 has of speed along a by a unit push along b.
double speed(const PushedBody& body, const PairPush& a, const PairPush& b) {
  return a.along.dot(b.along) + a.at_a.cross(a.along).dot(body.inverse_inertia * b.at_a.cross(b.along));
}

/// By trying all sets of cords that may hold: impulses that pull, and no other cord lengthens.
std::optional<double> by_trying(const PushedBody& body, const PairPush& push, const std::vector<PairPush>& cords) {
  const auto n = static_cast<Eigen::Index>(cords.size());
  MatrixXd a(n, n);
  VectorXd b(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    b[i] = speed(body, cords[static_cast<std::size_t>(i)], push);
    for (Eigen::Index j = 0; j < n; ++j)
      a(i, j) = speed(body, cords[static_cast<std::size_t>(i)], cords[static_cast<std::size_t>(j)]);
  }
  for (int set = 0; set < 1 << n; ++set) {
    std::vector<Eigen::Index> held;
    for (Eigen::Index i = 0; i < n; ++i)
      if ((set >> i & 1) != 0) held.push_back(i);
    VectorXd x = VectorXd::Zero(n);
    if (!held.empty()) x(held) = -MatrixXd(a(held, held)).ldlt().solve(VectorXd(b(held)));
    if (x.minCoeff() >= -1e-10 && (a * x + b).minCoeff() >= -1e-9) return speed(body, push, push) + b.dot(x);
  }
  return {};
}

// Letting go of the slackest cord alone, and never taking one back, is wrong in up to a tenth of these.
TEST(HeldMobility, SeveralCordsHoldAsTheirConditionsSay) {
  RandomStream random(5, 0);
  PushedBody body;
  body.inverse_mass = 1.0;
  body.inverse_inertia = Vector3d(20, 30, 40).asDiagonal();
  int n_tried = 0, n_held = 0;
  for (int n_cords = 1; n_cords <= 5; ++n_cords)
    for (int turn = 0; turn < 400; ++turn) {
      std::vector<PairPush> cords(static_cast<std::size_t>(n_cords));
      for (PairPush& cord : cords) {
        cord.at_a = drawn(random);
        cord.along = drawn(random).normalized();
        cord.at_b = cord.at_a + cord.along;
        cord.only_pulls = true;
      }
      PairPush push;
      push.at_a = drawn(random);
      push.along = drawn(random).normalized();
      const std::optional<double> exact = by_trying(body, push, cords);
      if (!exact) continue;
      ++n_tried;
      const double free = speed(body, push, push), least = 1e-3 * free;
      n_held += *exact < 0.99 * free ? 1 : 0;
      const VectorXd impulse = VectorXd::Ones(1);
      EXPECT_LE(std::abs(held_gives(std::vector{push}, impulse, cords, std::vector{body})[0] - std::max(*exact, least)),
                1e-9 * free)
          << n_cords << " cords, turn " << turn;
      EXPECT_LE(
          std::abs(held_mobility(std::vector{push}, impulse, cords, std::vector{body})(0, 0) - std::max(*exact, least)),
          1e-9 * free);
      for (const double pulled : answer_of_ties(std::vector{push}, impulse, cords, std::vector{body}).impulses)
        EXPECT_GT(pulled, 0.0);
    }
  EXPECT_GE(n_tried, 1990);
  EXPECT_GE(n_held, 1000);
}

TEST(HeldMobility, CordsThatSayTheSameHoldAsOne) {
  PushedBody body;
  body.inverse_mass = 1.0;
  PairPush cord, push;
  cord.along = Vector3d::UnitZ();
  cord.only_pulls = true;
  push.along = -Vector3d::UnitZ();
  const VectorXd impulse = VectorXd::Ones(1);
  for (const std::size_t n : {1, 2, 7})
    EXPECT_LE(held_gives(std::vector{push}, impulse, std::vector(n, cord), std::vector{body})[0], 1e-3 + 1e-12) << n;
  push.along = Vector3d::UnitZ();
  EXPECT_NEAR(held_gives(std::vector{push}, impulse, std::vector(3, cord), std::vector{body})[0], 1.0, 1e-12);
}

}  // namespace
}  // namespace klang::rigid
