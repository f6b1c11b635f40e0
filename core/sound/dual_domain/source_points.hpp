#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::bubble {

/// Where the multipole sources of one bubble stand, chosen when it is born (HF section 5.4).
struct SourcePoints {
  std::vector<Eigen::Vector3d> fluid_m;  ///< of pass 1, inside the liquid
  std::vector<Eigen::Vector3d> air_m;    ///< of pass 2, inside what the air goes around
  std::vector<Eigen::Vector3d>
      solid_m;  ///< of pass 1 too, inside wet solids: what a solid throws back is singular within it
  std::uint64_t seed = 0;
  std::uint32_t n_replaced = 0;  ///< points that left and were drawn again
};

/// Uniform in the volume, but not closer to a sample of the boundary than twice the spacing of the samples (halved as often
/// as thin liquid needs it). Where there are wet solids, points within them too: their share of the liquid's boundary, 6 or more.
/// The same seed gives the same points.
/// @throws InputError where no point inside is found (liquid thinner than the mesh can tell)
SourcePoints random_source_points(const LiquidBoundary& boundary, int n_fluid, int n_air, std::uint64_t seed);

/// Carries the points with the liquid over time_s (midpoint rule; no velocity: they stay), then draws those again that are
/// no longer inside the new boundary. All others keep their place: the basis changes as smoothly as the liquid.
void advect(SourcePoints& points, const LiquidBoundary& boundary, double time_s,
            const std::function<Eigen::Vector3d(const Eigen::Vector3d& x_m)>& velocity_m_s = {});

}  // namespace klang::bubble
