#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/physics/fracture/impulse/fracture_impulse.hpp"
#include "core/physics/fracture/pattern/fragment_body.hpp"

namespace klang::fracture {

enum class PatternKind {
  kAuto,     ///< power cells for a body of one convex part (panes, slabs, tiles), geodesic else
  kPower,    ///< convex cells with plane cracks
  kGeodesic  ///< SB's regions
};
constexpr auto words_of(PatternKind) {
  return std::array{Word{PatternKind::kAuto, "auto"}, Word{PatternKind::kPower, "power"},
                    Word{PatternKind::kGeodesic, "geodesic"}};
}
enum class Literature { kMended, kPaper };
constexpr auto words_of(Literature) {
  return std::array{Word{Literature::kMended, "mended"}, Word{Literature::kPaper, "paper"}};
}

/// How bodies break, whatever they are made of.
struct FractureOptions {
  PatternKind pattern = PatternKind::kAuto;
  double eta = 0.8;
  double alpha = 0.15;
  double smallest_piece_m = 0.006;
  int most_pieces = 400;
  int generations = 1;
  bool merge_enclosed = true;
  bool impulses = true;
  double crack_friction = 0.4;
  double crack_speed_over_rayleigh = 0.5;
  Literature literature = Literature::kMended;

  void validate() const;  ///< OptionsError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"pattern",
           "cells: auto (power for a body of one convex part, else geodesic), power (plane cracks) or geodesic"},
          self.pattern);
    visit({"eta", "share of the strain energy that cracks may cost", Range{0.0, 1.0, true, false}}, self.eta);
    visit({"alpha", "how much smaller pieces are where more energy is: weight = density^alpha", between(0.0, 1.0)},
          self.alpha);
    visit({"smallest_piece_m", "least distance of cells; parts below an eighth of its cube stay with a neighbour",
           between(0.0, 10.0)},
          self.smallest_piece_m);
    visit({"most_pieces", "cells of one breakage", between(2, 2000)}, self.most_pieces);
    visit({"generations",
           "how often things break: 1: pieces do not break again; 2: pieces of a body do, their own do not",
           between(1, 10)},
          self.generations);
    visit({"merge_enclosed", "pieces that lie wholly inside another stay with it"}, self.merge_enclosed);
    visit({"impulses", "cracks that open push the pieces apart; without, that energy is heat"}, self.impulses);
    visit({"crack_friction", "of closed cracks", between(0.0, 10.0)}, self.crack_friction);
    visit({"crack_speed_over_rayleigh", "speed of cracks over that of Rayleigh's waves", between(0.01, 1.0)},
          self.crack_speed_over_rayleigh);
    visit({"literature", "mended, or paper: the fracture impulses as SB prints them"}, self.literature);
  }
};

/// A body as it is when it breaks, in its own frame.
struct ParentBody {
  mesh::TetMesh mesh;                    ///< that of the stress; of quadratic elements only the corners are used
  std::vector<rigid::ConvexPart> parts;  ///< empty: each piece collides as its own hull
  double density_kg_m3 = 0.0;
  double toughness_j_m2 = 0.0;  ///< G_c
  double tensile_strength_pa = 0.0;
  double youngs_modulus_pa = 0.0;  ///< with Poisson's ratio: speed of cracks
  double poissons_ratio = 0.0;
  std::optional<ScoredPlane> score;
  std::string name;

  void validate() const;  ///< InputError naming the body
};

/// What the stress analysis says of the load at its peak.
struct StressInput {
  Eigen::VectorXd energy_density_j_m3;                 ///< by element
  Eigen::Matrix<double, 6, Eigen::Dynamic> stress_pa;  ///< Cauchy, by element: xx, yy, zz, xy, yz, zx; tension positive
  /// By element, what is held against the strength (quasistatic/breaking_stress.hpp); empty: the largest principal value of stress_pa.
  Eigen::VectorXd breaking_pa;
};

enum class FractureStatus {
  kNotRun,
  kBelowStrength,    ///< no principal stress reaches the strength (Rankine)
  kTooLittleEnergy,  ///< two cells cost more than eta times the energy there is
  kBroken
};
constexpr auto words_of(FractureStatus) {
  return std::array{Word{FractureStatus::kNotRun, "not_run"}, Word{FractureStatus::kBelowStrength, "below_strength"},
                    Word{FractureStatus::kTooLittleEnergy, "too_little_energy"},
                    Word{FractureStatus::kBroken, "broken"}};
}

/// strain_j = fracture_j + kinetic_j + vibration_j + residual_j.
struct FractureEnergies {
  double strain_j = 0.0;     ///< E_S' = min(E_S, available): what the breakage may spend
  double fracture_j = 0.0;   ///< E_F = G_c A_F
  double kinetic_j = 0.0;    ///< of the pieces' rigid motion, gained
  double vibration_j = 0.0;  ///< the rest: vibration of the pieces and heat
  double residual_j = 0.0;   ///< strain that loaded pieces keep

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"strain_j", "strain energy that the breakage spends"}, self.strain_j);
    visit({"fracture_j", "of the cracks' areas"}, self.fracture_j);
    visit({"kinetic_j", "gained by the pieces' motion"}, self.kinetic_j);
    visit({"vibration_j", "the rest: vibration and heat"}, self.vibration_j);
    visit({"residual_j", "strain that loaded pieces keep"}, self.residual_j);
  }
};

/// Everything in the parent's frame, its axes too; velocities are what pieces gain over the rigid motion that they had as parts of the
/// parent.
struct FractureResult {
  FractureStatus status = FractureStatus::kNotRun;
  double largest_stress_pa = 0.0;  ///< principal, tension, of the load as it could be spent
  int largest_element = -1;
  double load_factor = 1.0;  ///< sqrt(E_S'/E_S): stress and forces as given are too large by its inverse
  std::vector<FragmentBody> pieces;
  std::vector<CrackFace> cracks;  ///< by triangle, with both sides' stress
  FractureImpulses push;
  FractureEnergies energies;
  double crack_area_m2 = 0.0;
  double crack_duration_s = 0.0;  ///< from where stress was largest to the farthest crack
  int n_cells = 0;
  int n_merged = 0;
  int n_enclosed = 0;  ///< pieces that cannot come apart (only without merge_enclosed)
  PatternLimit limit = PatternLimit::kNotRun;
  std::optional<double> next_fracture_energy_j;
};

/// Strain energy [J] that pieces keep under the load that still acts on them (errata 51); called with the pieces and the load's factor.
using ResidualEnergy = std::function<double(const std::vector<FragmentBody>& pieces, double load_factor)>;

/// SB 3.2 and 3.3 for one load of one body.
/// 1. E_S = sum density x volume. More than available_energy_j cannot be there (errata 49, 50): then densities are scaled by
///    available/E_S, stresses by its root.
/// 2. Rankine: nothing breaks unless a principal stress (StressInput::breaking_pa) reaches the strength (in elements that the score runs through: that
///    times the score's factor; if only there, only the score breaks).
/// 3. The pattern whose E_F <= eta E_S' (PatternMaker::affordable).
/// 4. Pieces; where they keep more strain than is left, fewer cells.
/// 5. Impulses with E_S' - residual - E_F.
/// The same seed gives the same bits; a body scaled by a power of two in length with the same field gives the same pieces.
/// @throws InputError for arrays of the wrong size, values that are not finite, a body that is not valid
FractureResult fracture_body(const ParentBody& parent, const StressInput& stress, const FractureOptions& options,
                             double available_energy_j, std::uint64_t seed, const ResidualEnergy& residual = {});

}  // namespace klang::fracture
