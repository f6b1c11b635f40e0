#include "datasets-synthetic/debris.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "datasets-synthetic/detail/convex_cell.hpp"

namespace klang::datasets {
namespace {

constexpr int kDraws = 64;

std::vector<Eigen::Vector3d> draw_seeds(const DebrisOptions& o, std::uint64_t draw) {
  RandomStream random(o.seed, draw);
  const double spacing = std::sqrt(o.slab_m[0] * o.slab_m[1] / o.n_shards);
  const double rise = 0.5 * spacing * std::tan(o.largest_tilt_deg * kPi / 180.0);
  double gap = 0.4 * spacing;
  std::vector<Eigen::Vector3d> seeds;
  for (int tries = 0; static_cast<int>(seeds.size()) < o.n_shards; ++tries) {
    if (tries == 2000) {  // a slab so narrow that they do not fit
      tries = 0;
      gap *= 0.8;
    }
    const Eigen::Vector3d at(o.slab_m[0] * (random.uniform() - 0.5), o.slab_m[1] * (random.uniform() - 0.5),
                             rise * random.uniform(-1.0, 1.0));
    const bool fits = std::all_of(seeds.begin(), seeds.end(),
                                  [&](const Eigen::Vector3d& s) { return (s - at).head<2>().norm() >= gap; });
    if (fits) seeds.push_back(at);
  }
  return seeds;
}

DebrisPiece piece_of(const std::string& name, const detail::ConvexCell& cell) {
  return {name, detail::surface_of(cell), cell.volume_m3()};
}

}  // namespace

void DebrisOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  const Range lengths = between(1e-4, 10.0);
  for (const double length : box_m)
    if (!box_m.isZero(0.0) && !lengths.holds(length)) violations.push_back(out_of_range("box_m", length, lengths));
  if (plate_thicknesses_m.size() > 50)
    violations.push_back({"plate_thicknesses_m", "", std::to_string(plate_thicknesses_m.size()), "at most 50"});
  if (!(slab_m[2] <= slab_m.head<2>().minCoeff()))
    violations.push_back({"slab_m", "", to_text(slab_m[2]), "the thickness last and smallest"});
  throw_violations("debris", std::move(violations));
}

std::vector<DebrisPiece> slab_shards(const DebrisOptions& options) {
  options.validate();
  if (options.n_shards == 0) return {};
  std::vector<detail::ConvexCell> best;
  double longest = -1.0;
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    std::vector<detail::ConvexCell> cells = detail::voronoi_cells(options.slab_m, draw_seeds(options, draw));
    double shortest = options.slab_m.norm();
    for (const detail::ConvexCell& cell : cells)
      shortest = std::min(shortest, cell.empty() ? 0.0 : cell.shortest_edge_m());
    if (shortest > longest) {
      longest = shortest;
      best = std::move(cells);
    }
  }
  if (!(longest > 0.0))
    throw InputError("debris", "a shard vanished", std::to_string(options.n_shards) + " shards",
                     "fewer shards or less tilt");
  std::vector<DebrisPiece> pieces;
  for (std::size_t i = 0; i < best.size(); ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "shard_%02zu", i + 1);
    pieces.push_back(piece_of(name, best[i]));
  }
  return pieces;
}

std::vector<DebrisPiece> debris(const DebrisOptions& options) {
  options.validate();
  std::vector<DebrisPiece> pieces;
  if (!options.box_m.isZero(0.0)) pieces.push_back(piece_of("box", detail::box_cell(options.box_m)));
  for (std::size_t i = 0; i < options.plate_thicknesses_m.size(); ++i)
    pieces.push_back(
        piece_of("plate_" + std::to_string(i + 1),
                 detail::box_cell({options.plate_length_m, options.plate_width_m, options.plate_thicknesses_m[i]})));
  for (DebrisPiece& shard : slab_shards(options)) pieces.push_back(std::move(shard));
  return pieces;
}

}  // namespace klang::datasets
