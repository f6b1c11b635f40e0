#include "core/physics/tally/tap_count.hpp"

#include <gtest/gtest.h>

TEST(TapCount, TapsBeforeTheStartAreLeftOut) { EXPECT_EQ(klang::tally::count_taps({0.1, 0.2, 0.3}, 0.2), 2); }
