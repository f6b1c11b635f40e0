#include "core/foundation/la/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>
#include <vector>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/block_ordering.hpp"
#include "core/physics/solid/assembly.hpp"
#include "core/physics/solid/node_ends.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

namespace la = klang::la;
namespace solid = klang::solid;

// K + M of a bar: positive definite.
solid::SparseMatrix bar_matrix(int cells) {
  const auto assembled = solid::assemble(klang::test::box_mesh(1, 0.3, 0.3, 3 * cells, cells, cells, 2));
  return solid::stiffness(assembled, 1.0, 0.5) + 2.0 * assembled.mass_unit_density;
}

// Its last separators have more than a thousand rows, which are shared out among the threads.
solid::SparseMatrix cube_matrix() {
  const auto assembled = solid::assemble(klang::test::box_mesh(1, 1, 1, 9, 9, 9, 2));
  return solid::stiffness(assembled, 1.0, 0.5) + 2.0 * assembled.mass_unit_density;
}

TEST(SparseCholesky, SolvesAnyNumberOfColumnsToRoundOff) {
  for (const int cells : {1, 5, 0}) {  // one supernode or a few; a tree of hundreds; wide ones on top
    const solid::SparseMatrix a = cells > 0 ? bar_matrix(cells) : cube_matrix();
    la::SparseCholesky factor;
    ASSERT_TRUE(factor.factor(a, la::block_ordering(a)));
    for (const int columns : {1, 2, 3, 7, 8, 9, 20}) {
      Eigen::MatrixXd exact(a.rows(), columns);
      for (Eigen::Index i = 0; i < exact.size(); ++i) exact.data()[i] = std::sin(1.0 + 0.7 * static_cast<double>(i));
      const Eigen::MatrixXd x = factor.solve(Eigen::MatrixXd(a.selfadjointView<Eigen::Lower>() * exact));
      EXPECT_LE((x - exact).cwiseAbs().maxCoeff(), 1e-11) << cells << " cells, " << columns << " columns";
    }
  }
}

TEST(SparseCholesky, SolutionHasTheSameBitsOnOneThreadAsOnTwo) {
  for (const solid::SparseMatrix& a : {bar_matrix(5), cube_matrix()}) {
    const la::FactorPattern pattern(a, la::block_ordering(a));
    const Eigen::MatrixXd b = Eigen::VectorXd::LinSpaced(a.rows() * 8, -1, 1).reshaped(a.rows(), 8);
    const auto solved = [&](int n_threads) {
      klang::set_thread_count(n_threads);
      la::SparseCholesky factor;
      EXPECT_TRUE(factor.factor(a, pattern));
      return factor.solve(b);
    };
    const Eigen::MatrixXd one = solved(1), two = solved(2);
    klang::set_thread_count(0);
    EXPECT_TRUE(one == two);
  }
}

TEST(SparseCholesky, AMatrixThatIsNotDefiniteIsRefused) {
  const auto assembled = solid::assemble(klang::test::box_mesh(1, 0.3, 0.3, 6, 2, 2, 2));
  const solid::SparseMatrix a = solid::stiffness(assembled, 1.0, 0.5) - 3.0 * assembled.mass_unit_density;
  la::SparseCholesky factor;
  EXPECT_FALSE(factor.factor(a, la::block_ordering(a)));
  EXPECT_STREQ(factor.message(), "the shifted matrix is not positive definite");
}

TEST(BlockOrdering, OnCornersIsAPermutationThatSolves) {
  const auto mesh = klang::test::box_mesh(1, 0.2, 0.05, 20, 4, 1, 2);
  for (const char* support : {"free", "clamped:x=0", "clamped:z=min"}) {  // held: some mid-nodes have lost a corner
    const auto assembled = solid::assemble(mesh, solid::parse_support(support));
    const solid::SparseMatrix a = solid::stiffness(assembled, 1.0, 0.5) + 2.0 * assembled.mass_unit_density;
    std::vector<int> order = la::block_ordering(a, solid::node_ends(mesh, assembled));
    la::SparseCholesky factor;
    ASSERT_TRUE(factor.factor(a, order));
    const Eigen::VectorXd exact = Eigen::VectorXd::LinSpaced(a.rows(), -1, 1);
    const Eigen::VectorXd x = factor.solve(Eigen::MatrixXd(a.selfadjointView<Eigen::Lower>() * exact));
    EXPECT_LE((x - exact).cwiseAbs().maxCoeff(), 1e-11);
    std::sort(order.begin(), order.end());
    for (std::size_t i = 0; i < order.size(); ++i) ASSERT_EQ(order[i], static_cast<int>(i));
  }
}

TEST(BlockOrdering, OnCornersFillsNoMoreThanOnAllNodes) {
  for (const auto& mesh :
       {klang::test::box_mesh(1, 0.5, 0.02, 24, 12, 1, 2), klang::test::box_mesh(1, 1, 1, 9, 9, 9, 2)}) {
    const auto assembled = solid::assemble(mesh);
    const solid::SparseMatrix a = solid::stiffness(assembled, 1.0, 0.5) + 2.0 * assembled.mass_unit_density;
    la::SparseCholesky on_corners, on_all;
    ASSERT_TRUE(on_corners.factor(a, la::block_ordering(a, solid::node_ends(mesh, assembled))));
    ASSERT_TRUE(on_all.factor(a, la::block_ordering(a)));
    EXPECT_LE(on_corners.n_factor_entries(), 1.15 * on_all.n_factor_entries());
  }
}

TEST(SparseCholesky, OrderOfSeveralAtATimeIsThatOfOneAlone) {
  const solid::SparseMatrix a = cube_matrix();  // operations enough for METIS
  const std::vector<int> alone = la::block_ordering(a);
  std::vector<std::vector<int>> together(16);
  std::vector<std::thread> threads;
  for (std::vector<int>& order : together) threads.emplace_back([&] { order = la::block_ordering(a); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<int>& order : together) EXPECT_TRUE(order == alone);
}

}  // namespace
