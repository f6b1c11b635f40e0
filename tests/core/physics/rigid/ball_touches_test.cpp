#include "core/physics/rigid/detail/ball_touches.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/random.hpp"
#include "core/physics/rigid/detail/box_pairs.hpp"
#include "tests/core/physics/rigid/box_features.hpp"

using namespace klang::rigid::detail;
using Eigen::Vector3d;

// Of a box in closed form: outside by clamping, inside by the nearest face.
TEST(BallTouches, NearestPlaceOfABoxIsTheClosedForm) {
  klang::RandomStream random(3, 0);
  const Vector3d half(0.5, 0.3, 0.2);
  const HullFeatures hull = box(1.0, 0.6, 0.4);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d point(3 * random.uniform() - 1.5, 2 * random.uniform() - 1, 1.2 * random.uniform() - 0.6);
    const NearestPlace nearest = nearest_place(hull, point);
    const Vector3d clamped = point.cwiseMax(-half).cwiseMin(half), way = point - clamped;
    if (way.norm() > 0) {
      EXPECT_NEAR(nearest.distance, way.norm(), 1e-15);
      EXPECT_LE((nearest.place - clamped).norm(), 1e-15);
      EXPECT_LE((nearest.outward - way.normalized()).norm(), 1e-12);
    } else {
      EXPECT_NEAR(nearest.distance, (point.cwiseAbs() - half).maxCoeff(), 1e-15);
      EXPECT_NEAR((nearest.place - point).norm(), -nearest.distance, 1e-15);
    }
  }
}

TEST(BoxPairs, AreThoseOfATryOfAll) {
  klang::RandomStream random(4, 0);
  BoxPairs finder;
  std::vector<PartBox> boxes(60);
  for (int k = 0; k < 50; ++k) {  // as they move on
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const Vector3d low(random.uniform(), random.uniform(), 0.3 * random.uniform());
      boxes[i] = {low, low + 0.3 * Vector3d(random.uniform(), random.uniform(), random.uniform()),
                  static_cast<int>(i / 2), i % 3 != 0};
    }
    std::vector<std::array<int, 2>> expected;
    for (int i = 0; i < 60; ++i)
      for (int j = i + 1; j < 60; ++j) {
        const PartBox &a = boxes[static_cast<std::size_t>(i)], &b = boxes[static_cast<std::size_t>(j)];
        if (a.body != b.body && (a.moves || b.moves) && meet(a, b)) expected.push_back({i, j});
      }
    ASSERT_GT(expected.size(), 10U);
    EXPECT_EQ(finder.find(boxes), expected) << k;
  }
}
