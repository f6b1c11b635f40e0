#include "core/foundation/la/complex_decompositions.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"

using klang::RandomStream;
using Complex = std::complex<double>;

namespace {

Eigen::MatrixXcd random_matrix(int rows, int columns, std::uint64_t stream) {
  RandomStream random(11, stream);
  Eigen::MatrixXcd a(rows, columns);
  for (int j = 0; j < columns; ++j)
    for (int i = 0; i < rows; ++i) a(i, j) = {random.normal(), random.normal()};
  return a;
}

TEST(ComplexDecompositions, EigenvaluesOfACompanionMatrixAreTheRoots) {
  // (z - 1)(z - i)(z + 2)(z - 0.5 + 0.25i), multiplied out
  const std::vector<Complex> roots = {1.0, {0.0, 1.0}, -2.0, {0.5, -0.25}};
  std::vector<Complex> a = {1.0};  // coefficients from the constant up
  for (const Complex& root : roots) {
    a.insert(a.begin(), 0.0);
    for (std::size_t k = 0; k + 1 < a.size(); ++k) a[k] -= root * a[k + 1];
  }
  Eigen::MatrixXcd companion = Eigen::MatrixXcd::Zero(4, 4);
  companion.bottomLeftCorner(3, 3).setIdentity();
  for (int k = 0; k < 4; ++k) companion(k, 3) = -a[static_cast<std::size_t>(k)];
  const Eigen::VectorXcd found = klang::la::eigenvalues(companion);
  for (const Complex& root : roots) EXPECT_LE((found.array() - root).abs().minCoeff(), 1e-13) << root;
}

TEST(ComplexDecompositions, SingularValuesPutTheMatrixTogetherAgain) {
  for (const auto& [m, n] : {std::pair{7, 4}, {4, 7}, {30, 30}, {1, 5}}) {
    const Eigen::MatrixXcd a = random_matrix(m, n, static_cast<std::uint64_t>(10 * m + n));
    const klang::la::SingularValues svd = klang::la::singular_values(a);
    const int r = std::min(m, n);
    ASSERT_EQ(svd.s.size(), r);
    const Eigen::MatrixXcd again = svd.u * svd.s.cast<Complex>().asDiagonal() * svd.v.adjoint();
    EXPECT_LE((again - a).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LE((svd.u.adjoint() * svd.u - Eigen::MatrixXcd::Identity(r, r)).cwiseAbs().maxCoeff(), 1e-13);
    for (int i = 1; i < r; ++i) EXPECT_LE(svd.s[i], svd.s[i - 1]);
  }
}

TEST(ComplexDecompositions, AMatrixThatIsNotSquareHasNoEigenvalues) {
  EXPECT_THROW(klang::la::eigenvalues(random_matrix(2, 3, 1)), klang::InputError);
  EXPECT_EQ(klang::la::eigenvalues(Eigen::MatrixXcd(0, 0)).size(), 0);
}

}  // namespace
