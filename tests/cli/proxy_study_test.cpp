// klang proxy study: two shards and a coarse bank.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;

namespace {

const std::string kBuild =
    "proxy build --thinnest 0.5 --tolerance 0.15 --degree 8 --modes 6 --checked-modes 3 --check-shapes 5 "
    "--boundary-tolerance 0.05 --quiet -o a.bank";
const std::string kStudy =
    "proxy study a.bank --shards-only --pieces 2 --slab 0.12,0.12,0.01 --highest-hz 5500 --duration-s 0.2 --repeats 1 "
    "--thresholds 3 --quiet ";

}  // namespace

TEST(KlangProxyStudy, CurveEndsAtTheDirectMixAndDoesNotDependOnThreads) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(kBuild, scratch.path()).exit_code, 0);
  for (const std::string threads : {"1", "2"}) {
    const auto run = run_klang(kStudy + "-o out" + threads + " --threads " + threads, scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  const nlohmann::json one = read_json(scratch.path() / "out1/study.json"),
                       two = read_json(scratch.path() / "out2/study.json");
  EXPECT_EQ(one["pieces"], two["pieces"]);
  EXPECT_EQ(one["thresholds"], two["thresholds"]);
  ASSERT_EQ(one["pieces"].size(), 2U);
  for (const nlohmann::json& piece : one["pieces"]) {
    EXPECT_GE(piece["modes"].get<int>(), 1);
    // The single-frequency calculation agrees with the mesh.
    EXPECT_LE(std::abs(piece["lowest_hz"].get<double>() / piece["lowest_direct_hz"].get<double>() - 1.0), 0.02)
        << piece;
    ASSERT_TRUE(piece["errors"].is_object()) << piece;
  }
  const nlohmann::json& rows = one["thresholds"];
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["replaced"], 2);
  EXPECT_NEAR(rows[0]["modes_replaced_percent"].get<double>(), 100.0, 1e-9);
  EXPECT_GT(rows[0]["log_spectral_distance_db"].get<double>(), 0.01);
  EXPECT_EQ(rows[1]["replaced"], 1);
  EXPECT_EQ(rows[2]["replaced"], 0);
  for (const char* key : {"log_spectral_distance_db", "mel_distance_db", "third_octave_db", "loudness_difference_db"})
    EXPECT_EQ(rows[2][key].get<double>(), 0.0) << key;
  const nlohmann::json& timings = one["timings"];
  EXPECT_GT(timings["proxy_s"].get<double>(), 0.0);
  EXPECT_GT(timings["direct_s"].get<double>(), timings["proxy_s"].get<double>());
  ASSERT_EQ(run_klang(kStudy + "-o place --contact place", scratch.path()).exit_code, 0);
  const nlohmann::json place = read_json(scratch.path() / "place/study.json");
  EXPECT_EQ(place["provenance"]["options"]["contact"], "place");
  EXPECT_EQ(place["pieces"][0]["errors"]["partial_rms_cents"], one["pieces"][0]["errors"]["partial_rms_cents"]);
  EXPECT_NE(place["pieces"][0]["errors"]["loudness_difference_db"],
            one["pieces"][0]["errors"]["loudness_difference_db"]);
  for (const char* name : {"report.html", "study.csv", "direct.wav", "proxy.wav"})
    EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out1" / name)) << name;
}

TEST(KlangProxyStudy, BadInputIsRefused) {
  const Scratch scratch;
  ASSERT_EQ(
      run_klang(
          "proxy build --no-radiation --thinnest 0.8 --tolerance 0.1 --degree 8 --check-shapes 5 --quiet -o a.bank",
          scratch.path())
          .exit_code,
      0);
  expect_refused(scratch, kStudy + "-o out", {"no sound"});
  expect_refused(scratch, kStudy + "-o out --poissons-ratio 0.3", {"another Poisson's ratio"});
  expect_refused(scratch, "proxy study a.bank -o out --pieces 0", {"--pieces"});
  expect_refused(scratch, "proxy study a.bank -o out --thresholds 1", {"--thresholds"});
  expect_refused(scratch, "proxy study a.bank -o out --contact edge", {"--contact"});
  expect_refused(scratch, "proxy study a.bank -o out --slab 0.1,0.1,0.2", {"--slab"});
  expect_refused(scratch, "proxy study a.bank -o out --slab 0.1,0.1", {"--slab"});
  expect_refused(scratch, "proxy study a.bank -o out --highest-hz 30000", {"--highest-hz"});
  expect_refused(scratch, "proxy study none.bank -o out", {"none.bank"});
}
