#include "core/physics/entrainment/bubble_path.hpp"

#include <gtest/gtest.h>

#include "core/physics/bubble/rise_formulas.hpp"
#include "tests/core/physics/entrainment/analytic_frames.hpp"

namespace klang::entrainment {
namespace {

using bubble::BubbleMedium;
using Eigen::Vector3d;
using test::PoolFrames;

BubbleMedium water_20() {
  BubbleMedium medium;
  medium.liquid_density_kg_m3 = 998.2;
  medium.liquid_viscosity_pa_s = 1.002e-3;
  medium.surface_tension_n_m = 0.0728;
  return medium;
}

// Tomiyama 1998 in water of 20 C: clean, slightly and fully contaminated, and the paper's text; correlations solved to 1e-12 outside this
// project (terminal_velocity_m_s).
struct Row {
  double radius_m, clean, contaminated, dirty, paper;
};
constexpr Row kTerminal[] = {
    {1e-4, 0.02283667041573398, 0.01623574924334531, 0.01623574924334531, 0.05714953126722312},
    {2.5e-4, 0.07326604825473332, 0.05510865839639709, 0.05510865839639709, 0.09036134300771698},
    {5e-4, 0.2711402195608783, 0.1807601463739188, 0.11223371098835253, 0.12779023679576063},
    {7.5e-4, 0.3234043240417832, 0.3234043240417832, 0.16223435292085336, 0.1565104371295245},
    {1e-3, 0.28762733366202375, 0.28762733366202375, 0.20804447833985595, 0.18072268601543395},
    {1.5e-3, 0.2516310017131733, 0.2516310017131733, 0.2516310017131733, 0.22133918284151521},
    {2e-3, 0.23677426315595934, 0.23677426315595934, 0.23677426315595934, 0.25558047359152125},
    {5e-3, 0.2521453729902985, 0.2521453729902985, 0.2521453729902985, 0.404108211006861},
    {1e-2, 0.3244613926981652, 0.3244613926981652, 0.3244613926981652, 0.5714953126722313}};

TEST(BubbleRise, TerminalSpeedsAreTomiyamasWithin1Percent) {
  for (const Row& row : kTerminal) {
    const std::pair<Drag, double> kinds[] = {{Drag::kClean, row.clean},
                                             {Drag::kContaminated, row.contaminated},
                                             {Drag::kDirty, row.dirty},
                                             {Drag::kPaper, row.paper}};
    for (const auto& [drag, speed] : kinds)
      EXPECT_LE(std::abs(terminal_speed_m_s({drag, water_20()}, row.radius_m) / speed - 1.0), 0.01)
          << row.radius_m << " " << to_text(drag);
  }
}

TEST(BubbleRise, PathReachesTheTerminalSpeedOfEveryRadius) {
  const PoolFrames pool = PoolFrames::at_rest(0.8, 1.0);
  for (const Row& row : kTerminal)
    for (const Drag drag : {Drag::kContaminated, Drag::kPaper}) {
      const BubblePath path =
          bubble_path(pool, {row.radius_m, 0.0, {0.5, 0.5, 0.05}, Vector3d::Zero()}, {drag, water_20()});
      ASSERT_EQ(path.end, EndKind::kEnd);
      const std::size_t n = path.time_s.size();
      const double speed =
          (path.position_m[n - 1].z() - path.position_m[n - 201].z()) / (path.time_s[n - 1] - path.time_s[n - 201]);
      const double exact = drag == Drag::kPaper ? row.paper : row.contaminated;
      EXPECT_LE(std::abs(speed / exact - 1.0), 0.01) << row.radius_m << " " << to_text(drag);
    }
}

TEST(BubbleRise, PaperDragFollowsTheClosedFormFromRest) {
  const BubbleMedium medium;
  const PoolFrames pool = PoolFrames::at_rest(0.4);
  const double radius = 2e-3;
  const BubblePath path = bubble_path(pool, {radius, 0.0, {0.5, 0.5, 0.1}, Vector3d::Zero()}, {Drag::kPaper, medium});
  const auto law = bubble::rise_law(medium, radius, 0.2);
  for (std::size_t i = 20; i < path.time_s.size(); i += 40) {
    const double risen = path.position_m[i].z() - 0.1;
    EXPECT_LE(std::abs(risen / bubble::risen_m(law, 0.0, path.time_s[i]) - 1.0), 0.01) << path.time_s[i];
  }
}

TEST(BubbleRise, EndsWhereItTouchesTheSurface) {
  const PoolFrames pool = PoolFrames::at_rest(1.0);
  const BubblePath path =
      bubble_path(pool, {2e-3, 0.1, {0.5, 0.5, 0.45}, Vector3d::Zero()}, {Drag::kContaminated, BubbleMedium()});
  EXPECT_EQ(path.end, EndKind::kSurface);
  EXPECT_EQ(path.birth_s(), 0.1);
  EXPECT_GE(path.phi_m.back(), -2e-3);
  EXPECT_LE(path.phi_m[path.phi_m.size() - 2], -2e-3);
  EXPECT_LE(std::abs(path.end_s() - (0.1 + 0.048 / 0.237)), 0.03);
}

TEST(BubbleRise, OneBornAtTheSurfaceEndsAtOnce) {
  const BubblePath path = bubble_path(PoolFrames::at_rest(0.1), {2e-3, 0.02, {0.5, 0.5, 0.499}, Vector3d::Zero()},
                                      {Drag::kContaminated, BubbleMedium()});
  EXPECT_EQ(path.end, EndKind::kSurface);
  EXPECT_EQ(path.time_s, std::vector<double>{0.02});
}

TEST(BubbleRise, UniformFlowCarriesItToTheOutlet) {
  PoolFrames stream(
      10.0, 0.01, 0.004, 251, [](double) { return 10.0; },
      [](double, const Vector3d&) { return Vector3d(0.5, 0.0, 0.0); });
  stream.outlet_ = 0.4;
  const BubblePath path =
      bubble_path(stream, {1e-3, 0.0, {0.2, 1.0, 1.0}, {0.5, 0.0, 0.0}}, {Drag::kContaminated, BubbleMedium()});
  EXPECT_EQ(path.end, EndKind::kOutlet);
  EXPECT_LE(std::abs(path.end_s() - 0.4), 0.0021);  // 0.2 m at 0.5 m/s
  for (std::size_t i = 0; i < path.time_s.size(); i += 20)
    EXPECT_LE(std::abs(path.position_m[i].x() - (0.2 + 0.5 * path.time_s[i])), 1e-9);
}

TEST(BubbleRise, IsNeutralInFreeFall) {
  const double g = bubble::kGravityMS2;
  const PoolFrames falling(
      1.0, 0.01, 0.004, 101, [=](double t) { return 5.0 - 0.5 * g * t * t; },
      [=](double t, const Vector3d&) { return Vector3d(0.0, 0.0, -g * t); });
  const BubblePath path =
      bubble_path(falling, {1e-3, 0.0, {0.5, 0.5, 4.9}, Vector3d::Zero()}, {Drag::kContaminated, BubbleMedium()});
  EXPECT_EQ(path.end, EndKind::kEnd);
  EXPECT_LE(std::abs(path.phi_m.back() + 0.1), 1e-3);
}

}  // namespace
}  // namespace klang::entrainment
