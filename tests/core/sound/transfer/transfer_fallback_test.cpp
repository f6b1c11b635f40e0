// A process of its own: the OpenCL loader reads its list of drivers once.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/sound/transfer/transfer_opencl.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace klang::acoustics {
namespace {

TEST(AnyTransferEvaluator, FallsBackToTheProcessorWithOneLineWhereNoDeviceIsInstalled) {
  ASSERT_EQ(setenv("OCL_ICD_VENDORS", testing::TempDir().c_str(), 1), 0);  // a folder without drivers
  ASSERT_TRUE(opencl::devices().empty());
  const TransferModel model = random_transfer({4, 9}, 71);
  AnyTransferEvaluator evaluator(model, {.used = true});
  EXPECT_EQ(evaluator.device_name(), "processor");
  EXPECT_NE(evaluator.message(), "");
  EXPECT_EQ(evaluator.message().find('\n'), std::string::npos);
  Eigen::MatrixXcd expected, found;
  TransferEvaluator(model).evaluate(Eigen::Vector3d(1, 2, 3), expected);
  evaluator.evaluate(Eigen::Vector3d(1, 2, 3), found);
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace klang::acoustics
