// Where hulls touch along their axis of least overlap.
#include "core/physics/rigid/detail/hull_touches.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"
#include "tests/core/physics/rigid/box_features.hpp"

namespace {

using namespace klang::rigid::detail;
using Eigen::Vector3d;

double outside(const HullFeatures& hull, const Vector3d& point) {
  return (hull.normals.transpose() * point - hull.offsets).maxCoeff();
}

double deepest(const std::vector<HullTouch>& touches) {
  double gap = HUGE_VAL;
  for (const HullTouch& touch : touches) gap = std::min(gap, touch.gap);
  return gap;
}

TEST(HullTouches, LieOnBothHullsAndTheDeepestIsAsDeepAsTheAxisSays) {
  klang::RandomStream random(11, 0);
  const HullFeatures a = box(1, 0.7, 0.4), b = box(0.5, 0.9, 0.6);
  int n_edges = 0, n_touches = 0;
  for (int k = 0; k < 3000; ++k) {
    const auto draw = [&] { return 2 * random.uniform() - 1; };
    Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
    place.linear() = Eigen::Quaterniond(draw(), draw(), draw(), draw()).normalized().toRotationMatrix();
    place.translation() = 0.9 * Vector3d(draw(), draw(), draw());
    const HullAxis axis = hull_axis(a, b, place);
    if (axis.gap > 0) continue;
    n_edges += axis.edges ? 1 : 0;
    const std::vector<HullTouch> touches = hull_touches(a, b, place, axis, 1e-3);
    ASSERT_FALSE(touches.empty());
    EXPECT_LE(std::abs(deepest(touches) - axis.gap), 1e-12) << k;
    for (const HullTouch& touch : touches) {
      ++n_touches;
      EXPECT_GE(touch.gap, axis.gap - 1e-12) << k;
      EXPECT_LE(touch.gap, 1e-3) << k;
      EXPECT_LE(std::abs(outside(b, place.inverse() * touch.on_b)), 1e-9) << k;
      EXPECT_LE(std::abs(outside(a, touch.on_b + touch.gap * axis.normal)), 1e-9) << k;
    }
    const HullAxis back = hull_axis(b, a, place.inverse());
    EXPECT_LE(std::abs(back.gap - axis.gap), 1e-12) << k;
    EXPECT_LE(std::abs(deepest(hull_touches(b, a, place.inverse(), back, 1e-3)) - axis.gap), 1e-12) << k;
  }
  EXPECT_GT(n_edges, 50);
  EXPECT_GT(n_touches, 1000);
}

TEST(HullTouches, AFaceOnAFaceTouchesAtTheCornersOfWhatTheyShare) {
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();
  place.translation() = Vector3d(0.3, 0.2, -0.99);
  const HullFeatures a = box(1, 1, 1), b = box(1, 1, 1);
  const HullAxis axis = hull_axis(a, b, place);
  const std::vector<HullTouch> touches = hull_touches(a, b, place, axis, 0.0);
  ASSERT_EQ(touches.size(), 4U);
  for (const double x : {-0.2, 0.5}) {
    for (const double y : {-0.3, 0.5}) {
      double nearest = HUGE_VAL;
      for (const HullTouch& touch : touches)
        nearest = std::min(nearest, (touch.on_b - Vector3d(x, y, -0.49)).norm() + std::abs(touch.gap + 0.01));
      EXPECT_LE(nearest, 1e-12) << x << " " << y;
    }
  }
}

TEST(HullTouches, ATipInAFaceIsAsDeepAsItReaches) {
  const HullFeatures a = box(1, 1, 1), b = box(3, 3, 1);
  for (const double tilt : {0.3, 0.9}) {
    Eigen::Isometry3d place_a = Eigen::Isometry3d::Identity();
    place_a.linear() =
        (Eigen::AngleAxisd(tilt, Vector3d::UnitX()) * Eigen::AngleAxisd(0.4, Vector3d::UnitY())).matrix();
    const double lowest = (place_a.linear() * a.corners).row(2).minCoeff();
    place_a.translation() = Vector3d(0.1, 0.2, 0.5 - 0.03 - lowest);
    for (const bool swapped : {false, true}) {
      const Eigen::Isometry3d b_to_a = place_a.inverse();
      const HullAxis axis = swapped ? hull_axis(b, a, place_a) : hull_axis(a, b, b_to_a);
      const auto touches = swapped ? hull_touches(b, a, place_a, axis, 0.0) : hull_touches(a, b, b_to_a, axis, 0.0);
      EXPECT_LE(std::abs(deepest(touches) + 0.03), 1e-12) << tilt << swapped;
    }
  }
}

}  // namespace
