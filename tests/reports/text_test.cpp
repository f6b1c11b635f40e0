#include "reports/kit/text.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace klang::reports::detail {
namespace {

TEST(ReportText, EscapesMarkupAndRepairsBadUtf8) {
  EXPECT_EQ(escaped("<b a=\"1\" c='2'>&"), "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;");
  EXPECT_EQ(escaped("Glöckchen µ"), "Glöckchen µ");
  EXPECT_EQ(escaped("a\xff\xc3"), "a\ufffd\ufffd");
  EXPECT_EQ(escaped("\xed\xa0\x80"), "\ufffd\ufffd\ufffd") << "a surrogate is not UTF-8";
  EXPECT_EQ(escaped(std::string_view("a\0\x1b[31mb", 8)), "a[31mb");
}

TEST(ReportText, StandardDeviationIsShownWithTwoDigits) {
  EXPECT_EQ(decimals_for(0.052), 3);
  EXPECT_EQ(decimals_for(1.2), 1);
  EXPECT_EQ(decimals_for(0.0996), 2) << "0.0996 rounds to 0.10, not to 0.100";
  EXPECT_EQ(decimals_for(123.0), 0);
  EXPECT_EQ(hertz(587.88312, 0.0123), "587.883\u202fHz");
}

TEST(ReportText, ScalesUnitsOnlyForTheReader) {
  const ShownEstimate modulus = shown("youngs_modulus_pa", 6.8404e10, 5.2e7, std::array<double, 2>{6.830e10, 6.851e10});
  EXPECT_EQ(modulus.value_with_std(), "68.404 ± 0.052\u202fGPa");
  EXPECT_EQ(modulus.interval(), "68.300 to 68.510\u202fGPa");
  EXPECT_EQ(shown("rayleigh_stiffness_s", 2.003e-8, 3.1e-11, {}).value_with_std(), "20.030 ± 0.031\u202fns");
  const ShownEstimate length = shown("D3.length_m", 0.50512, 0.00021, {});
  EXPECT_EQ(length.value_with_std(), "505.12 ± 0.21\u202fmm");
  EXPECT_EQ(length.quantity.words, "length of D3");
  EXPECT_EQ(shown("poissons_ratio", 0.3298, 0.0071, {}).value_with_std(), "0.3298 ± 0.0071");
  EXPECT_EQ(shown("rayleigh_mass_per_s", 1.0952, {}, {}).value_with_std(), "1.0952\u202f1/s");
  EXPECT_EQ(shown("poissons_ratio", measured(std::numeric_limits<double>::quiet_NaN()), {}, {}).value, "—");
}

TEST(ReportText, NoNumberComesOutAsNanOrMinusZero) {
  for (const double value : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                             -std::numeric_limits<double>::infinity()}) {
    EXPECT_EQ(fixed(value, 2), "—");
    EXPECT_EQ(rounded(value), "—");
    EXPECT_EQ(coordinate(value), "0");
  }
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(coordinate(-0.001), "0");
  EXPECT_EQ(rounded(-2.5e-9, 2), "\u22122.5\u202f×\u202f10⁻⁹");
  EXPECT_EQ(fixed(1e300, 2).size(), 304u);
}

TEST(ReportText, FileStemsStayInsideTheFolder) {
  EXPECT_EQ(file_stem("../../etc/passwd"), "_.._etc_passwd");
  EXPECT_EQ(file_stem(""), "specimen");
  EXPECT_EQ(file_stem("..."), "specimen");
  EXPECT_EQ(file_stem("D3 a/b"), "D3_a_b");
}

}  // namespace
}  // namespace klang::reports::detail
