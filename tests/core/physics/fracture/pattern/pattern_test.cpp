// Seeds, power cells, patterns that their energy pays for, and the pieces as bodies.
#include "core/physics/fracture/pattern/pattern.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/geometry/mesh/mass_properties.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/tetgen_mesher.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/fracture/pattern/fragment_body.hpp"
#include "core/physics/fracture/pattern/geodesic.hpp"
#include "core/physics/rigid/convex_parts.hpp"
#include "tests/core/physics/fracture/boxes.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;
using testing::box;

Eigen::VectorXd even(const mesh::TetMesh& mesh) { return Eigen::VectorXd::Ones(mesh.n_elements()); }

/// Density that falls off from a corner of the body.
Eigen::VectorXd towards_corner(const mesh::TetMesh& mesh, double length_m) {
  Eigen::VectorXd density(mesh.n_elements());
  const Vector3d corner = mesh.nodes_m.colwise().minCoeff().transpose();
  for (int e = 0; e < mesh.n_elements(); ++e) {
    Vector3d middle = Vector3d::Zero();
    for (int c = 0; c < 4; ++c) middle += 0.25 * mesh.nodes_m.row(mesh.elements(e, c)).transpose();
    density[e] = 1e4 * std::exp(-(middle - corner).norm() / length_m);
  }
  return density;
}

PatternRules rules(double spendable_j, double toughness = 80.0) {
  PatternRules r;
  r.toughness_j_m2 = toughness;
  r.spendable_j = spendable_j;
  r.smallest_piece_m = 0.006;
  return r;
}

TEST(Seeds, AreDrawnByEnergy) {
  const mesh::TetMesh mesh = box({0.2, 0.2, 0.01}, 20, 20, 1);
  Eigen::VectorXd density = even(mesh);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    double x = 0.0;
    for (int c = 0; c < 4; ++c) x += mesh.nodes_m(mesh.elements(e, c), 0);
    if (x > 0.0) density[e] = 3.0;
  }
  int right = 0;
  const int n = 2000;
  for (int s = 0; s < n; ++s) right += SeedSampler(mesh, density, 0.0, 5, s).first(1)[0].at_m.x() > 0.0 ? 1 : 0;
  EXPECT_LE(std::abs(right - 0.75 * n), 4.0 * std::sqrt(n * 0.75 * 0.25));  // four deviations
}

TEST(Seeds, OfOneSequenceAreTheSameHoweverManyAreDrawn) {
  const mesh::TetMesh mesh = box({0.2, 0.2, 0.01}, 10, 10, 1);
  SeedSampler at_once(mesh, even(mesh), 0.01, 3), one_by_one(mesh, even(mesh), 0.01, 3),
      other(mesh, even(mesh), 0.01, 4);
  at_once.first(30);
  for (int i = 0; i < 30; ++i) EXPECT_EQ(one_by_one.first(i + 1)[i].element, at_once.first(30)[i].element);
  EXPECT_NE(other.first(1)[0].element, at_once.first(1)[0].element);
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < i; ++j) EXPECT_GE((at_once.first(30)[i].at_m - at_once.first(30)[j].at_m).norm(), 0.01);
}

TEST(Seeds, EndWhereNoMoreKeepTheirDistance) {
  const mesh::TetMesh mesh = box({0.1, 0.1, 0.01}, 10, 10, 1);
  const std::size_t n = SeedSampler(mesh, even(mesh), 0.05, 1).first(100).size();
  EXPECT_GE(n, 2u);
  EXPECT_LE(n, 12u);
}

// For two seeds the plane touches SB's ball on the line between them.
TEST(PowerCells, PlaneOfTwoSeedsCutsTheLineAsTheWeightedDistancesDo) {
  const std::vector<Seed> seeds{{0, {0, 0, 0}, 1.0}, {1, {0.1, 0, 0}, 0.1}};
  const double k0 = 1.0, k1 = std::pow(0.1, 0.15);
  const PowerCells cells(seeds, 0.15);
  EXPECT_LE(std::abs(cells.half_spaces(0)[0].offset_m - 0.1 * k1 / (k0 + k1)), 1e-15);
  EXPECT_LE((cells.half_spaces(0)[0].normal - Vector3d::UnitX()).norm(), 1e-15);
}

