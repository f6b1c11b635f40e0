// A body under a load: does it break, into what, and where does the energy go.
#include "core/physics/fracture/event/fracture_body.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "tests/core/physics/fracture/boxes.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

ParentBody plate(const Vector3d& sides, int nx, int ny, int nz) {
  ParentBody body;
  body.name = "plate";
  body.mesh = testing::box(sides, nx, ny, nz);
  body.parts = {{testing::corners(sides)}};
  body.density_kg_m3 = 2600.0;
  body.toughness_j_m2 = 80.0;
  body.tensile_strength_pa = 45e6;
  body.youngs_modulus_pa = 6.2e10;
  body.poissons_ratio = 0.2;
  return body;
}

/// Biaxial tension by x and y, the same everywhere.
StressInput even_tension(const ParentBody& body, double stress_pa) {
  StressInput in;
  const int n = body.mesh.n_elements();
  const double density = stress_pa * stress_pa * (1.0 - body.poissons_ratio) / body.youngs_modulus_pa;
  in.energy_density_j_m3 = Eigen::VectorXd::Constant(n, density);
  in.stress_pa = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, n);
  in.stress_pa.topRows(2).setConstant(stress_pa);
  return in;
}

/// Bending about y: tension above, compression below, most in the middle.
StressInput bending(const ParentBody& body, double largest_pa) {
  StressInput in;
  const int n = body.mesh.n_elements();
  in.energy_density_j_m3.resize(n);
  in.stress_pa = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, n);
  const Vector3d half = body.mesh.nodes_m.colwise().maxCoeff().transpose();
  for (int e = 0; e < n; ++e) {
    Vector3d at = Vector3d::Zero();
    for (int c = 0; c < 4; ++c) at += 0.25 * body.mesh.nodes_m.row(body.mesh.elements(e, c)).transpose();
    const double stress = largest_pa * at.z() / half.z() * (1.0 - std::abs(at.x()) / half.x());
    in.stress_pa(0, e) = stress;
    in.energy_density_j_m3[e] = 0.5 * stress * stress / body.youngs_modulus_pa;
  }
  return in;
}

double sum(const FractureEnergies& e) { return e.fracture_j + e.kinetic_j + e.vibration_j + e.residual_j; }

TEST(FractureBody, DoesNotBreakBelowItsStrength) {
  const ParentBody body = plate({0.2, 0.2, 0.008}, 8, 8, 1);
  const FractureResult whole = fracture_body(body, even_tension(body, 44e6), {}, 1e9, 1);
  EXPECT_EQ(whole.status, FractureStatus::kBelowStrength);
  EXPECT_TRUE(whole.pieces.empty());
  EXPECT_LE(std::abs(whole.largest_stress_pa / 44e6 - 1.0), 1e-12);
  EXPECT_EQ(fracture_body(body, even_tension(body, 46e6), {}, 1e9, 1).status, FractureStatus::kBroken);
}

// Errata 49, 50: more than the impact's compression cannot be in the strain; the stress falls with it.
TEST(FractureBody, ALoadWithMoreEnergyThanThereIsIsScaledBeforeTheStrengthIsAsked) {
  const ParentBody body = plate({0.2, 0.2, 0.008}, 8, 8, 1);
  const StressInput in = even_tension(body, 90e6);
  const double all = in.energy_density_j_m3[0] * 0.2 * 0.2 * 0.008;
  const FractureResult half = fracture_body(body, in, {}, 0.5 * all, 1);
  EXPECT_EQ(half.status, FractureStatus::kBroken);
  EXPECT_LE(std::abs(half.load_factor - std::sqrt(0.5)), 1e-12);
  EXPECT_LE(std::abs(half.energies.strain_j / (0.5 * all) - 1.0), 1e-12);
  EXPECT_LE(std::abs(half.largest_stress_pa / (90e6 * std::sqrt(0.5)) - 1.0), 1e-12);
  EXPECT_EQ(fracture_body(body, in, {}, 0.24 * all, 1).status, FractureStatus::kBelowStrength);
  EXPECT_EQ(fracture_body(body, in, {}, 0.0, 1).status, FractureStatus::kBelowStrength);
}

TEST(FractureBody, CracksCostAtMostTheirShareAndOneMoreCellWouldCostTooMuch) {
  const ParentBody body = plate({0.3, 0.3, 0.012}, 14, 14, 2);
  for (const std::uint64_t seed : {1, 2, 3}) {
    const FractureResult r = fracture_body(body, bending(body, 80e6), {}, 1e9, seed);
    ASSERT_EQ(r.status, FractureStatus::kBroken);
    EXPECT_LE(r.energies.fracture_j, 0.8 * r.energies.strain_j);
    EXPECT_EQ(r.limit, PatternLimit::kEnergy);
    EXPECT_GT(r.next_fracture_energy_j.value(), 0.8 * r.energies.strain_j);
    EXPECT_LE(std::abs(r.energies.fracture_j / (80.0 * r.crack_area_m2) - 1.0), 1e-12);
  }
}

