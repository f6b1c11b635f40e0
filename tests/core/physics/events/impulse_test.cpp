#include "core/physics/events/impulse.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace klang::events {
namespace {

TEST(Impulse, GaussianPulseIsItselfToTheBit) {
  Impulse impulse;
  impulse.time_s = 0.1234567890123;
  impulse.duration_s = 5.4321e-5;
  impulse.shape = PulseShape::kGaussian;
  EXPECT_EQ(gaussian_pulse(impulse).centre_s, impulse.time_s);
  EXPECT_EQ(gaussian_pulse(impulse).standard_deviation_s, impulse.duration_s);
}

// d'' = -d^(3/2) from d = 0, d' = 1 until d = 0 again, by the midpoint rule.
TEST(Impulse, HertzPulseHasTheCentreAndVarianceOfAnElasticCollision) {
  constexpr double kStep = 2e-5;
  double d = 0.0, v = 1.0, t = 0.0, area = 0.0, first = 0.0, second = 0.0;
  while (d >= 0.0) {
    const double middle_d = d + 0.5 * kStep * v, force = std::pow(std::max(middle_d, 0.0), 1.5);
    const double middle_t = t + 0.5 * kStep, middle_v = v - 0.5 * kStep * std::pow(std::max(d, 0.0), 1.5);
    area += kStep * force;
    first += kStep * force * middle_t;
    second += kStep * force * middle_t * middle_t;
    d += kStep * middle_v;
    v -= kStep * force;
    t += kStep;
  }
  EXPECT_LE(std::abs(area - 2.0), 1e-4);  // momentum from 1 to -1
  const double centre = first / area, deviation = std::sqrt(second / area - centre * centre);
  Impulse impulse;
  impulse.time_s = 3.0;
  impulse.duration_s = t;
  const GaussianPulse pulse = gaussian_pulse(impulse);
  EXPECT_LE(std::abs(pulse.centre_s - (3.0 + centre)), 1e-4 * t);
  EXPECT_LE(std::abs(pulse.standard_deviation_s - deviation), 1e-4 * deviation);
}

TEST(Impulse, WithoutDurationIsADiracPulseAtItsTime) {
  Impulse impulse;
  impulse.time_s = 0.5;
  EXPECT_EQ(gaussian_pulse(impulse).centre_s, 0.5);
  EXPECT_EQ(gaussian_pulse(impulse).standard_deviation_s, 0.0);
}

}  // namespace
}  // namespace klang::events