TEST(PowerCells, EverySeedLiesInItsOwnCell) {
  const mesh::TetMesh mesh = box({0.3, 0.3, 0.012}, 24, 24, 1);
  SeedSampler sampler(mesh, towards_corner(mesh, 0.02), 0.003, 11);
  const int n = static_cast<int>(sampler.first(80).size());
  const PowerCells cells(sampler.first(n), 0.5);
  for (int i = 0; i < n; ++i)
    for (const HalfSpace& h : cells.half_spaces(i)) EXPECT_LT(h.normal.dot(cells.seeds()[i].at_m), h.offset_m);
}

TEST(PowerCells, HighDensityMakesSmallCells) {
  const mesh::TetMesh mesh = box({0.3, 0.3, 0.012}, 20, 20, 1);
  SeedSampler sampler(mesh, even(mesh), 0.03, 2);
  std::vector<Seed> seeds = sampler.first(20);
  for (std::size_t i = 0; i < seeds.size(); ++i) seeds[i].density = i % 2 == 0 ? 1.0 : 0.05;
  const auto mean_of_dense = [&](double alpha) {
    const RegionCut cut = cut_regions(mesh, PowerCells(seeds, alpha).fields(mesh));
    double sum = 0.0;
    for (int e = 0; e < cut.mesh.n_elements(); ++e)
      if (cut.region[e] % 2 == 0)
        sum += (cut.mesh.nodes_m.row(cut.mesh.elements(e, 1)) - cut.mesh.nodes_m.row(cut.mesh.elements(e, 0)))
                   .cross(cut.mesh.nodes_m.row(cut.mesh.elements(e, 2)) - cut.mesh.nodes_m.row(cut.mesh.elements(e, 0)))
                   .dot(cut.mesh.nodes_m.row(cut.mesh.elements(e, 3)) - cut.mesh.nodes_m.row(cut.mesh.elements(e, 0))) /
               6.0;
    return sum;
  };
  EXPECT_LT(mean_of_dense(0.15), mean_of_dense(0.0));
  EXPECT_LT(mean_of_dense(0.4), mean_of_dense(0.15));
}

TEST(PowerCells, ClippedCornersOfACubeAreThoseOfTheClippedBody) {
  const Eigen::Matrix3Xd cube = testing::corners({2, 2, 2});
  EXPECT_EQ(clipped_corners(cube, {Vector3d::UnitX(), 2.0}).cols(), 8);
  EXPECT_EQ(clipped_corners(cube, {Vector3d::UnitX(), -1.0}).cols(), 0);
  const Eigen::Matrix3Xd half = clipped_corners(cube, {Vector3d::UnitX(), 0.25});
  EXPECT_EQ(half.cols(), 8);
  EXPECT_LE(std::abs(half.row(0).maxCoeff() - 0.25), 1e-15);
  // The middle section across a diagonal is a hexagon; four corners stay.
  EXPECT_EQ(clipped_corners(cube, {Vector3d::Ones().normalized(), 0.0}).cols(), 10);
}

TEST(Pattern, CostsAtMostWhatThereIsAndOneMoreCellWouldCostTooMuch) {
  const mesh::TetMesh mesh = box({0.3, 0.3, 0.012}, 16, 16, 2);
  for (const bool geodesic : {false, true})
    for (const double spendable : {0.5, 1.2, 2.5}) {
      PatternRules r = rules(spendable);
      r.geodesic = geodesic;
      PatternMaker maker(mesh, towards_corner(mesh, 0.2), r, 17);
      const FracturePattern pattern = maker.affordable();
      ASSERT_EQ(pattern.limit, PatternLimit::kEnergy);
      EXPECT_LE(pattern.fracture_energy_j, spendable);
      EXPECT_GT(*pattern.next_fracture_energy_j, spendable);
      EXPECT_GT(maker.with_cells(pattern.n_cells + 1).fracture_energy_j, spendable);
      EXPECT_LE(std::abs(pattern.fracture_energy_j / (80.0 * pattern.fragments.crack_area_m2) - 1.0), 1e-14);
    }
}