TEST(FractureBody, EveryJouleOfTheStrainIsBookedAndTheMotionHasWhatIsBooked) {
  const ParentBody body = plate({0.3, 0.3, 0.012}, 14, 14, 2);
  FractureOptions quiet;
  quiet.impulses = false;
  FractureOptions geodesic;
  geodesic.pattern = PatternKind::kGeodesic;
  for (const FractureOptions& options : {FractureOptions{}, quiet, geodesic}) {
    const FractureResult r = fracture_body(body, bending(body, 80e6), options, 1e9, 4);
    ASSERT_EQ(r.status, FractureStatus::kBroken);
    EXPECT_LE(std::abs(sum(r.energies) - r.energies.strain_j), 1e-15 * r.energies.strain_j);
    EXPECT_GE(r.energies.kinetic_j, 0.0);
    EXPECT_GE(r.energies.vibration_j, 0.0);
    double kinetic = 0.0, scale = 0.0;
    Vector3d momentum = Vector3d::Zero(), spin = Vector3d::Zero();
    for (std::size_t d = 0; d < r.pieces.size(); ++d) {
      const Vector3d v = r.push.velocity_m_s[d], w = r.push.angular_velocity_rad_s[d];
      kinetic += 0.5 * r.pieces[d].mass_kg * v.squaredNorm() + 0.5 * w.dot(r.pieces[d].inertia_kg_m2 * w);
      momentum += r.pieces[d].mass_kg * v;
      spin += r.pieces[d].centre_m.cross(r.pieces[d].mass_kg * v) + r.pieces[d].inertia_kg_m2 * w;
      scale += r.pieces[d].mass_kg * v.norm();
    }
    EXPECT_LE(std::abs(kinetic - r.energies.kinetic_j), 1e-12 * r.energies.strain_j);
    EXPECT_LE(momentum.norm(), 1e-13 * scale);
    EXPECT_LE(spin.norm(), 1e-13 * scale * 0.3);
    EXPECT_EQ(options.impulses, r.energies.kinetic_j > 0.0);
  }
}

TEST(FractureBody, ACompressedBodyThatBreaksIsNotPushedApart) {
  // Tension in one element makes it break; everything else, and all cracks, are under pressure from all sides.
  ParentBody body = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  body.tensile_strength_pa = 1e6;
  StressInput in = even_tension(body, 60e6);
  in.energy_density_j_m3[7] = 0.0;
  in.stress_pa.topRows(3).setConstant(-60e6);
  in.stress_pa(2, 7) = 50e6;
  int shut = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const FractureResult r = fracture_body(body, in, {}, 3.0, seed);
    ASSERT_EQ(r.status, FractureStatus::kBroken);
    bool beside_tension = false;
    for (const CrackFace& crack : r.cracks)
      beside_tension = beside_tension || crack.stress_a_pa(2, 2) > 0.0 || crack.stress_b_pa(2, 2) > 0.0;
    if (beside_tension) continue;
    ++shut;
    EXPECT_EQ(r.push.status, PushStatus::kNothingTensile);
    EXPECT_EQ(r.energies.kinetic_j, 0.0);
    EXPECT_LE(std::abs(r.energies.vibration_j + r.energies.fracture_j - r.energies.strain_j),
              1e-15 * r.energies.strain_j);
  }
  EXPECT_GE(shut, 1);
}

// Errata 51: pieces under load keep strain energy.
TEST(FractureBody, StrainThatPiecesKeepIsNotSpentAgain) {
  ParentBody body = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  body.tensile_strength_pa = 1e6;
  const StressInput in = even_tension(body, 60e6);
  const FractureResult free = fracture_body(body, in, {}, 4.0, 1);
  const double strain = free.energies.strain_j;
  const FractureResult kept = fracture_body(body, in, {}, 4.0, 1, [&](const auto&, double) { return 0.5 * strain; });
  ASSERT_EQ(kept.status, FractureStatus::kBroken);
  EXPECT_EQ(kept.energies.residual_j, 0.5 * strain);
  EXPECT_LE(kept.energies.fracture_j, 0.5 * strain);
  EXPECT_LT(kept.n_cells, free.n_cells);
  EXPECT_LE(std::abs(sum(kept.energies) - strain), 1e-15 * strain);
}

