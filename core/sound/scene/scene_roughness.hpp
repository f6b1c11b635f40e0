#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "core/physics/events/event_log.hpp"
#include "core/sound/scene/scene.hpp"

/// What rough surfaces add to the sound of contacts that slide and roll.
namespace klang::scene {

/// A random field over a body's frame: mean 0, variance 1, correlation exp(-r^2 / (2 L^2)) between places r apart. A sum of plane
/// waves sqrt(2/N) cos(q . x + phase), q normally distributed with standard deviation 1/L along each axis.
class RoughField {
 public:
  RoughField(double length_m, std::uint64_t seed);
  double at(const Eigen::Vector3d& place_m) const { return mean(place_m, place_m); }
  /// Its mean over a straight way. Along a way of length v t the field of a place that moves at speed v varies up to about v / L
  /// rad/s; what is shorter than the way is averaged out.
  double mean(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const;

 private:
  static constexpr int kWaves = 64;
  Eigen::Matrix<double, kWaves, 3> wave_;
  Eigen::Matrix<double, kWaves, 1> phase_;
};

/// The log with lasting contacts as rough surfaces make them: in each step the force is
///     F (1 + c_a mean xi_a + c_b mean xi_b), not below 0,
/// on both bodies, with c the materials' roughness and xi the field of each body (of the floor's in the world) along the way that the place
/// of the contact takes over it in that step. A contact whose place does not move keeps its force times a constant, so that a body
/// at rest stays silent. It is heard up to half the rate of the steps; motion and energies are not changed. The fields depend on the
/// body's row alone. A log of smooth materials comes back as it is.
events::EventLog with_roughness(const Scene& scene, const events::EventLog& log);

}  // namespace klang::scene
