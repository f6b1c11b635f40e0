#include "core/foundation/la/sturm_count.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/block_ordering.hpp"
#include "core/foundation/la/detail/analysed_pattern.hpp"
#include "core/foundation/la/detail/pivot_signs.hpp"
#include "core/foundation/la/sparse_cholesky.hpp"
#include "core/physics/solid/assembly.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

namespace la = klang::la;

std::vector<int> natural_order(int n) {
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

la::SparseMatrix lower_of(const Eigen::MatrixXd& a) {
  return la::SparseMatrix(Eigen::MatrixXd(a.triangularView<Eigen::Lower>()).sparseView());
}

TEST(SturmCount, IsTheNumberOfSmallerEigenvaluesOfABody) {
  const auto assembled = klang::solid::assemble(klang::test::box_mesh(1, 0.7, 0.4, 3, 2, 2, 2));
  const la::SparseMatrix stiffness = klang::solid::stiffness(assembled, 1.0, 0.5), mass = assembled.mass_unit_density;
  const Eigen::MatrixXd k = Eigen::MatrixXd(stiffness).selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd m = Eigen::MatrixXd(mass).selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd exact =
      Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd>(k, m, Eigen::EigenvaluesOnly).eigenvalues();
  const la::FactorPattern pattern(stiffness, la::block_ordering(stiffness));
  int n_shifts = 0;
  for (const int n : {6, 7, 12, 41, 203, static_cast<int>(exact.size()) - 1}) {
    if (!(exact[n] - exact[n - 1] > 1e-4 * exact[n])) continue;  // a shift between two modes, not beside one
    ++n_shifts;
    const double shift = (exact[n - 1] + exact[n]) / 2;
    const la::SparseMatrix a = stiffness - shift * mass;
    const auto signs = la::detail::pivot_signs(pattern.analysed().tree, a);
    ASSERT_TRUE(signs.has_value());
    EXPECT_EQ(signs->n_negative, n);
    EXPECT_EQ(la::n_negative_eigenvalues(a, pattern), n);
  }
  EXPECT_GE(n_shifts, 5);
}

TEST(SturmCount, OfADefiniteMatrixGrowthIsOne) {
  const auto assembled = klang::solid::assemble(klang::test::box_mesh(1, 0.7, 0.4, 4, 3, 2, 2));
  const la::SparseMatrix a = klang::solid::stiffness(assembled, 1.0, 0.5) + 3.0 * assembled.mass_unit_density;
  const la::FactorPattern pattern(a, la::block_ordering(a));
  const auto signs = la::detail::pivot_signs(pattern.analysed().tree, a);
  ASSERT_TRUE(signs.has_value());
  EXPECT_EQ(signs->n_negative, 0);
  EXPECT_LE(std::abs(signs->growth - 1), 1e-12);
}

TEST(SturmCount, PivotsThatNeedExchangesAreCountedWithThem) {
  // Blocks [[e, 1], [1, 0]] have one negative eigenvalue each; without exchanges L grows to 1 / e.
  const int n = 30;
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
  for (int i = 0; i < n; i += 2) {
    a(i, i) = 1e-14;
    a(i + 1, i) = 1;
    if (i > 0) a(i, i - 1) = 0.01;
  }
  const la::SparseMatrix lower = lower_of(a);
  const la::FactorPattern pattern(lower, natural_order(n));
  const auto signs = la::detail::pivot_signs(pattern.analysed().tree, lower);
  ASSERT_TRUE(signs.has_value());
  EXPECT_GE(signs->growth, 1e10);
  EXPECT_EQ(la::n_negative_eigenvalues(lower, pattern), n / 2);
}

TEST(SturmCount, AVanishingPivotIsNotCounted) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity();
  a(0, 0) = 0;
  a(1, 0) = 1;
  const la::SparseMatrix lower = lower_of(a);
  const la::FactorPattern pattern(lower, natural_order(3));
  EXPECT_FALSE(la::detail::pivot_signs(pattern.analysed().tree, lower).has_value());
  EXPECT_EQ(la::n_negative_eigenvalues(lower, pattern), 1);
}

TEST(SturmCount, IsTheSameOnOneThreadAsOnTwoForATreeOfManyFronts) {
  const auto assembled = klang::solid::assemble(klang::test::box_mesh(1, 1, 1, 7, 7, 7, 2));
  const la::SparseMatrix a = klang::solid::stiffness(assembled, 1.0, 0.5) - 30 * assembled.mass_unit_density;
  const la::FactorPattern pattern(a, la::block_ordering(a));
  klang::set_thread_count(1);
  const auto one = la::detail::pivot_signs(pattern.analysed().tree, a);
  klang::set_thread_count(2);
  const auto two = la::detail::pivot_signs(pattern.analysed().tree, a);
  klang::set_thread_count(0);
  ASSERT_TRUE(one.has_value() && two.has_value());
  EXPECT_EQ(one->n_negative, two->n_negative);
  EXPECT_LE(std::abs(one->growth / two->growth - 1), 1e-6);
}

}  // namespace
