#include "core/sound/transfer/transfer_opencl.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "core/foundation/base/errors.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace klang::acoustics {
namespace {

// On a sphere each, so that the largest |p| of a mode there is its scale.
Eigen::Matrix3Xd listeners(int n, double radius_m, std::uint64_t seed) {
  RandomStream random(seed, 0);
  Eigen::Matrix3Xd x(3, n);
  for (int i = 0; i < n; ++i) {
    Eigen::Vector3d s(random.normal(), random.normal(), random.normal());
    if (i == 0) s = {0.0, 0.0, 1.0};
    if (i == 1) s = {0.0, 0.0, -1.0};
    x.col(i) = Eigen::Vector3d(0.01, -0.02, 0.03) + radius_m * s.normalized();
  }
  return x;
}

struct Error {
  double of_largest = 0.0;  // |error| over the largest |p| of the mode at this distance, worst of all
  double of_itself = 0.0;   // |error| / |p|, worst of all: silent directions count
};

Error largest_error(const TransferModel& model, Precision precision, const Eigen::Matrix3Xd& x) {
  Eigen::MatrixXcd expected, found;
  TransferEvaluator(model).evaluate(x, expected);
  OpenClTransfer device(model, "", precision);
  device.evaluate(x, found);
  Error worst;
  EXPECT_EQ(found.rows(), expected.rows());
  EXPECT_TRUE(found.allFinite());
  for (Eigen::Index i = 0; i < found.rows(); ++i) {
    const Eigen::VectorXd error = (found.row(i) - expected.row(i)).cwiseAbs().transpose();
    worst.of_largest = std::max(worst.of_largest, error.maxCoeff() / expected.row(i).cwiseAbs().maxCoeff());
    worst.of_itself = std::max(worst.of_itself, error.cwiseQuotient(expected.row(i).cwiseAbs().transpose()).maxCoeff());
  }
  return worst;
}

class OpenCl : public testing::TestWithParam<bool> {
 protected:
  TransferModel model =
      random_transfer({4, 4, 7, 60, 5, 33, 12, 0, 1, 58, 20, 21, 22, 23, 24, 25, 26, 40}, 61, GetParam());
};
INSTANTIATE_TEST_SUITE_P(Centres, OpenCl, testing::Values(true, false));

TEST_P(OpenCl, DoublePrecisionIsTheProcessorsTo1e12) {
  for (const double radius : {0.3, 1.0, 20.0}) {
    EXPECT_LE(largest_error(model, Precision::kDouble, listeners(50, radius, 62)).of_largest, 1e-12) << radius;
  }
}

TEST_P(OpenCl, SinglePrecisionIsTheProcessorsTo1e5) {
  for (const double radius : {0.3, 1.0, 20.0}) {
    const Error error = largest_error(model, Precision::kSingle, listeners(50, radius, 63));
    EXPECT_LE(error.of_largest, 1e-5) << radius;
    EXPECT_LE(error.of_itself, 1e-4) << radius;
  }
}

TEST(OpenClTransfer, ManyListenersInSeveralTilesAgree) {
  const TransferModel model = random_transfer({4, 9}, 64);
  EXPECT_LE(largest_error(model, Precision::kDouble, listeners(4100, 1.0, 65)).of_largest, 1e-12);
}

TEST(OpenClTransfer, EightThreadsOnOneObjectAndOnTheirOwnAgree) {
  const TransferModel model = random_transfer({4, 9, 20}, 66);
  const Eigen::Matrix3Xd x = listeners(7, 1.0, 67);
  Eigen::MatrixXcd expected;
  OpenClTransfer shared(model, "", Precision::kDouble);
  shared.evaluate(x, expected);
  std::vector<Eigen::MatrixXcd> found(8);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < found.size(); ++t) {
    threads.emplace_back([&, t] {
      if (t % 2 == 0) {
        for (int i = 0; i < 10; ++i) shared.evaluate(x, found[t]);
      } else {
        OpenClTransfer(model, "", Precision::kDouble).evaluate(x, found[t]);
      }
    });
  }
  for (auto& thread : threads) thread.join();
  for (const auto& p : found) EXPECT_EQ((p - expected).cwiseAbs().maxCoeff(), 0.0);
}

TEST(OpenClTransfer, UnknownDeviceIsBadInputThatNamesTheKnown) {
  const TransferModel model = random_transfer({4}, 68);
  try {
    OpenClTransfer device(model, "no such device", Precision::kDouble);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(opencl::devices()[0].name), std::string::npos) << error.what();
  }
  EXPECT_THROW(OpenClTransfer(model, "4711", Precision::kDouble), InputError);
}

TEST(AnyTransferEvaluator, OnTheProcessorUnlessAsked) {
  const TransferModel model = random_transfer({4}, 69);
  AnyTransferEvaluator plain(model, {});
  EXPECT_EQ(plain.device_name(), "processor");
  EXPECT_EQ(plain.message(), "");
  AnyTransferEvaluator device(model, {.used = true});
  EXPECT_EQ(device.device_name(), opencl::devices()[opencl::chosen_device(opencl::devices(), "")].name);
}

}  // namespace
}  // namespace klang::acoustics
