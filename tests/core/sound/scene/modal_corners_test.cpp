// Which corners of a modal body are looked at where only the floor is near.
#include <gtest/gtest.h>

#include "tests/core/sound/scene/modal_corners.hpp"

namespace klang::scene::detail {
namespace {

TEST(ModalCorners, AllThatAreBelowTheFloorAreLookedAtAndStandWhereTheyAre) {
  std::size_t most = 0;
  int below = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    ModalBody all = test::ball_of_corners(2000, 12, seed);
    all.centre_m.z() -= 2e-4 * seed;
    ModalBody low = all;
    all.refresh();
    low.refresh_low();
    EXPECT_EQ(all.looked_at.size(), 2000u);
    EXPECT_GE(low.swell_m, all.swell_m);
    most = std::max(most, low.looked_at.size());
    for (const int i : all.looked_at) {
      const bool looked = std::binary_search(low.looked_at.begin(), low.looked_at.end(), i);
      if (all.corners_m(2, i) <= 0.0) {
        ++below;
        EXPECT_TRUE(looked);
      }
      if (looked) EXPECT_LE((all.corners_m.col(i) - low.corners_m.col(i)).norm(), 1e-15);
    }
  }
  EXPECT_GT(below, 100);
  EXPECT_LT(most, 600u);
}

}  // namespace
}  // namespace klang::scene::detail
