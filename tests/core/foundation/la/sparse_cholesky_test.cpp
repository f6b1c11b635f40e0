#include "core/foundation/la/sparse_cholesky.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>
#include <vector>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/solid/assembly.hpp"
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
    la::SparseCholesky factor;
    ASSERT_TRUE(factor.factor(a, la::block_ordering(a)));
    const Eigen::MatrixXd b = Eigen::VectorXd::LinSpaced(a.rows() * 8, -1, 1).reshaped(a.rows(), 8);
    klang::set_thread_count(1);
    const Eigen::MatrixXd one = factor.solve(b);
    klang::set_thread_count(2);
    const Eigen::MatrixXd two = factor.solve(b);
    klang::set_thread_count(0);
    EXPECT_TRUE(one == two);
  }
}

TEST(SparseCholesky, OrderOfSeveralAtATimeIsThatOfOneAlone) {
  const solid::SparseMatrix a = bar_matrix(6);  // large enough for METIS
  ASSERT_GT(a.rows(), 3 * 3000);
  const std::vector<int> alone = la::block_ordering(a);
  std::vector<std::vector<int>> together(16);
  std::vector<std::thread> threads;
  for (std::vector<int>& order : together) threads.emplace_back([&] { order = la::block_ordering(a); });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<int>& order : together) EXPECT_TRUE(order == alone);
}

}  // namespace
