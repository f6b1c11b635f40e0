#include "core/bubble/dual_domain/source_points.hpp"

#include <cmath>

#include "core/base/errors.hpp"
#include "core/base/parallel.hpp"
#include "core/base/random.hpp"

namespace klang::bubble {
namespace {

using Eigen::Vector3d;

double sample_distance(const LiquidBoundary& boundary, const Vector3d& x, bool of_air) {
  double nearest = HUGE_VAL;
  for (const BoundarySample& s : boundary.samples())
    if (s.region != (of_air ? BoundaryRegion::kWetSolid : BoundaryRegion::kDrySolid))
      nearest = std::min(nearest, (s.point_m - x).squaredNorm());
  return std::sqrt(nearest);
}

/// count points from the random stream, tested in parallel, taken in order.
std::vector<Vector3d> draw(const LiquidBoundary& boundary, std::size_t count, bool of_air, RandomStream random) {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (const BoundarySample& s : boundary.samples()) {
    if (s.region == (of_air ? BoundaryRegion::kWetSolid : BoundaryRegion::kDrySolid)) continue;
    low = low.cwiseMin(s.point_m);
    high = high.cwiseMax(s.point_m);
  }
  double depth = 2.0 * boundary.spacing_m();
  std::vector<Vector3d> points;
  for (int round = 0; points.size() < count; ++round) {
    if (round == 60) throw InputError(boundary.name(), "no room for source points inside the liquid", std::to_string(points.size()) + " found", std::to_string(count));
    std::vector<Vector3d> candidates(2 * count + 16);
    for (Vector3d& x : candidates)
      for (int a = 0; a < 3; ++a) x[a] = random.uniform(low[a], high[a]);
    std::vector<char> good(candidates.size(), 0);
    parallel_for(candidates.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        good[i] = sample_distance(boundary, candidates[i], of_air) >= depth &&
                  (of_air ? boundary.inside_air_boundary(candidates[i]) : boundary.inside_liquid(candidates[i]));
    });
    std::size_t n_good = 0;
    for (std::size_t i = 0; i < candidates.size() && points.size() < count; ++i)
      if (good[i]) {
        points.push_back(candidates[i]);
        ++n_good;
      }
    if (n_good * 50 < candidates.size()) depth *= 0.5;
  }
  return points;
}

}  // namespace

SourcePoints random_source_points(const LiquidBoundary& boundary, int n_fluid, int n_air, std::uint64_t seed) {
  checked("dual domain", "fluid sources", n_fluid, 0, 100000);
  checked("dual domain", "air sources", n_air, 0, 100000);
  SourcePoints points;
  points.seed = seed;
  if (n_fluid > 0) points.fluid_m = draw(boundary, static_cast<std::size_t>(n_fluid), false, RandomStream(seed, 0));
  if (n_air > 0) points.air_m = draw(boundary, static_cast<std::size_t>(n_air), true, RandomStream(seed, 1));
  return points;
}

void advect(SourcePoints& points, const LiquidBoundary& boundary, double time_s,
            const std::function<Vector3d(const Vector3d& x_m)>& velocity_m_s) {
  for (const bool of_air : {false, true}) {
    auto& list = of_air ? points.air_m : points.fluid_m;
    std::vector<char> lost(list.size(), 0);
    parallel_for(list.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Vector3d& x = list[i];
        if (velocity_m_s) x += time_s * velocity_m_s(x + 0.5 * time_s * velocity_m_s(x));
        // A source closer than half the spacing is seen by no more than one sample.
        lost[i] = !(sample_distance(boundary, x, of_air) >= 0.5 * boundary.spacing_m()) ||
                  !(of_air ? boundary.inside_air_boundary(x) : boundary.inside_liquid(x));
      }
    });
    for (std::size_t i = 0; i < list.size(); ++i)
      if (lost[i]) list[i] = draw(boundary, 1, of_air, RandomStream(points.seed, 2 + points.n_replaced++)).front();
  }
}

}  // namespace klang::bubble
