#include "core/sound/transfer/transfer_evaluation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/waves/multipole.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace klang::acoustics {
namespace {

// Listeners 0.3 to 5 m away, poles and axes among them.
Eigen::Matrix3Xd listeners(int n, std::uint64_t seed) {
  RandomStream random(seed, 0);
  Eigen::Matrix3Xd x(3, n);
  for (int i = 0; i < n; ++i) {
    Eigen::Vector3d s(random.normal(), random.normal(), random.normal());
    if (i == 1) s = {0.0, 0.0, 1.0};
    if (i == 2) s = {0.0, 0.0, -1.0};
    if (i == 3) s = {1.0, 0.0, 0.0};
    x.col(i) = Eigen::Vector3d(0.01, -0.02, 0.03) + random.uniform(0.3, 5.0) * s.normalized();
  }
  return x;
}

class Evaluation : public testing::TestWithParam<bool> {};

TEST_P(Evaluation, EqualsTheSumOfMultipolesTo1e12) {
  const TransferModel model =
      random_transfer({4, 4, 7, 60, 5, 33, 12, 0, 1, 58, 20, 21, 22, 23, 24, 25, 26, 40}, 41, GetParam());
  const Eigen::Matrix3Xd x = listeners(23, 42);
  Eigen::MatrixXcd p;
  TransferEvaluator(model).evaluate(x, p);
  ASSERT_EQ(p.rows(), 18);
  ASSERT_EQ(p.cols(), 23);
  for (Eigen::Index l = 0; l < x.cols(); ++l) {
    for (Eigen::Index i = 0; i < p.rows(); ++i) {
      const Multipole& m = model.modes[static_cast<std::size_t>(i)].multipole;
      const std::complex<double> expected = pressure_pa(m, x.col(l));
      // Scale: what the multipole can do at this distance, so that a direction of silence is no excuse and no trap.
      const double scale = m.coefficients_pa.norm() / (m.wavenumber_per_m * (x.col(l) - m.centre_m).norm());
      EXPECT_LE(std::abs(p(i, l) - expected), 1e-12 * scale) << i << " " << l;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Centres, Evaluation, testing::Values(true, false));

TEST(TransferEvaluation, SameBitsOneByOneTogetherAndOnAnyNumberOfThreads) {
  const TransferModel model = random_transfer(std::vector<int>(80, 27), 43);
  const TransferEvaluator evaluator(model);
  const Eigen::Matrix3Xd x = listeners(30, 44);
  Eigen::MatrixXcd all, one;
  set_thread_count(1);
  evaluator.evaluate(x, all);
  set_thread_count(2);
  for (Eigen::Index l = 0; l < x.cols(); ++l) {
    evaluator.evaluate(x.col(l), one);
    EXPECT_EQ((one - all.col(l)).cwiseAbs().maxCoeff(), 0.0) << l;
  }
  evaluator.evaluate(x, one);
  EXPECT_EQ((one - all).cwiseAbs().maxCoeff(), 0.0);
  set_thread_count(0);
}

TEST(TransferEvaluation, EightThreadsOnOneEvaluatorAgree) {
  const TransferModel model = random_transfer(std::vector<int>(30, 20), 45);
  const TransferEvaluator evaluator(model);
  const Eigen::Matrix3Xd x = listeners(40, 46);
  Eigen::MatrixXcd expected;
  evaluator.evaluate(x, expected);
  std::vector<Eigen::MatrixXcd> found(8);
  std::vector<std::thread> threads;
  for (auto& p : found)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) evaluator.evaluate(x, p);
    });
  for (auto& thread : threads) thread.join();
  for (const auto& p : found) EXPECT_EQ((p - expected).cwiseAbs().maxCoeff(), 0.0);
}

TEST(TransferEvaluation, LowModesNearTheBodyStayFinite) {
  // 20 Hz at 2 mm from the centre: kr = 7e-4, grouped with a mode of order 60.
  TransferModel model = random_transfer({60, 4, 4}, 47);
  model.modes[1].multipole.wavenumber_per_m = 0.37;
  Eigen::MatrixXcd p;
  TransferEvaluator(model).evaluate(model.modes[0].multipole.centre_m + Eigen::Vector3d(0.0, 0.002, 0.0), p);
  const auto expected =
      pressure_pa(model.modes[1].multipole, model.modes[0].multipole.centre_m + Eigen::Vector3d(0.0, 0.002, 0.0));
  EXPECT_LE(std::abs(p(1, 0) - expected), 1e-12 * std::abs(expected));
}

TEST(TransferEvaluation, ListenerAtTheCentreIsBadInput) {
  const TransferModel model = random_transfer({4}, 48);
  const TransferEvaluator evaluator(model);
  Eigen::MatrixXcd p;
  EXPECT_THROW(evaluator.evaluate(model.modes[0].multipole.centre_m, p), InputError);
  EXPECT_THROW(evaluator.evaluate(Eigen::Vector3d(std::nan(""), 0, 0), p), InputError);
}

TEST(TransferEvaluation, NoModesAndNoListenersAreEmpty) {
  Eigen::MatrixXcd p;
  TransferEvaluator(TransferModel{}).evaluate(listeners(3, 49), p);
  EXPECT_EQ(p.rows(), 0);
  TransferEvaluator(random_transfer({4}, 50)).evaluate(Eigen::Matrix3Xd(3, 0), p);
  EXPECT_EQ(p.cols(), 0);
}

}  // namespace
}  // namespace klang::acoustics
