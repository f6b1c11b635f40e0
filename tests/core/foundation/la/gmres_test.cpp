#include "core/foundation/la/gmres.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

namespace klang::la {
namespace {

using Eigen::MatrixXcd;

struct System {
  explicit System(int n, double spread) {
    std::srand(3);
    a = MatrixXcd::Identity(n, n) + spread / n * MatrixXcd::Random(n, n);
    for (int i = 0; i < n; ++i) a.row(i) *= 1.0 + i;  // badly scaled: the preconditioner takes it back
    b = MatrixXcd::Random(n, 3);
    b.col(1).setZero();
  }
  KrylovSolution solved(double tolerance, int max_steps) const {
    return gmres([&](const MatrixXcd& x) -> MatrixXcd { return a * x; },
                 [&](const MatrixXcd& x) -> MatrixXcd { return a.diagonal().cwiseInverse().asDiagonal() * x; }, b,
                 tolerance, max_steps);
  }
  MatrixXcd a, b;
};

TEST(Gmres, SolvesAllColumnsToTheToleranceAndZeroByZero) {
  const System system(80, 20.0);
  const KrylovSolution found = system.solved(1e-11, 80);
  ASSERT_TRUE(found.solved);
  EXPECT_LE(*found.relative_residual, 1e-11);
  EXPECT_LE((found.x - system.a.lu().solve(system.b)).norm(), 1e-9 * found.x.norm());
  EXPECT_EQ(found.x.col(1).norm(), 0.0);
  for (const int c : {0, 2}) EXPECT_LE((system.b - system.a * found.x).col(c).norm(), 1e-11 * system.b.col(c).norm());
}

TEST(Gmres, StartsAgainWhereItsStepsDoNotDo) {
  const System system(80, 4.0);
  const KrylovSolution found = system.solved(1e-10, 6);
  EXPECT_TRUE(found.solved);
  EXPECT_GT(found.n_products, 7);
}

TEST(Gmres, SaysThatItDidNotGetThere) {
  const System system(80, 2000.0);
  const KrylovSolution found = system.solved(1e-12, 3);
  EXPECT_FALSE(found.solved);
  EXPECT_GT(*found.relative_residual, 1e-12);
}

TEST(Gmres, EndsInOneStepWithTheInverseAndAtOnceForNothing) {
  const MatrixXcd b = MatrixXcd::Random(9, 2);
  const auto same = [](const MatrixXcd& x) { return x; };
  const KrylovSolution found = gmres(same, same, b, 1e-14, 5);
  EXPECT_TRUE(found.solved);
  EXPECT_EQ(found.n_products, 2);  // one step, one check
  EXPECT_EQ(gmres(same, same, MatrixXcd::Zero(9, 2), 1e-14, 5).n_products, 0);
}

}  // namespace
}  // namespace klang::la
