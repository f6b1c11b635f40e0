// The axis of least overlap of two hulls against all axes there are.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"
#include "core/physics/rigid/detail/hull_axis.hpp"

namespace {

using namespace klang::rigid::detail;
using Eigen::Vector3d;

HullFeatures box(double x, double y, double z) {
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i) corners.col(i) = 0.5 * Vector3d(i & 1 ? x : -x, i & 2 ? y : -y, i & 4 ? z : -z);
  return {corners, {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
}

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

TEST(HullAxis, OverlapIsTheLeastOfAllAxes) {
  klang::RandomStream random(7, 0);
  int n_overlap = 0, n_edges = 0;
  for (int k = 0; k < 2000; ++k) {
    const auto draw = [&] { return 2 * random.uniform() - 1; };
    const HullFeatures a = box(1, 0.7, 0.4), b = box(0.5, 0.9, 0.6);
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
    for (Eigen::Index f = 0; f < 6; ++f) {
      face = face || std::abs(std::abs(a.normals.col(f).dot(axis.normal)) - 1) < 1e-9;
      face = face || std::abs(std::abs((place.linear() * b.normals.col(f)).dot(axis.normal)) - 1) < 1e-9;
    }
    if (!face) ++n_edges;
  }
  EXPECT_GT(n_overlap, 200);
  EXPECT_GT(n_edges, 20);
}

TEST(HullAxis, PointsFromTheSecondToTheFirst) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.translation() = Vector3d(0.9, 0, 0);
  const HullAxis axis = hull_axis(box(1, 1, 1), box(1, 1, 1), place);
  EXPECT_LE((axis.normal + Vector3d::UnitX()).norm(), 1e-12);
  EXPECT_LE(std::abs(axis.gap + 0.1), 1e-12);
}

}  // namespace
