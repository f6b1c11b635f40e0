#include "core/physics/events/impulse.hpp"

#include <cmath>

namespace klang::events {
namespace {

constexpr double kHertzDeviation = 0.194075;  // of contact times; the tests integrate the collision

}  // namespace

GaussianPulse gaussian_pulse(const Impulse& impulse) {
  if (impulse.shape == PulseShape::kGaussian) return {impulse.time_s, impulse.duration_s};
  const double deviation = impulse.shape == PulseShape::kHertz ? kHertzDeviation : 1.0 / std::sqrt(12.0);
  return {impulse.time_s + 0.5 * impulse.duration_s, deviation * impulse.duration_s};
}

}  // namespace klang::events
