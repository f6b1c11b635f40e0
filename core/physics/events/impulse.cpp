#include "core/physics/events/impulse.hpp"

namespace klang::events {
namespace {

constexpr double kHertzDeviation = 0.194075;  // of contact times; the tests integrate the collision

}  // namespace

GaussianPulse gaussian_pulse(const Impulse& impulse) {
  if (impulse.shape == PulseShape::kGaussian) return {impulse.time_s, impulse.duration_s};
  return {impulse.time_s + 0.5 * impulse.duration_s, kHertzDeviation * impulse.duration_s};
}

}  // namespace klang::events
