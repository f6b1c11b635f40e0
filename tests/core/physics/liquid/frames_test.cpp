#include "core/physics/liquid/frames.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace klang::liquid {
namespace {

/// Two frames of a pool whose level rises.
class RisingPool : public LiquidFrames {
 public:
  std::span<const double> time_s() const override { return times_; }
  LiquidSurface boundary(std::size_t) const override { return {}; }
  double phi_m(std::size_t frame, const Eigen::Vector3d& x_m) const override {
    return x_m.z() - 0.1 * static_cast<double>(frame);
  }
  std::optional<Eigen::Vector3d> velocity_m_s(std::size_t frame, const Eigen::Vector3d& x_m) const override {
    if (x_m.z() > 1.0 && frame == 1) return std::nullopt;
    return Eigen::Vector3d(0.0, 0.0, 1.0 + static_cast<double>(frame));
  }
  double cell_m() const override { return 0.01; }

 private:
  std::vector<double> times_{0.5, 0.75};
};

TEST(LiquidFrames, AreLinearBetweenAndHeldOutside) {
  const RisingPool pool;
  const Eigen::Vector3d x(0.0, 0.0, 0.2);
  const double times[] = {0.0, 0.5, 0.6, 0.75, 2.0}, phi[] = {0.2, 0.2, 0.16, 0.1, 0.1},
               speed[] = {1.0, 1.0, 1.4, 2.0, 2.0};
  for (int i = 0; i < 5; ++i) {
    EXPECT_LE(std::abs(phi_m(pool, times[i], x) - phi[i]), 1e-15) << times[i];
    EXPECT_LE(std::abs(velocity_m_s(pool, times[i], x)->z() - speed[i]), 1e-14) << times[i];
  }
}

TEST(LiquidFrames, HaveNoVelocityWhereOneOfTheFramesHasNone) {
  const RisingPool pool;
  EXPECT_TRUE(velocity_m_s(pool, 0.5, {0.0, 0.0, 2.0}).has_value());
  EXPECT_FALSE(velocity_m_s(pool, 0.6, {0.0, 0.0, 2.0}).has_value());
}

}  // namespace
}  // namespace klang::liquid
