#include "core/physics/events/event_log.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/events/sample_log.hpp"
#include "tests/places.hpp"

namespace klang::events {
namespace {

TEST(Motion, MovesStraightAndTurnsEvenlyBetweenItsPosesAndRestsOutside) {
  const double half = 0.25 * kPi;
  const Motion motion({{0, 1.0, {0, 0, 0}, {1, 0, 0, 0}}, {0, 3.0, {4, 0, 2}, {std::cos(half), 0, 0, std::sin(half)}}});
  const Pose middle = motion.at(2.0);
  EXPECT_LE((middle.position_m - Eigen::Vector3d(2, 0, 1)).norm(), 1e-15);
  const double c = std::sqrt(0.5);  // turned by 45 degrees about z
  EXPECT_LE((middle.to_world({1, 0, 0}) - Eigen::Vector3d(2 + c, c, 1)).norm(), 1e-14);
  EXPECT_LE((middle.to_body(middle.to_world({0.3, -0.2, 0.7})) - Eigen::Vector3d(0.3, -0.2, 0.7)).norm(), 1e-14);
  EXPECT_EQ(motion.at(0.0).position_m, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(motion.at(9.0).position_m, Eigen::Vector3d(4, 0, 2));
  EXPECT_EQ(Motion().at(5.0).to_world({1, 2, 3}), Eigen::Vector3d(1, 2, 3));
}

TEST(EventLog, FindsWhatBelongsToABodyAndABubble) {
  const EventLog log = sample_log();
  EXPECT_NO_THROW(log.validate());
  EXPECT_EQ(log.pieces_of(0), (std::vector<int>{1, 2}));
  EXPECT_EQ(log.pieces_of(1), std::vector<int>{});
  EXPECT_TRUE(log.motion_of(0).moves());
  EXPECT_FALSE(log.motion_of(1).moves());
  ASSERT_EQ(log.bubble_paths().size(), 2u);
  EXPECT_EQ(log.bubble_paths()[0].size(), 0u);
  EXPECT_EQ(log.bubble_paths()[1].size(), 2u);
}

TEST(EventLog, SortsByTimeAndKeepsTheOrderOfEquals) {
  EventLog log = sample_log();
  log.impulses = {log.impulses[1], log.impulses[0], log.impulses[1]};
  log.impulses[2].other = 1;
  log.sort();
  EXPECT_EQ(log.impulses[0].kind, ImpulseKind::kImpact);
  EXPECT_EQ(log.impulses[1].other, -1);
  EXPECT_EQ(log.impulses[2].other, 1);
}

TEST(EventLog, RefusesRowsThatCannotBeAndNamesThem) {
  const struct {
    const char* words;
    std::function<void(EventLog&)> spoil;
  } cases[] = {
      {"impulses[1]: time_s", [](EventLog& log) { log.impulses[1].time_s = std::nan(""); }},
      {"impulses[0]: duration_s", [](EventLog& log) { log.impulses[0].duration_s = -1e-9; }},
      {"impulses[0]: impulse_n_s",
       [](EventLog& log) { log.impulses[0].impulse_n_s.y() = std::numeric_limits<double>::infinity(); }},
      {"impulses[1]: names a row of bodies", [](EventLog& log) { log.impulses[1].body = 3; }},
      {"impulses[0]: names a row of bodies", [](EventLog& log) { log.impulses[0].other = 7; }},
      {"bodies[1]: names a row of bodies before it", [](EventLog& log) { log.bodies[1].parent = 1; }},
      {"poses[0]: orientation_wxyz", [](EventLog& log) { log.poses[0].orientation_wxyz *= 0.9; }},
      {"poses[1]: time_s does not rise", [](EventLog& log) { log.poses[1].time_s = log.poses[0].time_s; }},
      {"fractures[0]: the body has no pieces", [](EventLog& log) { log.fractures[0].body = 2; }},
      {"fractures[1]: the body has broken", [](EventLog& log) { log.fractures.push_back(log.fractures[0]); }},
      {"bubbles[0]: radius_m", [](EventLog& log) { log.bubbles[0].radius_m = 0.0; }},
      {"bubble_points[0]: names a row of bubbles", [](EventLog& log) { log.bubble_points[0].bubble = 2; }},
  };
  for (const auto& one : cases) {
    EventLog log = sample_log();
    one.spoil(log);
    try {
      log.validate();
      ADD_FAILURE() << one.words;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(one.words), std::string::npos) << error.what();
    }
  }
}

TEST(EventLog, PageHoldsTheTablesOfTheCode) {
  std::ifstream file(klang::test::source_dir() + "/docs/event-log.md");
  std::stringstream page;
  page << file.rdbuf();
  EXPECT_NE(page.str().find(event_log_markdown()), std::string::npos) << event_log_markdown();
}

}  // namespace
}  // namespace klang::events
