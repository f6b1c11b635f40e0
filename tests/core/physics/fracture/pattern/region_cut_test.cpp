// Cutting tetrahedra where regions meet: areas, volumes, neighbours.
#include "core/physics/fracture/pattern/region_cut.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/tet_geometry.hpp"
#include "core/physics/fracture/pattern/fragments.hpp"
#include "core/physics/fracture/pattern/power_cells.hpp"
#include "tests/core/physics/fracture/boxes.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;
using testing::box;

RegionFields two_sides(const mesh::TetMesh& mesh, const Vector3d& normal, double offset) {
  RegionFields fields{Eigen::MatrixXd::Zero(2, mesh.n_nodes()), Eigen::MatrixXd::Ones(2, 2)};
  fields.values.row(0) = (mesh.nodes_m * normal).transpose().array() - offset;
  return fields;
}

/// Area of the section of the unit cube around the origin by n . x = c: the derivative of its volume, by inclusion and exclusion.
double section_area(const Vector3d& n, double c) {
  const Vector3d a = n.cwiseAbs();
  double sum = 0.0, product = 1.0;
  int dims = 0;
  for (int i = 0; i < 3; ++i)
    if (a[i] > 0.0) {
      product *= a[i];
      ++dims;
    }
  const double shifted = c + 0.5 * a.sum();
  for (int corner = 0; corner < 8; ++corner) {
    double at = shifted, sign = 1.0;
    bool used = true;
    for (int i = 0; i < 3; ++i)
      if ((corner >> i) & 1) {
        used = used && a[i] > 0.0;
        at -= a[i];
        sign = -sign;
      }
    if (used && at > 0.0) sum += sign * std::pow(at, dims - 1);
  }
  return sum / (product * std::tgamma(dims)) * n.norm();
}

double volume_of(const mesh::TetMesh& mesh) {
  double sum = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) sum += mesh::tet_volume_m3(mesh, e);
  return sum;
}

/// Every face belongs to one element or to two.
bool conforms(const mesh::TetMesh& mesh, double outer_area) {
  std::map<std::array<int, 3>, int> count;
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (const auto& f : mesh::kTetFaces) {
      std::array<int, 3> key{mesh.elements(e, f[0]), mesh.elements(e, f[1]), mesh.elements(e, f[2])};
      std::sort(key.begin(), key.end());
      if (++count[key] > 2) return false;
    }
  // Faces of one element make up the outside and nothing else.
  double area = 0.0;
  for (const auto& [key, n] : count)
    if (n == 1) {
      const Vector3d p = mesh.nodes_m.row(key[0]), q = mesh.nodes_m.row(key[1]), r = mesh.nodes_m.row(key[2]);
      area += 0.5 * (q - p).cross(r - p).norm();
    }
  return std::abs(area / outer_area - 1.0) <= 1e-9;
}

// Errata 56: splitting at the middles of edges makes the area 1.00 to 1.60 of the truth, whatever the mesh.
TEST(RegionCut, AreaOfAPlaneIsExactInAnyDirectionAndOnAnyMesh) {
  const std::vector<std::pair<Vector3d, double>> planes{{{1, 0, 0}, 0.0},  {{1, 0, 0}, 0.013},  {{1, 1, 0}, 0.0},
                                                        {{1, 2, 3}, 0.05}, {{3, -1, 0.5}, 0.1}, {{1, -1, 0}, 0.003},
                                                        {{1, 1, 1}, 0.0},  {{0, 0, 1}, 0.25},   {{1, 2, 3}, 0.0}};
  for (const int n : {4, 8, 12})
    for (const auto& [normal, offset] : planes) {
      const mesh::TetMesh mesh = box({1, 1, 1}, n, n, n);
      const RegionFields fields = two_sides(mesh, normal.normalized(), offset);
      const Fragments pieces = fragments_of(cut_regions(mesh, fields), {});
      const double exact = section_area(normal, offset * normal.norm());
      EXPECT_EQ(pieces.n_fragments, 2);
      EXPECT_LE(std::abs(pieces.crack_area_m2 / exact - 1.0), 1e-9) << normal.transpose() << " cells " << n;
      EXPECT_LE(std::abs(volume_of(pieces.cut.mesh) - 1.0), 1e-12);
      EXPECT_TRUE(conforms(pieces.cut.mesh, 6.0));
    }
}