TEST(FractureBody, ABodyOfManyCellsThatDoNotPayIsGivenUpAfterAFewTries) {
  ParentBody body = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  body.toughness_j_m2 *= 2.0;
  const StressInput in = even_tension(body, 80e6);
  int n_tries = 0;
  const FractureResult none = fracture_body(body, in, {}, 1e9, 1, [&](const auto&, double) {
    ++n_tries;
    return 1e12;
  });
  EXPECT_EQ(none.status, FractureStatus::kTooLittleEnergy);
  const FractureResult free = fracture_body(body, in, {}, 1e9, 1);
  ASSERT_GT(free.n_cells, 40);
  EXPECT_LE(n_tries, 14);  // four by one, then strides that double down to two of at most 400
  // What pays up to some number of pieces breaks into that many.
  const auto pays_up_to_thirty = [&](const std::vector<FragmentBody>& pieces, double) {
    return pieces.size() <= 30 ? 0.0 : 1e12;
  };
  const FractureResult thirty = fracture_body(body, in, {}, 1e9, 1, pays_up_to_thirty);
  ASSERT_EQ(thirty.status, FractureStatus::kBroken);
  EXPECT_LE(thirty.pieces.size(), 30u);
  EXPECT_GE(thirty.pieces.size(), 27u);  // merging takes some
}

TEST(FractureBody, TheSameSeedGivesTheSameBitsAndAnotherSeedOthers) {
  const ParentBody body = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  const StressInput in = bending(body, 120e6);
  const FractureResult a = fracture_body(body, in, {}, 1e9, 1), b = fracture_body(body, in, {}, 1e9, 1),
                       c = fracture_body(body, in, {}, 1e9, 2);
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  for (std::size_t d = 0; d < a.pieces.size(); ++d) {
    EXPECT_EQ(a.pieces[d].mesh.nodes_m, b.pieces[d].mesh.nodes_m);
    EXPECT_EQ(a.push.velocity_m_s[d], b.push.velocity_m_s[d]);
  }
  EXPECT_NE(a.crack_area_m2, c.crack_area_m2);
}

// Lengths times 4, G_c times 16, stiffness and strength times 4: the same pieces, bit for bit (powers of two).
TEST(FractureBody, ABodyAtFourTimesTheSizeBreaksInTheSameBits) {
  const ParentBody small = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  ParentBody large = small;
  large.mesh.nodes_m *= 4.0;
  large.parts[0].corners_m *= 4.0;
  large.toughness_j_m2 *= 16.0;
  large.youngs_modulus_pa *= 4.0;
  large.tensile_strength_pa *= 4.0;
  StressInput in = bending(small, 120e6), in_large = in;
  in_large.stress_pa *= 4.0;
  in_large.energy_density_j_m3 *= 4.0;
  FractureOptions options, options_large;
  options_large.smallest_piece_m = 4.0 * options.smallest_piece_m;
  const FractureResult a = fracture_body(small, in, options, 1e9, 1),
                       b = fracture_body(large, in_large, options_large, 1e9, 1);
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  ASSERT_GT(a.pieces.size(), 5u);
  for (std::size_t d = 0; d < a.pieces.size(); ++d) {
    EXPECT_EQ(Eigen::MatrixXd(4.0 * a.pieces[d].mesh.nodes_m), Eigen::MatrixXd(b.pieces[d].mesh.nodes_m));
    EXPECT_EQ(Vector3d(2.0 * a.push.velocity_m_s[d]), b.push.velocity_m_s[d]);
  }
}

// Errata 60: N = N_law = (eta E_S / (2 G_c t))^2 / A in one event, from cells of perimeter 4 sqrt(A/N). The plate's outer edge costs
// nothing: cracks are shorter by about 0.4 of its perimeter, sqrt(N) = sqrt(N_law) + 0.8, which is 15 % of N at 120 pieces.
TEST(FractureBody, PiecesOfAnEvenlyLoadedPlateFollowTheLawOfTheirNumber) {
  const ParentBody body = plate({0.6, 0.6, 0.006}, 30, 30, 1);
  const StressInput in = even_tension(body, 60e6);
  FractureOptions options;
  options.smallest_piece_m = 0.0;
  options.most_pieces = 2000;
  const double strain = in.energy_density_j_m3[0] * 0.6 * 0.6 * 0.006;
  std::vector<double> law, with_edge;
  for (const double cells : {25.0, 100.0, 400.0}) {
    ParentBody tough = body;
    tough.toughness_j_m2 = options.eta * strain / (2.0 * 0.006 * 0.6 * std::sqrt(cells));
    double pieces = 0.0;
    const int n_seeds = cells < 50.0 ? 6 : 2;
    for (int seed = 1; seed <= n_seeds; ++seed)
      pieces += static_cast<double>(fracture_body(tough, in, options, 1e9, seed).pieces.size()) / n_seeds;
    law.push_back(pieces / cells);
    with_edge.push_back(std::pow(std::sqrt(pieces) - 0.8, 2) / cells);
  }
  EXPECT_LE(std::abs(law[1] / law[2] - 1.0), 0.15);
  for (const double ratio : with_edge) EXPECT_LE(std::abs(ratio - 1.0), 0.15);
}

