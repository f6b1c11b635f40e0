// The axis of least overlap of two hulls against all axes there are.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"
#include "core/physics/rigid/detail/convex_hull.hpp"
#include "core/physics/rigid/detail/hull_axis.hpp"
#include "tests/core/physics/rigid/bodies.hpp"
#include "tests/core/physics/rigid/box_features.hpp"

namespace {

using namespace klang::rigid::detail;
using Eigen::Vector3d;

/// Over faces and every pair of edges, without leaving any out.
double gap_by_all_axes(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a) {
  double best = -HUGE_VAL;
  const auto take = [&](const Vector3d& axis) {
    for (const double sign : {1.0, -1.0}) best = std::max(best, gap_along(a, b, b_to_a, sign * axis.normalized()));
  };
  for (Eigen::Index f = 0; f < a.normals.cols(); ++f) take(a.normals.col(f));
  for (Eigen::Index f = 0; f < b.normals.cols(); ++f) take(b_to_a.linear() * b.normals.col(f));
  for (const auto& ea : a.edges)
    for (const auto& eb : b.edges) {
      const Vector3d axis = ea.along.cross(b_to_a.linear() * eb.along);
      if (axis.norm() > 1e-6) take(axis);
    }
  return best;
}

TEST(HullAxis, BoxHasSixFacesAndTwelveEdges) {
  const HullFeatures b = box(1, 2, 3);
  EXPECT_EQ(b.normals.cols(), 6);
  EXPECT_EQ(b.edges.size(), 12U);
  EXPECT_TRUE(b.whole);
}

/// A box's opposite edges are parallel, these have none.
HullFeatures tetrahedron(double size) {
  Eigen::Matrix3Xd corners(3, 4);
  corners << 1, -0.6, -0.5, 0.2, 0, 0.9, -0.8, 0.1, -0.3, -0.2, -0.4, 0.8;
  return {size * corners, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
}

TEST(HullAxis, OverlapIsTheLeastOfAllAxes) {
  klang::RandomStream random(7, 0);
  int n_overlap = 0, n_edges = 0;
  for (int k = 0; k < 2000; ++k) {
    const auto draw = [&] { return 2 * random.uniform() - 1; };
    const HullFeatures a = k % 2 ? box(1, 0.7, 0.4) : tetrahedron(0.8),
                       b = k % 4 < 2 ? box(0.5, 0.9, 0.6) : tetrahedron(0.6);
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.linear() = Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized().toRotationMatrix();
    place.translation() = 0.9 * Vector3d(draw(), draw(), draw());
    const HullAxis axis = hull_axis(a, b, place);
    const double right = gap_by_all_axes(a, b, place);
    EXPECT_EQ(axis.gap > 0, right > 0);
    EXPECT_LE(std::abs(gap_along(a, b, place, axis.normal) - axis.gap), 1e-12);
    if (right > 0) continue;
    ++n_overlap;
    EXPECT_LE(std::abs(axis.gap - right), 1e-12) << k;
    bool face = false;
    for (Eigen::Index f = 0; f < a.normals.cols(); ++f)
      face = face || std::abs(std::abs(a.normals.col(f).dot(axis.normal)) - 1) < 1e-9;
    for (Eigen::Index f = 0; f < b.normals.cols(); ++f)
      face = face || std::abs(std::abs((place.linear() * b.normals.col(f)).dot(axis.normal)) - 1) < 1e-9;
    if (!face) ++n_edges;
  }
  EXPECT_GT(n_overlap, 200);
  EXPECT_GT(n_edges, 20);
}

Eigen::Isometry3d drawn_place(klang::RandomStream& random, double reach) {
  const auto draw = [&] { return 2 * random.uniform() - 1; };
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.linear() = Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized().toRotationMatrix();
  place.translation() = reach * Vector3d(draw(), draw(), draw());
  return place;
}

// Whatever points of the hulls and lower bound of the gap a hint brings.
TEST(HullAxis, AHintChangesNothing) {
  klang::RandomStream random(11, 0);
  const auto inside = [&](const HullFeatures& hull) -> Vector3d {
    Eigen::VectorXd shares(hull.corners.cols());
    for (Eigen::Index i = 0; i < shares.size(); ++i) shares[i] = random.uniform();
    return hull.corners * (shares / shares.sum());
  };
  for (int k = 0; k < 3000; ++k) {
    const HullFeatures a = k % 2 ? box(1, 0.7, 0.4) : tetrahedron(0.8),
                       b = k % 4 < 2 ? box(0.5, 0.9, 0.6) : tetrahedron(0.6);
    const Eigen::Isometry3d place = drawn_place(random, 0.9);
    const double near = k % 3 == 0 ? 0.5 : 2e-5;
    const HullAxis plain = hull_axis(a, b, place, near);
    const HullHint hint{inside(a), inside(b), k % 5 == 0 ? plain.gap : plain.gap - random.uniform()};
    const HullAxis hinted = hull_axis(a, b, place, near, &hint);
    EXPECT_EQ(plain.gap > near, hinted.gap > near) << k;
    if (plain.gap > near) continue;
    EXPECT_EQ(plain.gap, hinted.gap) << k;
    EXPECT_EQ(plain.normal, hinted.normal) << k;
  }
}

/// Edges are left out by corners deep below their faces: of bodies of many faces most, by touches that are shallow or deep.
TEST(HullAxis, OverlapOfStonesIsTheLeastOfAllAxes) {
  klang::RandomStream random(11, 0);
  const klang::mesh::SurfaceMesh surface = convex_hull(klang::rigid::stone(1.0).parts[0].corners_m);
  std::vector<std::vector<int>> faces;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    faces.push_back({static_cast<int>(surface.triangles(t, 0)), static_cast<int>(surface.triangles(t, 1)),
                     static_cast<int>(surface.triangles(t, 2))});
  const Eigen::Matrix3Xd corners = surface.vertices_m.transpose();
  const HullFeatures stone(corners, faces);
  ASSERT_TRUE(stone.whole);
  ASSERT_EQ(stone.edges.size(), 36U);
  int n_edges = 0;
  for (int k = 0; k < 400; ++k) {
    Eigen::Isometry3d place = drawn_place(random, 0.0);
    const auto draw = [&] { return 2 * random.uniform() - 1; };
    const double depth = k % 2 == 0 ? 1e-6 : 0.3;
    place.translation() = 3 * Vector3d(draw(), draw(), draw()).normalized();
    double right = gap_by_all_axes(stone, stone, place);
    while (right > 0) {  // nearer by at most what parts them along their axis
      place.translation() -= (right + depth) * place.translation().normalized();
      right = gap_by_all_axes(stone, stone, place);
    }
    const HullAxis axis = hull_axis(stone, stone, place);
    EXPECT_LE(std::abs(axis.gap - right), 1e-12) << k;
    EXPECT_LE(std::abs(gap_along(stone, stone, place, axis.normal) - axis.gap), 1e-12) << k;
    n_edges += axis.edges ? 1 : 0;
  }
  EXPECT_GT(n_edges, 40);
}

TEST(HullAxis, AFaceOnALineIsNone) {
  // A corner in the middle of a side, and the face of no area that closes it.
  Eigen::Matrix3Xd corners(3, 9);
  corners << box_corners(1, 0.7, 0.4), Vector3d(0, -0.35, -0.2);
  std::vector<std::vector<int>> faces = box_faces();
  ASSERT_EQ(faces[2], (std::vector<int>{0, 1, 5, 4}));
  faces[2] = {0, 8, 1, 5, 4};
  faces.push_back({0, 1, 8});
  const HullFeatures plain = box(1, 0.7, 0.4), other = box(0.5, 0.9, 0.6), split(corners, faces);
  EXPECT_EQ(split.normals.cols(), 6);
  EXPECT_EQ(split.edges.size(), 13U);
  EXPECT_EQ(split.plates.size(), 6U);
  EXPECT_TRUE(split.whole);
  klang::RandomStream random(3, 0);
  for (int k = 0; k < 500; ++k) {
    const Eigen::Isometry3d place = drawn_place(random, 0.6);
    const double right = hull_axis(plain, other, place).gap, gap = hull_axis(split, other, place).gap;
    EXPECT_EQ(gap > 0, right > 0) << k;
    if (right <= 0) {
      EXPECT_LE(std::abs(gap - right), 1e-12) << k;
    }
  }
}

TEST(HullAxis, CornersOnALineHaveNoFacesAndNoEdges) {
  Eigen::Matrix3Xd corners(3, 3);
  corners << 0, 1, 2, 0, 2, 4, 0, 0, 0;
  const HullFeatures line(corners, {{0, 1, 2}, {2, 1, 0}});
  EXPECT_EQ(line.normals.cols(), 0);
  EXPECT_TRUE(line.edges.empty());
  EXPECT_FALSE(line.whole);
}

TEST(HullAxis, WithoutAFaceEveryEdgeIsTriedStill) {
  const HullFeatures plain = box(1, 0.7, 0.4), other = box(0.5, 0.9, 0.6);
  for (std::size_t missing = 0; missing < 6; ++missing) {
    std::vector<std::vector<int>> faces = box_faces();
    faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(missing));
    const HullFeatures open(plain.corners, faces);
    EXPECT_FALSE(open.whole);
    EXPECT_EQ(open.edges.size(), 12U);
    klang::RandomStream random(5, missing);
    int n_edges = 0;
    for (int k = 0; k < 2000; ++k) {
      const Eigen::Isometry3d place = drawn_place(random, 0.9);
      const HullAxis right = hull_axis(plain, other, place);
      if (!right.edges) continue;
      ++n_edges;
      const HullAxis axis = hull_axis(open, other, place);
      EXPECT_EQ(axis.gap > 0, right.gap > 0) << missing << " " << k;
      if (right.gap <= 0) {
        EXPECT_LE(std::abs(axis.gap - right.gap), 1e-12) << missing << " " << k;
      }
    }
    EXPECT_GT(n_edges, 20);
  }
}

TEST(HullAxis, PointsFromTheSecondToTheFirst) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.translation() = Vector3d(0.9, 0, 0);
  const HullAxis axis = hull_axis(box(1, 1, 1), box(1, 1, 1), place);
  EXPECT_LE((axis.normal + Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LE(std::abs(axis.gap + 0.1), 1e-12);
}

}  // namespace
