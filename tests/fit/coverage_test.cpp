// Whether stated intervals hold the truth as often as they say, from sounds of tubes that a Ritz series made.
#include <gtest/gtest.h>

#include "tests/fit/coverage.hpp"

namespace klang::fit::test {
namespace {

// Half a second: with longer sounds the noise falls below 1e-7 of frequency, where the series that makes the truth ends.
const char* const kRecipe = R"(
name = "two chimes"
[material]
youngs_modulus_pa = 68.9e9
poissons_ratio = 0.33
density_kg_m3 = 2700.0
[damping]
model = "rayleigh"
rayleigh_stiffness_s = 1e-7
rayleigh_mass_per_s = 1.5
[sound]
sample_rate_hz = 32000
duration_s = 0.5
peak = 0.5
highest_hz = 9000
[noise]
snr_db = 40
[fit]
parameters = ["lame_lambda_pa", "lame_mu_pa"]
[[specimen]]
name = "D5"
shape = { kind = "tube", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }
strike = [{ time_s = 0.1, at = [1.0, 0.0, 0.93], impulse_n_s = [-0.02, 0.0, 0.0], contact_s = 2e-5 }]
pickup = [{ at = [0.7071067811865476, 0.7071067811865476, -0.97], direction = [1.0, 1.0, 0.0] }]
[[specimen]]
name = "D6"
shape = { kind = "tube", length_m = 0.353, outer_radius_m = 0.0125, wall_m = 0.001 }
strike = [{ time_s = 0.1, at = [1.0, 0.0, 0.93], impulse_n_s = [-0.02, 0.0, 0.0], contact_s = 2e-5 }]
pickup = [{ at = [0.7071067811865476, 0.7071067811865476, -0.97], direction = [1.0, 1.0, 0.0] }]
)";

TEST(Coverage, NinetyFivePercentIntervalsOfChimesHoldTheTruthInNinetyToNinetyNineOfAHundredSounds) {
  const Coverage coverage = interval_coverage(kRecipe, 100, 1000, 11000.0);
  ASSERT_EQ(coverage.held.size(), 5U);
  for (const auto& [name, n_held] : coverage.held) {
    RecordProperty(name, n_held);
    EXPECT_GE(n_held, 90) << name;
    EXPECT_LE(n_held, 99) << name;
  }
}

}  // namespace
}  // namespace klang::fit::test
