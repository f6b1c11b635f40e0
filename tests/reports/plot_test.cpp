#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/random.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/kit/text.hpp"

namespace klang::reports {
namespace {

TEST(SvgPlot, LinearTicksAreRoundAndInside) {
  const auto ticks = axis_ticks({"", Scale::kLinear, -2.3, 7.9, true}, 6);
  ASSERT_GE(ticks.size(), 4u);
  ASSERT_LE(ticks.size(), 12u);
  for (const Tick& tick : ticks) {
    EXPECT_GE(tick.value, -2.3);
    EXPECT_LE(tick.value, 7.9);
    EXPECT_NEAR(tick.value, std::round(tick.value), 1e-12) << "steps of 2";
  }
}

TEST(SvgPlot, LogTicksNameTheDecades) {
  const auto ticks = axis_ticks({"", Scale::kLog, 300, 25000, true}, 9);
  std::string labels;
  for (const Tick& tick : ticks) labels += tick.label.empty() ? "" : tick.label + ";";
  EXPECT_EQ(labels, "500;1000;2000;5000;10\u202f000;20\u202f000;");
}

TEST(SvgPlot, TicksOfValuesThatHardlyDifferHaveDifferentLabels) {
  for (const double value : {2.08290289, 217.3, 9876.5, 23456.7, 9.87e5, -3.1e-7}) {
    const std::vector<Tick> ticks = axis_ticks(axis_around("", Scale::kLinear, {value, value * (1.0 + 1e-9)}), 6);
    ASSERT_GE(ticks.size(), 2U) << value;
    for (std::size_t i = 1; i < ticks.size(); ++i) EXPECT_NE(ticks[i].label, ticks[i - 1].label) << value;
  }
}

TEST(SvgPlot, AxesOfAnyDataHaveAnExtent) {
  for (const auto& values : {std::vector<double>{}, {0.0}, {5.0}, {-1.0, -1.0}, {1e-300, 1e300}, {NAN, INFINITY}}) {
    for (const Scale scale : {Scale::kLinear, Scale::kLog}) {
      const AxisSpec axis = axis_around("", scale, values);
      EXPECT_LT(axis.low, axis.high);
      EXPECT_TRUE(scale == Scale::kLinear || axis.low > 0);
      EXPECT_LE(axis_ticks(axis, 8).size(), 6000u);
    }
  }
}

TEST(SvgPlot, CurvesAreCutAtTheFrame) {
  Svg svg(200, 200, "test");
  Frame frame(svg, {50, 50, 100, 100}, {"", Scale::kLinear, 0, 1, true}, {"", Scale::kLinear, 0, 1, true});
  frame.curve({{-1, -1}, {2, 2}}, "ink");
  EXPECT_NE(svg.inline_markup().find("points=\"50,150 150,50\""), std::string::npos) << svg.inline_markup();
  Svg outside(200, 200, "test");
  Frame(outside, {50, 50, 100, 100}, {"", Scale::kLinear, 0, 1, true}, {"", Scale::kLinear, 0, 1, true})
      .curve({{0, 2}, {1, 3}}, "ink");
  EXPECT_EQ(outside.inline_markup().find("polyline"), std::string::npos);
}

TEST(SvgPlot, LabelsKeepTheirDistanceAndOrder) {
  RandomStream random(3, 1);
  for (int round = 0; round < 50; ++round) {
    std::vector<double> wanted(3 + random.below(20));
    for (double& w : wanted) w = random.uniform(0, 300);
    const auto placed = spread_labels(wanted, 12, 0, 300);
    std::vector<std::size_t> order(wanted.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return wanted[a] < wanted[b]; });
    for (std::size_t i = 0; i < order.size(); ++i) {
      EXPECT_GE(placed[order[i]], -1e-9);
      EXPECT_LE(placed[order[i]], 300 + 1e-9);
      if (i > 0) {
        EXPECT_GE(placed[order[i]] - placed[order[i - 1]], 12 - 1e-9);
      }
    }
  }
  EXPECT_EQ(spread_labels({10, 100}, 12, 0, 300), (std::vector<double>{10, 100})) << "labels that are apart stay";
}

TEST(Raster, HeatPaletteRisesEvenlyInLightness) {
  const auto& palette = detail::heat_palette();
  double before = -1;
  for (const auto& colour : palette) {
    const double luma = 0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2];
    EXPECT_GE(luma, before - 0.8);
    before = luma;
  }
  EXPECT_LT(palette[0][0] + palette[0][1] + palette[0][2], 60);
  EXPECT_GT(palette[255][0] + palette[255][1] + palette[255][2], 600);
}

TEST(Raster, Base64FollowsRfc4648) {
  EXPECT_EQ(detail::base64(""), "");
  EXPECT_EQ(detail::base64("f"), "Zg==");
  EXPECT_EQ(detail::base64("fo"), "Zm8=");
  EXPECT_EQ(detail::base64("foobar"), "Zm9vYmFy");
}

TEST(Raster, TrimmingKeepsWhatIsNotTransparent) {
  detail::RgbaImage image{8, 6, std::vector<std::uint8_t>(8 * 6 * 4, 0)};
  image.pixels[(2 * 8 + 5) * 4 + 3] = 255;
  image.pixels[(4 * 8 + 3) * 4 + 3] = 255;
  const detail::RgbaImage cut = detail::trimmed(image, 0);
  EXPECT_EQ(cut.width, 3);
  EXPECT_EQ(cut.height, 3);
  EXPECT_EQ(cut.pixels[(0 * 3 + 2) * 4 + 3], 255);
  EXPECT_EQ(cut.pixels[(2 * 3 + 0) * 4 + 3], 255);
}

}  // namespace
}  // namespace klang::reports
