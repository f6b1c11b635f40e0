#include "fit/ringdown/bell.hpp"

#include <gtest/gtest.h>

namespace klang::fit {
namespace {

std::vector<Partial> partials_at(const std::vector<double>& frequencies_hz) {
  std::vector<Partial> partials;
  for (const double frequency_hz : frequencies_hz) {
    partials.emplace_back().frequency_hz = frequency_hz;
    partials.back().amplitude = 0.1;
    partials.back().decay_per_s = 1.0;
  }
  return partials;
}

TEST(Bells, PartialsOfAnIdealBellAreNamedWhateverElseRings) {
  // Relative frequencies of a tuned bell: hum 0.5, prime 1, tierce 1.2, quint 1.5, nominal 2, superquint 3, octave nominal 4.
  const Bell bell = name_bell(partials_at({220, 440, 528, 660, 880, 1100, 1320, 1760, 2200, 2640}));
  ASSERT_TRUE(bell.found());
  EXPECT_EQ(*bell.hum_hz, 220);
  EXPECT_EQ(*bell.prime_hz, 440);
  EXPECT_EQ(*bell.tierce_hz, 528);
  EXPECT_EQ(*bell.quint_hz, 660);
  EXPECT_EQ(*bell.nominal_hz, 880);
  EXPECT_EQ(*bell.strike_note_hz, 440);
  EXPECT_EQ(bell.strike_note, "A4");
}

TEST(Bells, MistunedHumAndPrimeAreNamedAndAMissingPartialIsEmpty) {
  const Bell bell = name_bell(partials_at({233, 425, 531, 880, 1325, 1790}));
  ASSERT_TRUE(bell.found());
  EXPECT_EQ(*bell.hum_hz, 233);
  EXPECT_EQ(*bell.prime_hz, 425);
  EXPECT_EQ(*bell.tierce_hz, 531);
  EXPECT_FALSE(bell.quint_hz.has_value());
  EXPECT_EQ(*bell.nominal_hz, 880);
}

TEST(Bells, TheLouderOfADoubletBearsTheName) {
  std::vector<Partial> partials = partials_at({220, 440, 527, 529, 660, 880});
  partials[3].amplitude = 0.4;
  EXPECT_EQ(*name_bell(partials).tierce_hz, 529);
}

TEST(Bells, AChimeIsNotNamedABell) {
  // Bending of a free bar: 1, 2.757, 5.404, 8.933.
  EXPECT_FALSE(name_bell(partials_at({500, 1378, 2702, 4466})).found());
  EXPECT_FALSE(name_bell({}).found());
}

}  // namespace
}  // namespace klang::fit