TEST(Pattern, IsNothingWhereTwoCellsCostTooMuch) {
  const mesh::TetMesh mesh = box({0.3, 0.3, 0.012}, 8, 8, 1);
  const FracturePattern pattern = PatternMaker(mesh, even(mesh), rules(0.1), 1).affordable();
  EXPECT_EQ(pattern.n_cells, 0);
  EXPECT_EQ(pattern.fragments.n_fragments, 0);
}

TEST(Pattern, SaysWhatStoppedIt) {
  const mesh::TetMesh mesh = box({0.3, 0.3, 0.012}, 8, 8, 1);
  PatternRules r = rules(1e6);
  r.most_cells = 5;
  EXPECT_EQ(PatternMaker(mesh, even(mesh), r, 1).affordable().limit, PatternLimit::kCells);
  r.most_cells = 400;
  r.smallest_piece_m = 0.1;
  EXPECT_EQ(PatternMaker(mesh, even(mesh), r, 1).affordable().limit, PatternLimit::kDistance);
}

TEST(Pattern, AScoreBreaksFirstAndDividesTheBody) {
  const mesh::TetMesh mesh = box({0.1, 0.1, 0.008}, 9, 9, 2);
  PatternRules r = rules(0.2, 200.0);
  r.score = ScoredPlane{{Vector3d::UnitX(), 0.002}, 0.1, 0.1};
  r.score_alone = true;
  const FracturePattern alone = PatternMaker(mesh, even(mesh), r, 1).affordable();
  EXPECT_EQ(alone.limit, PatternLimit::kScore);
  EXPECT_EQ(alone.fragments.n_fragments, 2);
  EXPECT_LE(std::abs(alone.fracture_energy_j / (0.1 * 200.0 * 0.1 * 0.008) - 1.0), 1e-9);
  r.score_alone = false;
  r.spendable_j = 0.6;
  const FracturePattern more = PatternMaker(mesh, even(mesh), r, 1).affordable();
  EXPECT_GT(more.fragments.n_fragments, 2);
  for (std::size_t e = 0; e < more.fragments.cut.element.size(); ++e) {
    double x = 0.0;
    for (int c = 0; c < 4; ++c) x += 0.25 * more.fragments.cut.mesh.nodes_m(more.fragments.cut.mesh.elements(e, c), 0);
    EXPECT_EQ(more.fragments.cut.region[e] % 2, x < 0.002 ? 0 : 1);
  }
}

TEST(FragmentBodies, VolumeMassAndInertiaAddUpToTheParent) {
  const mesh::TetMesh mesh = box({0.3, 0.2, 0.012}, 16, 12, 2);
  for (const bool geodesic : {false, true}) {
    PatternRules r = rules(2.0);
    r.geodesic = geodesic;
    const FracturePattern pattern = PatternMaker(mesh, towards_corner(mesh, 0.1), r, 5).affordable();
    const std::vector<FragmentBody> pieces = fragment_bodies(pattern, {{testing::corners({0.3, 0.2, 0.012})}}, 2600.0);
    ASSERT_GT(pieces.size(), 5u);
    const mesh::MassProperties whole = mesh::mass_properties(mesh);
    double mass = 0.0;
    Vector3d first = Vector3d::Zero();
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
    for (const FragmentBody& piece : pieces) {
      mass += piece.mass_kg;
      first += piece.mass_kg * piece.centre_m;
      const Vector3d arm = piece.centre_m - whole.centre_m;
      inertia += piece.inertia_kg_m2 +
                 piece.mass_kg * (arm.squaredNorm() * Eigen::Matrix3d::Identity() - arm * arm.transpose());
    }
    EXPECT_LE(std::abs(mass / (2600.0 * whole.volume_m3) - 1.0), 1e-12);
    EXPECT_LE((first / mass - whole.centre_m).norm(), 1e-12 * 0.3);
    EXPECT_LE((inertia - 2600.0 * whole.inertia_m5).norm(), 1e-12 * inertia.norm());
  }
}

