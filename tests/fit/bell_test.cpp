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

TEST(Bells, WhoseStrongestRingHasNoNameIsNone) {
  std::vector<Partial> partials = partials_at({220, 440, 528, 660, 880, 1234});
  EXPECT_TRUE(name_bell(partials).found());
  partials.back().amplitude = 0.2;
  EXPECT_FALSE(name_bell(partials).found());
  partials.back().decay_per_s = 100.0;  // loud, but gone at once
  EXPECT_TRUE(name_bell(partials).found());
}

TEST(Bells, AChimeIsNotNamedABell) {
  // Bending of a free bar: 1, 2.757, 5.404, 8.933.
  EXPECT_FALSE(name_bell(partials_at({500, 1378, 2702, 4466})).found());
  EXPECT_FALSE(name_bell({}).found());
  // A tube of 505 mm up to 12 kHz: among so many some stand as a bell's do, but what is loudest rings below them.
  std::vector<Partial> tube =
      partials_at({590.2, 1581.4, 2981.4, 4728.0, 5480.0, 6657.0, 7480.0, 8785.0, 9330.0, 11029.0, 11800.0});
  EXPECT_FALSE(name_bell(tube).found());
  for (std::size_t i = 0; i < 2; ++i) tube[i].amplitude = 0.001;
  EXPECT_TRUE(name_bell(tube).found()) << "the ratios alone are a bell's";
}

}  // namespace
}  // namespace klang::fit