// Piece count falls with G_c (SB, Figure 4).
TEST(FractureBody, TougherGlassBreaksIntoFewerPieces) {
  ParentBody body = plate({0.3, 0.3, 0.012}, 14, 14, 1);
  body.tensile_strength_pa = 1e6;
  const StressInput in = even_tension(body, 60e6);
  std::size_t before = 1000;
  for (const double toughness : {50.0, 80.0, 120.0, 200.0}) {
    body.toughness_j_m2 = toughness;
    const std::size_t n = fracture_body(body, in, {}, 4.0, 3).pieces.size();
    EXPECT_LT(n, before);
    before = n;
  }
}

TEST(FractureBody, AScoredTileBreaksAlongItsScoreWhereTheRestHolds) {
  ParentBody tile = plate({0.1, 0.1, 0.008}, 9, 9, 2);
  tile.score = ScoredPlane{{Vector3d::UnitX(), 0.0}, 0.1, 0.1};
  const FractureResult r = fracture_body(tile, bending(tile, 20e6), {}, 1e9, 1);
  ASSERT_EQ(r.status, FractureStatus::kBroken);
  EXPECT_EQ(r.limit, PatternLimit::kScore);
  ASSERT_EQ(r.pieces.size(), 2u);
  for (const FragmentBody& half : r.pieces) {
    EXPECT_LE(std::abs(half.volume_m3 / (0.05 * 0.1 * 0.008) - 1.0), 1e-12);
    EXPECT_EQ(half.parts[0].corners_m.cols(), 8);
  }
}

TEST(FractureBody, ATubeBreaksIntoSolidsThatFillIt) {
  ParentBody tube = plate({0.1, 0.1, 0.008}, 3, 3, 1);
  tube.mesh = mesh::mesh_shape({"tube", {{"length_m", 0.2}, {"outer_radius_m", 0.05}, {"wall_m", 0.004}}, {}},
                               mesh::ShapeDivisions{{16, 28, 1}}, 2);
  tube.parts.clear();
  tube.tensile_strength_pa = 1e6;
  FractureOptions options;
  options.pattern = PatternKind::kGeodesic;
  const mesh::TetMesh straight = mesh::to_linear(tube.mesh);
  const double volume = mesh::mass_properties(straight).volume_m3;
  for (const std::uint64_t seed : {1, 2}) {
    const FractureResult r = fracture_body(tube, even_tension(tube, 60e6), options, 2.0, seed);
    ASSERT_EQ(r.status, FractureStatus::kBroken);
    ASSERT_GT(r.pieces.size(), 4u);
    double sum_m3 = 0.0;
    for (const FragmentBody& piece : r.pieces) {
      sum_m3 += piece.volume_m3;
      EXPECT_NO_THROW(mesh::check_closed_surface(fragment_surface(piece, 0.008), "piece"));
    }
    EXPECT_LE(std::abs(sum_m3 / volume - 1.0), 1e-12);
  }
}

// The paper's form pulls together what tension held: pieces of an evenly pulled plate move towards its middle.
TEST(FractureBody, ThePapersImpulsesAreThereByOption) {
  ParentBody body = plate({0.3, 0.3, 0.012}, 10, 10, 1);
  body.tensile_strength_pa = 1e6;
  for (const Literature literature : {Literature::kMended, Literature::kPaper}) {
    FractureOptions options;
    options.literature = literature;
    const FractureResult r = fracture_body(body, even_tension(body, 60e6), options, 4.0, 1);
    ASSERT_EQ(r.status, FractureStatus::kBroken);
    double outwards = 0.0;
    for (std::size_t d = 0; d < r.pieces.size(); ++d)
      outwards += r.pieces[d].mass_kg * r.push.velocity_m_s[d].dot(r.pieces[d].centre_m);
    EXPECT_EQ(outwards > 0.0, literature == Literature::kMended);
  }
}

TEST(FractureBody, RefusesWhatIsNoBodyOrNoLoad) {
  const ParentBody body = plate({0.1, 0.1, 0.008}, 3, 3, 1);
  StressInput in = even_tension(body, 60e6);
  ParentBody bad = body;
  bad.toughness_j_m2 = 0.0;
  EXPECT_THROW(fracture_body(bad, in, {}, 1.0, 1), InputError);
  FractureOptions options;
  options.eta = 0.0;
  EXPECT_THROW(fracture_body(body, in, options, 1.0, 1), InputError);
  EXPECT_THROW(fracture_body(body, in, {}, std::numeric_limits<double>::quiet_NaN(), 1), InputError);
  in.stress_pa(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fracture_body(body, in, {}, 1.0, 1), InputError);
  in.stress_pa.resize(6, 3);
  EXPECT_THROW(fracture_body(body, in, {}, 1.0, 1), InputError);
}

}  // namespace
}  // namespace klang::fracture
