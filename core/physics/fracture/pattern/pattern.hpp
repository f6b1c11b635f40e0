#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/physics/fracture/pattern/fragments.hpp"
#include "core/physics/fracture/pattern/geodesic.hpp"
#include "core/physics/fracture/pattern/power_cells.hpp"

namespace klang::fracture {

/// A plane in which the body is weaker, as a tile that was scored before.
struct ScoredPlane {
  HalfSpace plane;
  double strength_factor = 0.1;   ///< of the strength of elements that it runs through
  double toughness_factor = 0.1;  ///< of the energy per area of cracks in it
};

struct PatternRules {
  bool geodesic = false;  ///< SB's regions; else power cells
  double alpha = 0.15;
  double toughness_j_m2 = 0.0;    ///< G_c: energy per crack area (one side)
  double spendable_j = 0.0;       ///< eta E_S
  double smallest_piece_m = 0.0;  ///< seeds keep this distance; parts below an eighth of its cube stay with a neighbour
  int most_cells = 400;
  bool merge_enclosed = true;
  std::optional<ScoredPlane> score;  ///< breaks first and divides the body whatever the cells
  bool score_alone = false;          ///< nothing but the score is loaded above its strength
};

/// Why there are not more cells.
enum class PatternLimit {
  kNotRun,
  kEnergy,    ///< one more would cost more than there is
  kCells,     ///< as many as are allowed
  kDistance,  ///< no place for another seed
  kScore      ///< nothing but the score breaks
};
constexpr auto words_of(PatternLimit) {
  return std::array{Word{PatternLimit::kNotRun, "not_run"}, Word{PatternLimit::kEnergy, "energy"},
                    Word{PatternLimit::kCells, "cells"}, Word{PatternLimit::kDistance, "distance"},
                    Word{PatternLimit::kScore, "score"}};
}

/// How a body breaks. Not at all: n_cells 0 and no fragments.
struct FracturePattern {
  Fragments fragments;
  std::vector<Seed> seeds;  ///< of the cells
  int n_cells = 0;          ///< 1: the score alone
  std::vector<std::vector<HalfSpace>>
      half_spaces;                 ///< by region: its cell is their intersection; empty lists of geodesic regions
  double fracture_energy_j = 0.0;  ///< E_F = G_c A_F <= spendable_j, cracks in the score by its factor
  std::optional<double> next_fracture_energy_j;  ///< with one more cell, where that is too much
  PatternLimit limit = PatternLimit::kNotRun;
};

/// Patterns with 1, 2, ... cells of one body and one sequence of seeds.
class PatternMaker {
 public:
  /// @param mesh  straight; energy_density [J/m^3] by element
  PatternMaker(const mesh::TetMesh& mesh, const Eigen::VectorXd& energy_density, PatternRules rules,
               std::uint64_t seed);

  /// With n cells, or as many as find place; without limit and next energy.
  FracturePattern with_cells(int n);
  int n_places(int wanted);  ///< how many of the wanted seeds there are

  /// The pattern of n cells whose E_F is affordable and that of n + 1 is not (SB 3.2: seeds are added while E_F <= eta E_S). E_F
  /// grows with n but for what merging takes back; n is found by doubling and then between the last two, so it is SB's n wherever E_F grows, and
  /// always one that obeys both conditions. Nothing where two cells (with a score: the score alone) cost too much.
  FracturePattern affordable();

 private:
  double cost_j(const Fragments& fragments) const;

  const mesh::TetMesh& mesh_;
  PatternRules rules_;
  SeedSampler sampler_;
  GeodesicRegions paths_;
  double size_m_ = 0.0;
  RegionCut base_;  // cut by the score only
};

}  // namespace klang::fracture
