#include "core/physics/entrainment/tracked_bubbles.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::entrainment {
namespace {

const std::string kText =
    "Bub 1 0.002\n  Start: N 0.01\n  0.01 1640 0.1 0.05 -0.02 0 0.03\n  0.02 1700.25 0.1 0.051 -0.02 0 0.029\n  End: S "
    "0.02 2 3\n"
    "Bub 2 0.0015\n  Start: S 0.02 1\n  0.02 2200 0.1 0.07 -0.02\n  End: C 0.02\n";

TEST(TrackedBubbles, TurnTheirAxesAndKeepTheirFamilies) {
  const TrackedBubbles read = parse_tracked_bubbles(kText, "t");
  ASSERT_EQ(read.paths.size(), 2U);
  const BubblePath& first = read.paths[0];
  EXPECT_EQ(first.position_m[0], Eigen::Vector3d(0.1, 0.02, 0.05));  // file (x, y, z) = our (x, z, -y)
  EXPECT_EQ(first.phi_m[1], -0.029);
  EXPECT_EQ(first.frequency_hz[1], 1700.25);
  EXPECT_EQ(first.end, EndKind::kSplit);
  EXPECT_EQ(first.children, (std::vector<std::int64_t>{2, 3}));
  EXPECT_EQ(read.paths[1].start, StartKind::kSplit);
  EXPECT_EQ(read.paths[1].parents, std::vector<std::int64_t>{1});
  EXPECT_TRUE(std::isnan(read.paths[1].phi_m[0]));
}

TEST(TrackedBubbles, RoundTripGivesTheSameBytesPlainAndPacked) {
  EXPECT_EQ(tracked_bubbles_text(parse_tracked_bubbles(kText, "t").paths), kText);
  const auto folder = std::filesystem::temp_directory_path() / ("klang-tracked-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const std::vector<BubblePath> paths = parse_tracked_bubbles(kText, "t").paths;
  write_tracked_bubbles(folder / "a.txt.xz", paths);
  EXPECT_EQ(read_file(folder / "a.txt.xz").substr(1, 4), "7zXZ");
  write_tracked_bubbles(folder / "b.txt.xz", read_tracked_bubbles(folder / "a.txt.xz").paths);
  EXPECT_EQ(read_file(folder / "a.txt.xz"), read_file(folder / "b.txt.xz"));
  write_file(folder / "cut.xz", read_file(folder / "a.txt.xz").substr(0, 60));
  EXPECT_THROW(read_tracked_bubbles(folder / "cut.xz"), InputError);
  std::filesystem::remove_all(folder);
}

TEST(TrackedBubbles, WithoutFrequencyAreLeftOutAndCounted) {
  const TrackedBubbles read = parse_tracked_bubbles(
      "Bub 1 0.002\n Start: N 0\n 0 nan 0 0 0\n 0.1 1700 0 0 0\n 0.2 -1 0 0 0\n End: C 0.2\n"
      "Bub 2 0.002\n Start: N 0\n 0 0 0 0 0\n End: C 0\n",
      "t");
  ASSERT_EQ(read.paths.size(), 1U);
  EXPECT_EQ(read.paths[0].time_s, std::vector<double>{0.1});
  EXPECT_EQ(read.paths[0].birth_s(), 0.0);
  EXPECT_EQ(read.paths[0].end_s(), 0.2);
  EXPECT_EQ(read.n_without_frequency, 3U);
  EXPECT_EQ(read.n_left_out, 1U);
}

TEST(TrackedBubbles, AreBornAndEndWhenTheFileSaysSoAndNotWithTheirSamples) {
  const std::string text =
      "Bub 1 0.002\n  Start: N 0.01\n  0.0125 1640 0.1 0.05 -0.02\n  End: M 0.03 3\n"
      "Bub 2 0.002\n  Start: N 0.02\n  0.02 1640 0.1 0.05 -0.02\n  0.028 1640 0.1 0.05 -0.02\n  End: M 0.03 3\n"
      "Bub 3 0.0025\n  Start: M 0.03 1 2\n  0.03 1300 0.1 0.05 -0.02\n  End: C 0.05\n";
  const TrackedBubbles read = parse_tracked_bubbles(text, "t");
  ASSERT_EQ(read.paths.size(), 3U);
  EXPECT_EQ(read.paths[0].birth_s(), 0.01);
  EXPECT_EQ(read.paths[0].end_s(), 0.03);
  EXPECT_EQ(read.paths[1].end_s(), read.paths[2].birth_s()) << "a pair ends when its child begins";
  EXPECT_EQ(read.paths[2].end_s(), 0.05);
  EXPECT_EQ(read.n_outside, 0U);
  EXPECT_EQ(tracked_bubbles_text(read.paths), text);
  const TrackedBubbles outside =
      parse_tracked_bubbles("Bub 1 0.002\n Start: N 0.1\n 0 900 0 0 0\n 0.3 900 0 0 0\n End: C 0.2\n", "t");
  EXPECT_EQ(outside.n_outside, 1U);
  EXPECT_EQ(outside.paths[0].birth_s(), 0.0);
  EXPECT_EQ(outside.paths[0].end_s(), 0.3);
}

TEST(TrackedBubbles, BadTextIsNamedWithItsLine) {
  const auto refused = [](const std::string& text, const std::string& word) {
    try {
      parse_tracked_bubbles(text, "t.txt");
      ADD_FAILURE() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused("", "no bubble");
  refused("0 1 2 3 4\n", "line 1");
  refused("Bub 1\n", "line 1");
  refused("Bub 1 -2\n", "radius");
  refused("Bub 1 0.001\n Start: X 0\n", "N, M or S");
  refused("Bub 1 0.001\n Start: N 0\n 0 1000 0 0\n", "line 3");
  refused("Bub 1 0.001\n Start: N 0\n 0 1000 0 0 0\n 0 1000 0 0 0\n", "does not rise");
  refused("Bub 1 0.001\n Start: N 0\n 0 1000 0 0 0\n", "no End:");
  refused("Bub 1 0.001\n Start: N 0\n 0 1000 0 0 inf\n", "place");
}

}  // namespace
}  // namespace klang::entrainment