// Bullet's hull, by which concavity is measured, rounds corners to 1e-4 of a part's size.
TEST(FragmentBodies, PowerCellsOfAConvexBodyCollideAsTheyAre) {
  const Vector3d sides(0.3, 0.2, 0.012);
  const mesh::TetMesh mesh = box(sides, 16, 12, 2);
  const FracturePattern pattern = PatternMaker(mesh, even(mesh), rules(2.0), 5).affordable();
  for (const FragmentBody& piece : fragment_bodies(pattern, {{testing::corners(sides)}}, 2600.0)) {
    ASSERT_EQ(piece.parts.size(), 1u);
    EXPECT_LE(piece.concavity, 2e-3);
    // Every node of the piece lies in the box around its part and the other way round.
    const Eigen::Matrix3Xd& corners = piece.parts[0].corners_m;
    EXPECT_LE((corners.rowwise().maxCoeff() - piece.mesh.nodes_m.colwise().maxCoeff().transpose()).norm(), 1e-9);
    EXPECT_LE((corners.rowwise().minCoeff() - piece.mesh.nodes_m.colwise().minCoeff().transpose()).norm(), 1e-9);
  }
}

// What lies in the hollow, or lay beside the wall, is not struck by what the wall falls into.
TEST(FragmentBodies, PiecesOfAHollowBodyLeaveItsHollowFree) {
  const double outer_m = 0.05, wall_m = 0.004;
  const mesh::ShapeSpec tube{"tube", {{"length_m", 0.1}, {"outer_radius_m", outer_m}, {"wall_m", wall_m}}, {}};
  mesh::ShapeMeshOptions options;
  options.order = 1;
  options.max_edge_m = 0.008;
  const mesh::TetMesh mesh = mesh::mesh_shape(tube, options);
  std::vector<rigid::ConvexPart> parts;
  for (Eigen::Matrix3Xd& corners_m : mesh::convex_parts(tube)) parts.push_back({std::move(corners_m)});
  PatternRules r = rules(0.4);
  r.geodesic = true;
  const FracturePattern pattern = PatternMaker(mesh, even(mesh), r, 5).affordable();
  const std::vector<FragmentBody> pieces = fragment_bodies(pattern, parts, 2600.0);
  ASSERT_GT(pieces.size(), 3u);
  /// Volume of parts, and how near to the axis the middles of their hulls' triangles come.
  const auto measure = [](const std::vector<rigid::ConvexPart>& list) {
    std::pair<double, double> found{0.0, HUGE_VAL};
    for (const rigid::ConvexPart& part : list) {
      const mesh::SurfaceMesh hull = rigid::hull_of(part);
      found.first += mesh::mass_properties(hull).volume_m3;
      for (Eigen::Index t = 0; t < hull.triangles.rows(); ++t) {
        Vector3d middle = Vector3d::Zero();
        for (int c = 0; c < 3; ++c) middle += hull.vertices_m.row(hull.triangles(t, c)).transpose() / 3.0;
        found.second = std::min(found.second, middle.head<2>().norm());
      }
    }
    return found;
  };
  const auto [body_m3, body_reach_m] = measure(parts);
  double filled_m3 = 0.0;
  for (const FragmentBody& piece : pieces) {
    ASSERT_GE(piece.parts.size(), 1u);
    const auto [piece_m3, reach_m] = measure(piece.parts);
    filled_m3 += piece_m3;
    EXPECT_GE(reach_m,
              body_reach_m - 0.5 * wall_m);  // slivers that joined a neighbour bulge a little
  }
  EXPECT_LE(filled_m3, 1.15 * body_m3);
  EXPECT_GE(filled_m3, 0.8 * body_m3);
}

