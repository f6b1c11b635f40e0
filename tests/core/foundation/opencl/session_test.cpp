#include "core/foundation/opencl/session.hpp"

#include <gtest/gtest.h>

#include "core/foundation/base/errors.hpp"

namespace klang::opencl {
namespace {

constexpr const char* kSource = R"(
__kernel void scaled(const REAL factor, __global const REAL* x, __global REAL* y) {
  const int i = get_global_id(0);
  y[i] = factor * x[i];
}
)";

TEST(Devices, AutoIsAGpuWithDoublePrecisionAndElseTheProcessor) {
  const std::vector<Device> devices = {{"A", "Small GPU", "gpu", 8, 1, false, 1},
                                       {"B", "Vendor CPU", "cpu", 8, 1, true, 1},
                                       {"Portable Computing Language", "pthread-cpu", "cpu", 8, 1, true, 1},
                                       {"C", "Quick GPU", "gpu", 99, 1, true, 1}};
  for (const char* choice : {"", "auto", "quick", "3"}) EXPECT_EQ(chosen_device(devices, choice), 3u) << choice;
  EXPECT_EQ(chosen_device({devices.begin(), devices.begin() + 3}, "auto"), 2u);
  EXPECT_EQ(chosen_device({devices[0], devices[1]}, "auto"), 1u);
  EXPECT_EQ(chosen_device({devices[0]}, "auto"), 0u);
  EXPECT_EQ(chosen_device(devices, "cpu"), 2u);
  EXPECT_EQ(chosen_device({devices[0], devices[1]}, "cpu"), 1u);
  EXPECT_EQ(chosen_device(devices, "0"), 0u);
  EXPECT_THROW(chosen_device(devices, "4"), InputError);
  EXPECT_THROW(chosen_device({devices[0]}, "cpu"), InputError);
}

template <typename Real>
std::vector<Real> scaled(Session& session, Real factor, const std::vector<Real>& x) {
  const Buffer from = session.upload(x), to = session.buffer(x.size() * sizeof(Real));
  session.run("scaled", {x.size()}, nullptr, factor, from, to);
  std::vector<Real> y(x.size());
  session.read(to, y.data(), y.size() * sizeof(Real));
  return y;
}

TEST(Session, ComputesInThePrecisionAsked) {
  Session twice(kSource, "", Precision::kDouble), once(kSource, "", Precision::kSingle);
  EXPECT_EQ(scaled<double>(twice, 1.0 / 3.0, {1.0, 3.0, 1e-300}), (std::vector<double>{1.0 / 3.0, 1.0, 1e-300 / 3.0}));
  EXPECT_EQ(scaled<float>(once, 0.1f, {1.0f, 2.0f}), (std::vector<float>{0.1f, 0.2f}));
  EXPECT_EQ(twice.precision(), Precision::kDouble);
}

TEST(Session, BlocksOfAMatrixAreReadRowByRow) {
  Session session(kSource, "", Precision::kDouble);
  std::vector<double> matrix(35);
  for (std::size_t i = 0; i < matrix.size(); ++i) matrix[i] = static_cast<double>(i);
  const Buffer held = session.upload(matrix);
  std::vector<double> block(6);
  session.read_block(held, (2 * 7 + 3) * sizeof(double), 7 * sizeof(double), 2 * sizeof(double), 3, block.data());
  EXPECT_EQ(block, (std::vector<double>{17, 18, 24, 25, 31, 32}));
}

TEST(Session, WhatTheDeviceHasNoMemoryForIsRefusedInOneLineWithBothNumbers) {
  const Session session(kSource, "", Precision::kDouble);
  EXPECT_NO_THROW(session.check_memory(1000, 1000, "the work"));
  try {
    session.check_memory(std::size_t{1} << 60, 1000, "the work");
    FAIL();
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("the work needs 1.15e+09 GB, " + session.device().name + " has "), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
  }
  EXPECT_THROW(session.check_memory(2000, 2000, "the work", 1999), Error);
  EXPECT_THROW(session.check_memory(session.device().memory_bytes, session.device().largest_buffer_bytes + 1, "it"),
               Error);
}

TEST(Session, AKernelThatDoesNotCompileSaysSoInOneLine) {
  try {
    Session("__kernel void broken(", "", Precision::kDouble);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("do not compile"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(Session, UnknownDeviceIsBadInputThatNamesTheKnown) {
  try {
    Session(kSource, "no such device", Precision::kDouble);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find(devices()[0].name), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace klang::opencl
