#include "core/sound/dual_domain/source_points.hpp"

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"

namespace klang::bubble {
namespace {

using Eigen::Vector3d;

enum class Domain { kLiquid, kAir, kSolid };  // of the sources: the air's stand in liquid and solids

bool bounds(const BoundarySample& s, Domain domain) {
  switch (domain) {
    case Domain::kLiquid:
      return s.region != BoundaryRegion::kDrySolid;
    case Domain::kAir:
      return s.region != BoundaryRegion::kWetSolid;
    case Domain::kSolid:
      return s.region == BoundaryRegion::kWetSolid || s.region == BoundaryRegion::kDrySolid;
  }
  return false;
}

bool inside(const LiquidBoundary& boundary, const Vector3d& x, Domain domain) {
  switch (domain) {
    case Domain::kLiquid:
      return boundary.inside_liquid(x);
    case Domain::kAir:
      return boundary.inside_air_boundary(x);
    case Domain::kSolid:
      return boundary.inside_air_boundary(x) && !boundary.inside_liquid(x);
  }
  return false;
}

double sample_distance(const LiquidBoundary& boundary, const Vector3d& x, Domain domain) {
  double nearest = HUGE_VAL;
  for (const BoundarySample& s : boundary.samples())
    if (bounds(s, domain)) nearest = std::min(nearest, (s.point_m - x).squaredNorm());
  return std::sqrt(nearest);
}

/// count points from the random stream, tested in parallel, taken in order.
std::vector<Vector3d> draw(const LiquidBoundary& boundary, std::size_t count, Domain domain, RandomStream random) {
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (const BoundarySample& s : boundary.samples()) {
    if (!bounds(s, domain)) continue;
    low = low.cwiseMin(s.point_m);
    high = high.cwiseMax(s.point_m);
  }
  double depth = 2.0 * boundary.spacing_m();
  std::vector<Vector3d> points;
  for (int round = 0; points.size() < count; ++round) {
    if (round == 60)
      throw InputError(boundary.name(), "no room for source points inside", std::to_string(points.size()) + " found",
                       std::to_string(count));
    std::vector<Vector3d> candidates(2 * count + 16);
    for (Vector3d& x : candidates)
      for (int a = 0; a < 3; ++a) x[a] = random.uniform(low[a], high[a]);
    std::vector<char> good(candidates.size(), 0);
    parallel_for(candidates.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        good[i] = sample_distance(boundary, candidates[i], domain) >= depth && inside(boundary, candidates[i], domain);
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

constexpr std::uint64_t kSolidStream = std::uint64_t{1} << 40;  // apart from those of points drawn again

/// As many as the wet solids' share of the liquid's boundary, 6 or more; none without wet solids.
int solid_sources(const LiquidBoundary& boundary, int n_fluid) {
  double wet = 0.0, all = 0.0;
  for (const BoundarySample& s : boundary.samples()) {
    if (s.region != BoundaryRegion::kDrySolid) all += s.area_m2;
    if (s.region == BoundaryRegion::kWetSolid) wet += s.area_m2;
  }
  return wet > 0.0 && n_fluid > 0 ? std::max(6, static_cast<int>(std::ceil(n_fluid * wet / all))) : 0;
}

}  // namespace

SourcePoints random_source_points(const LiquidBoundary& boundary, int n_fluid, int n_air, std::uint64_t seed) {
  checked("dual domain", "fluid sources", n_fluid, 0, 100000);
  checked("dual domain", "air sources", n_air, 0, 100000);
  SourcePoints points;
  points.seed = seed;
  if (n_fluid > 0)
    points.fluid_m = draw(boundary, static_cast<std::size_t>(n_fluid), Domain::kLiquid, RandomStream(seed, 0));
  if (n_air > 0) points.air_m = draw(boundary, static_cast<std::size_t>(n_air), Domain::kAir, RandomStream(seed, 1));
  if (const int n_solid = solid_sources(boundary, n_fluid); n_solid > 0)
    points.solid_m =
        draw(boundary, static_cast<std::size_t>(n_solid), Domain::kSolid, RandomStream(seed, kSolidStream));
  return points;
}

void advect(SourcePoints& points, const LiquidBoundary& boundary, double time_s,
            const std::function<Vector3d(const Vector3d& x_m)>& velocity_m_s) {
  for (const Domain domain : {Domain::kLiquid, Domain::kAir, Domain::kSolid}) {
    auto& list = domain == Domain::kAir ? points.air_m : domain == Domain::kLiquid ? points.fluid_m : points.solid_m;
    std::vector<char> lost(list.size(), 0);
    parallel_for(list.size(), 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        Vector3d& x = list[i];
        if (velocity_m_s) x += time_s * velocity_m_s(x + 0.5 * time_s * velocity_m_s(x));
        // A source closer than half the spacing is seen by no more than one sample.
        lost[i] = !(sample_distance(boundary, x, domain) >= 0.5 * boundary.spacing_m()) || !inside(boundary, x, domain);
      }
    });
    for (std::size_t i = 0; i < list.size(); ++i)
      if (lost[i]) list[i] = draw(boundary, 1, domain, RandomStream(points.seed, 2 + points.n_replaced++)).front();
  }
}

}  // namespace klang::bubble