TEST(FragmentBodies, EveryPieceIsASolidThatTetGenFills) {
  const mesh::TetMesh mesh = box({0.2, 0.15, 0.008}, 14, 10, 1);
  const FracturePattern pattern = PatternMaker(mesh, even(mesh), rules(0.8), 9).affordable();
  const std::vector<FragmentBody> pieces = fragment_bodies(pattern, {{testing::corners({0.2, 0.15, 0.008})}}, 2600.0);
  ASSERT_GT(pieces.size(), 8u);
  for (const FragmentBody& piece : pieces) {
    const mesh::SurfaceMesh surface = fragment_surface(piece, 0.006);
    EXPECT_LE(std::abs(mesh::check_closed_surface(surface, "piece").volume_m3 / piece.volume_m3 - 1.0), 1e-4);
    mesh::TetgenOptions options;
    options.max_edge_m = 0.008;
    options.order = 1;
    const mesh::TetMesh filled = mesh::mesh_surface(surface, options, "piece");
    EXPECT_LE(std::abs(mesh::mesh_volume_m3(filled) / piece.volume_m3 - 1.0), 1e-4);
  }
}

TEST(Geodesic, RegionsGoAroundCorners) {
  // A U: the tips of its arms are near in space and far along it.
  mesh::TetMesh whole = box({0.1, 0.1, 0.01}, 10, 10, 1);
  std::vector<int> kept;
  for (int e = 0; e < whole.n_elements(); ++e) {
    double x = 0.0, y = 0.0;
    for (int c = 0; c < 4; ++c) {
      x += 0.25 * whole.nodes_m(whole.elements(e, c), 0);
      y += 0.25 * whole.nodes_m(whole.elements(e, c), 1);
    }
    if (!(std::abs(x) < 0.01 && y > -0.03)) kept.push_back(e);
  }
  mesh::IndexRows elements(static_cast<Eigen::Index>(kept.size()), 4);
  for (std::size_t i = 0; i < kept.size(); ++i)
    elements.row(static_cast<Eigen::Index>(i)) = whole.elements.row(kept[i]);
  std::vector<int> row(static_cast<std::size_t>(whole.n_nodes()), -1);
  int n = 0;
  mesh::Points nodes(whole.n_nodes(), 3);
  for (Eigen::Index i = 0; i < elements.size(); ++i) {
    int& v = *(elements.data() + i);
    if (row[v] < 0) {
      nodes.row(n) = whole.nodes_m.row(v);
      row[v] = n++;
    }
    v = row[v];
  }
  mesh::TetMesh u{nodes.topRows(n), elements, {}};
  // One seed at the tip of each arm: regions are the arms, whatever is near across the gap.
  int left = -1, right = -1;
  for (int e = 0; e < u.n_elements(); ++e) {
    const double x = u.nodes_m(u.elements(e, 0), 0), y = u.nodes_m(u.elements(e, 0), 1);
    if (y > 0.039 && x < -0.01 && left < 0) left = e;
    if (y > 0.039 && x > 0.039) right = e;
  }
  const auto seed = [&](int e) {
    Vector3d middle = Vector3d::Zero();
    for (int c = 0; c < 4; ++c) middle += 0.25 * u.nodes_m.row(u.elements(e, c)).transpose();
    return Seed{e, middle, 1.0};
  };
  ASSERT_GE(left, 0);
  ASSERT_GE(right, 0);
  const RegionCut cut = cut_regions(u, GeodesicRegions(u, 0.15).fields({seed(left), seed(right)}));
  for (int e = 0; e < cut.mesh.n_elements(); ++e) {
    double x = 0.0, y = 0.0;
    for (int c = 0; c < 4; ++c) {
      x += 0.25 * cut.mesh.nodes_m(cut.mesh.elements(e, c), 0);
      y += 0.25 * cut.mesh.nodes_m(cut.mesh.elements(e, c), 1);
    }
    if (y > 0.0) {
      EXPECT_EQ(cut.region[e], x < 0.0 ? 0 : 1);
    }
  }
}

}  // namespace
}  // namespace klang::fracture