TEST(RegionCut, PiecesOfManyPowerCellsFillTheBodyAndTheMeshConforms) {
  const mesh::TetMesh mesh = box({0.2, 0.15, 0.03}, 12, 9, 3);
  SeedSampler sampler(mesh, Eigen::VectorXd::Ones(mesh.n_elements()), 0.004, 7);
  for (const int n : {2, 3, 10, 40, 120}) {
    std::vector<Seed> seeds(sampler.first(n).begin(), sampler.first(n).begin() + n);
    const PowerCells cells(seeds, 0.15);
    const RegionCut cut = cut_regions(mesh, cells.fields(mesh));
    EXPECT_TRUE(conforms(cut.mesh, 2 * (0.2 * 0.15 + 0.15 * 0.03 + 0.2 * 0.03))) << n;
    EXPECT_LE(std::abs(volume_of(cut.mesh) / (0.2 * 0.15 * 0.03) - 1.0), 1e-12);
    double lowest = 0.0;
    for (int e = 0; e < cut.mesh.n_elements(); ++e) lowest = std::min(lowest, mesh::tet_volume_m3(cut.mesh, e));
    EXPECT_GE(lowest, -1e-16 * 0.2 * 0.15 * 0.03);
    // Each element's middle lies in the cell of its region, to the tolerance.
    for (int e = 0; e < cut.mesh.n_elements(); ++e) {
      Vector3d middle = Vector3d::Zero();
      for (int c = 0; c < 4; ++c) middle += 0.25 * cut.mesh.nodes_m.row(cut.mesh.elements(e, c)).transpose();
      for (const HalfSpace& h : cells.half_spaces(cut.region[e]))
        ASSERT_LE(h.normal.dot(middle) - h.offset_m, 1e-9 * 0.25) << "element " << e << " of " << n << " cells";
    }
  }
}

// Second order for balls: a function that is no plane is taken as linear in each tetrahedron.
TEST(RegionCut, AreaOfABallConvergesAtOrderTwo) {
  double coarse = 0.0;
  for (const int n : {8, 16, 32}) {
    const mesh::TetMesh mesh = box({1, 1, 1}, n, n, n);
    RegionFields fields{Eigen::MatrixXd::Zero(2, mesh.n_nodes()), Eigen::MatrixXd::Ones(2, 2)};
    for (int v = 0; v < mesh.n_nodes(); ++v) fields.values(0, v) = mesh.nodes_m.row(v).norm() - 0.31;
    const double error = 1.0 - fragments_of(cut_regions(mesh, fields), {.merge_enclosed = false}).crack_area_m2 /
                                   (4.0 * M_PI * 0.31 * 0.31);
    if (coarse > 0.0) {
      EXPECT_GE(std::log2(coarse / error), 1.6);
      EXPECT_LE(std::log2(coarse / error), 2.4);
    }
    coarse = error;
  }
}

TEST(RegionCut, RefusesWhatIsNotFinite) {
  const mesh::TetMesh mesh = box({1, 1, 1}, 2, 2, 2);
  RegionFields fields = two_sides(mesh, Vector3d::UnitX(), 0.0);
  fields.values(0, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(cut_regions(mesh, fields), InputError);
}

// Errata 57: two cubes of one region that touch in an edge are two bodies.
TEST(Fragments, WhatHangsByAnEdgeIsABodyOfItsOwn) {
  const mesh::TetMesh mesh = box({1, 1, 0.5}, 2, 2, 1);
  RegionCut cut = {mesh, {}, {}};
  for (int e = 0; e < mesh.n_elements(); ++e) {
    double x = 0.0, y = 0.0;
    for (int c = 0; c < 4; ++c) {
      x += mesh.nodes_m(mesh.elements(e, c), 0);
      y += mesh.nodes_m(mesh.elements(e, c), 1);
    }
    cut.region.push_back(x * y > 0.0 ? 0 : 1);
    cut.element.push_back(e);
  }
  const Fragments pieces = fragments_of(cut, {});
  EXPECT_EQ(pieces.n_fragments, 4);
  EXPECT_EQ(pieces.region, (std::vector<int>{0, 0, 1, 1}));
  EXPECT_LE(std::abs(pieces.crack_area_m2 - 4 * 0.5 * 0.5), 1e-15);
}

// Errata 55: a region wholly inside another cannot come apart.
TEST(Fragments, AnEnclosedPieceStaysWithItsNeighbourOrIsNamed) {
  const mesh::TetMesh mesh = box({1, 1, 1}, 8, 8, 8);
  RegionFields fields{Eigen::MatrixXd::Zero(2, mesh.n_nodes()), Eigen::MatrixXd::Ones(2, 2)};
  for (int v = 0; v < mesh.n_nodes(); ++v) fields.values(0, v) = mesh.nodes_m.row(v).norm() - 0.31;
  const RegionCut cut = cut_regions(mesh, fields);
  const Fragments merged = fragments_of(cut, {});
  EXPECT_EQ(merged.n_fragments, 1);
  EXPECT_EQ(merged.n_merged, 1);
  EXPECT_EQ(merged.crack_area_m2, 0.0);
  const Fragments kept = fragments_of(cut, {.merge_enclosed = false});
  EXPECT_EQ(kept.n_fragments, 2);
  EXPECT_EQ(kept.enclosed, std::vector<int>{0});
}

TEST(Fragments, PartsBelowTheLeastVolumeStayWithTheNeighbourTheyShareMostWith) {
  const mesh::TetMesh mesh = box({1, 1, 1}, 4, 4, 4);
  const RegionCut cut = cut_regions(mesh, two_sides(mesh, Vector3d::UnitX(), -0.45));
  EXPECT_EQ(fragments_of(cut, {.least_volume_m3 = 0.04}).n_fragments, 2);
  EXPECT_EQ(fragments_of(cut, {.least_volume_m3 = 0.06}).n_fragments, 1);
}

}  // namespace
}  // namespace klang::fracture
