// What people type, and what they get: words that are nearly right, help, global options anywhere.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

namespace klang::test {
namespace {

const std::string kSmallTube = "modes --shape tube --dims length_m=0.1,outer_radius_m=0.0125,wall_m=0.002 --count 1 ";

TEST(DidYouMean, NearCommandsOptionsPresetsAndDimensionsAreNamed) {
  const Scratch scratch;
  expect_refused(scratch, "analize x.wav", {"did you mean analyze"});
  expect_refused(scratch, "bubble inof", {"did you mean info"});
  expect_refused(scratch, "help modse", {"did you mean modes"});
  expect_refused(scratch, "fit x.toml --outptu d", {"--outptu", "did you mean --output"});
  expect_refused(scratch, "analyze x.wav --min-snr-bd=3", {"did you mean --min-snr-db"});
  expect_refused(scratch, kSmallTube + "--material alumium", {"did you mean aluminium"});
  expect_refused(scratch, "modes --shape tueb --dims length_m=1", {"did you mean tube"});
  expect_refused(scratch, "modes --shape rod --dims lenght_m=1,radius_m=0.01", {"did you mean length_m"});
}

TEST(DidYouMean, NearKeysOfSpecimenAndSceneFilesAreNamed) {
  const Scratch scratch;
  scratch.write("s.toml", "[material]\npresett = \"steel\"\n[[specimen]]\nname = \"a\"\n");
  expect_refused(scratch, "fit s.toml -o out", {"s.toml:2", "presett", "did you mean preset"});
  scratch.write("scene.toml", "[wrold]\n");
  expect_refused(scratch, "scene check scene.toml", {"scene.toml", "did you mean world"});
}

TEST(DidYouMean, NothingIsSuggestedWhereNothingIsNear) {
  const Scratch scratch;
  for (const char* words : {"qqqqqq", "modes --qqqqqq", "modes --shape qqqqqq --dims length_m=1"}) {
    const RunResult run = run_klang(words, scratch.path());
    EXPECT_EQ(run.exit_code, 2) << words;
    EXPECT_EQ(run.err.find("did you mean"), std::string::npos) << run.err;
  }
}

TEST(Help, ProgramAloneAndHelpXAreTheHelpOption) {
  const Scratch scratch;
  const auto out = [&](const std::string& words) {
    const RunResult run = run_klang(words, scratch.path());
    EXPECT_EQ(run.exit_code, 0) << words << run.err;
    return run.out;
  };
  EXPECT_EQ(out(""), out("--help"));
  EXPECT_EQ(out("help"), out("--help"));
  EXPECT_EQ(out("help modes"), out("modes --help"));
  EXPECT_EQ(out("help bubble info"), out("bubble info --help"));
  EXPECT_NE(out("help modes"), out("--help"));
  EXPECT_EQ(out("modes --version"), out("--version"));
}

TEST(GlobalOptions, AreTakenBeforeTheCommandAndWithinAGroup) {
  const Scratch scratch;
  const RunResult before = run_klang("--json a.json --threads 1 --quiet " + kSmallTube, scratch.path());
  ASSERT_EQ(before.exit_code, 0) << before.err;
  EXPECT_EQ(before.out, "");
  EXPECT_EQ(read_json(scratch.path() / "a.json")["kind"], "modes");
  const RunResult within = run_klang("bubble --json - info --radius-m 0.001", scratch.path());
  ASSERT_EQ(within.exit_code, 0) << within.err;
  EXPECT_EQ(nlohmann::json::parse(within.out)["kind"], "bubble_info");
}

}  // namespace
}  // namespace klang::test
