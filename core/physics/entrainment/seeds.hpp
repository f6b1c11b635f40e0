#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/liquid/frames.hpp"

namespace klang::entrainment {

enum class SeedCriterion {
  kSlope,    ///< the slope of phi alone, as the paper: bodies of liquid that merge trigger it at any speed (erratum 77)
  kVelocity  ///< and the liquid moves inwards against the surface near it with at least half the threshold
};
constexpr auto words_of(SeedCriterion) {
  return std::array{Word{SeedCriterion::kSlope, "slope"}, Word{SeedCriterion::kVelocity, "velocity"}};
}

/// Least-squares slope of values over times (uneven ones too); 0 for fewer than two times.
/// A jump by J at the share a of a window T gives 6 a (1 - a) J / T.
double regression_slope(std::span<const double> times_s, std::span<const double> values);

/// Strength of a seed at the share tau of its life: 1 - 4 tau^3, from the half on 4 (1 - tau)^3; its mean is 1/2. Once differentiable (no
/// spline of class C2, as printed).
double seed_strength(double tau);

struct SeedOptions {
  double window_s = 0.008, threshold_m_s = -1.5, life_s = 0.02;
  SeedCriterion criterion = SeedCriterion::kSlope;
};

/// A point of the liquid near its surface, carried along.
struct Marker {
  std::uint64_t id = 0;
  Eigen::Vector3d position_m, velocity_m_s;
  double left_layer_s = 0.0;        ///< when it was last in the layer
  double seed_until_s = -1e300;     ///< it counts as a seed until then, and may become one again
  std::vector<double> time_s, phi;  ///< within the window
};

/// Markers in the layer -2 h < phi < 0 below the free surface, 16 per h^2 of it (as 8 particles per voxel make), moved with the
/// liquid's velocity in steps of at most a quarter of the window. They live on for one window after they have left the layer downwards
/// (otherwise hardly any could fall fast for a whole window: erratum 76) and end when they leave the liquid.
/// Becomes a seed: a marker with a whole window behind it over which phi fell with a slope below the threshold.
class SeedFinder {
 public:
  SeedFinder(const liquid::LiquidFrames& frames, const SeedOptions& options, std::uint64_t seed);
  /// From this frame to the next; the new seeds in the order of their markers.
  std::vector<liquid::SeedEvent> advance(std::size_t frame);
  std::size_t n_markers() const { return markers_.size(); }

 private:
  void fill_layer(const liquid::LiquidFrames& frames, std::size_t frame);
  void move(const liquid::LiquidFrames& frames, Marker& marker, double from_s, double to_s) const;
  bool falls(const liquid::LiquidFrames& frames, const Marker& marker, double time_s) const;
  std::uint64_t cell_of(const Eigen::Vector3d& x_m) const;

  const liquid::LiquidFrames& frames_;
  const SeedOptions options_;
  const std::uint64_t seed_;
  const double cell_m_;
  std::uint64_t next_id_ = 0;
  std::vector<Marker> markers_;
};

}  // namespace klang::entrainment
