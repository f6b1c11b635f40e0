#include <gtest/gtest.h>

#include "core/sound/dual_domain/reciprocal.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"

namespace klang::bubble {
namespace {

class ReciprocalOnDevice : public testing::Test {
 protected:
  LiquidBoundary boundary{test::tank({0.30, 0.22, 0.15}, 0.03)};
  SourcePoints points = random_source_points(boundary, 6, 11, 1);
  BubblesAndEars between{{{{0.13, 0.10, -0.05}, 0.0016}}, {{0.4, 0.3, 0.8}, {-0.4, 0.3, 0.8}}};
  ReciprocalOptions options{.pass = {}, .air_vertices = 200, .estimate_air = true, .device = {}};
};

TEST_F(ReciprocalOnDevice, PressureAtTheEarsIsTheProcessors) {
  const auto expected = reciprocal_transfer(boundary, 900.0, points, between, options)[0];
  options.device.used = true;
  const auto found = reciprocal_transfer(boundary, 900.0, points, between, options)[0];
  for (std::size_t ear = 0; ear < 2; ++ear) {
    EXPECT_EQ(found[ear].device_message, "");
    EXPECT_LE(std::abs(found[ear].pressure - expected[ear].pressure), 1e-6 * std::abs(expected[ear].pressure));
    EXPECT_NEAR(*found[ear].error_air, *expected[ear].error_air, 1e-6);
  }
}

TEST_F(ReciprocalOnDevice, WithoutMemoryTheProcessorDoesItAndOneLineSaysSo) {
  options.estimate_air = false;
  const auto expected = reciprocal_transfer(boundary, 900.0, points, between, options)[0];
  options.device = {.used = true, .memory_bytes = 1000};
  const auto found = reciprocal_transfer(boundary, 900.0, points, between, options)[0];
  EXPECT_NE(found[0].device_message.find("needs"), std::string::npos) << found[0].device_message;
  EXPECT_EQ(found[0].pressure, expected[0].pressure);
}

}  // namespace
}  // namespace klang::bubble
