// klang regress: exit codes, files, messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/random.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"
#include "tests/places.hpp"

using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;
using nlohmann::json;

namespace {

/// Three partials in noise of about -46 dB; the second one's pitch is moved.
std::string ring(double shift_cents, std::uint64_t seed, float gain = 1.0f) {
  klang::RandomStream random(seed, 0);
  std::vector<float> x;
  constexpr int kRate = 16000;
  const double second_hz = 1700.0 * std::pow(2.0, shift_cents / 1200.0);
  for (int i = 0; i < kRate; ++i) {
    const double t = i / static_cast<double>(kRate) - 0.05;
    double sum = 1e-3 * random.normal();
    if (t >= 0.0) {
      for (const auto& [f, d, a] : {std::tuple{600.0, 5.0, 0.2}, {second_hz, 9.0, 0.15}, {3900.0, 15.0, 0.1}})
        sum += a * std::exp(-d * t) * std::sin(2 * klang::kPi * f * t);
    }
    x.push_back(gain * static_cast<float>(sum));
  }
  return klang::test::wav_bytes(x, 1, kRate);
}

class KlangRegress : public ::testing::Test {
 protected:
  void SetUp() override {
    scratch_.write("a.wav", ring(0.0, 1));
    ASSERT_EQ(run_klang("regress make a.wav -o ref.json -q", scratch_.path()).exit_code, 0);
  }
  Scratch scratch_;
};

}  // namespace

TEST_F(KlangRegress, SameObjectPassesAndWritesPageAndJUnit) {
  scratch_.write("b.wav", ring(0.0, 2, 0.4f));
  const auto run = run_klang("regress check ref.json b.wav -o out --json r.json", scratch_.path());
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const json result = read_json(scratch_.path() / "r.json");
  EXPECT_EQ(result, read_json(scratch_.path() / "out/regression.json"));
  EXPECT_EQ(result["passed"], true);
  EXPECT_EQ(result["status"], "passed");
  EXPECT_EQ(result["n_failed"], 0);
  EXPECT_LE(std::abs(result["gain_db"].get<double>() - 20 * std::log10(0.4)), 0.1);
  EXPECT_LE(result["log_spectral_distance_db"].get<double>(), 1.0);
  EXPECT_EQ(result["partials"].size(), 3u);
  for (const char* file : {"out/report.html", "out/junit.xml", "out/figures/levels.png", "out/figures/spectrum.png",
                           "out/figures/partials.png"})
    EXPECT_TRUE(std::filesystem::exists(scratch_.path() / file)) << file;
  EXPECT_EQ(run_klang("report out/regression.json", scratch_.path()).exit_code, 0);
}

TEST_F(KlangRegress, NothingJudgedIsExitOneInJsonJUnitAndPage) {
  // Takes that scatter by tens of cents show nothing of a fourth.
  scratch_.write("t1.wav", ring(-30.0, 11));
  scratch_.write("t2.wav", ring(0.0, 12));
  scratch_.write("t3.wav", ring(30.0, 13));
  ASSERT_EQ(run_klang("regress make t1.wav t2.wav t3.wav -o wild.json -q", scratch_.path()).exit_code, 0);
  const json reference = read_json(scratch_.path() / "wild.json");
  json wild = reference;
  for (json& p : wild["partials"]) p["frequency_scatter_cents"] = 20.0, p["decay_scatter"] = 0.5;
  scratch_.write("wild.json", wild.dump());
  const auto run = run_klang("regress check wild.json a.wav --no-levels -o out", scratch_.path());
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(run.out.find("NOT PASSED (no partial could be judged)"), std::string::npos) << run.out;
  const json result = read_json(scratch_.path() / "out/regression.json");
  EXPECT_EQ(result["status"], "nothing_judged");
  EXPECT_EQ(result["passed"], false);
  const std::string xml = klang::read_file(scratch_.path() / "out/junit.xml", 1 << 20);
  EXPECT_NE(xml.find("failures=\"1\""), std::string::npos) << xml;
  const std::string page = klang::read_file(scratch_.path() / "out/report.html", 64 << 20);
  EXPECT_NE(page.find("Nothing could be judged"), std::string::npos);
  EXPECT_EQ(page.find("none of"), std::string::npos);
  EXPECT_NE(page.find("<audio"), std::string::npos);
}

TEST_F(KlangRegress, ShiftOfThreeCentsIsExitOneAndAFailureInJUnit) {
  scratch_.write("b.wav", ring(3.0, 3));
  const auto run = run_klang("regress check ref.json b.wav -o out", scratch_.path());
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(run.out.find("FAILED      partial-2.frequency"), std::string::npos) << run.out;
  std::ifstream in(scratch_.path() / "out/junit.xml");
  const std::string xml{std::istreambuf_iterator<char>(in), {}};
  EXPECT_NE(xml.find("name=\"partial-2.frequency\"><failure"), std::string::npos) << xml;
}

TEST_F(KlangRegress, ModelAgainstItsOwnSoundPassesAndAStifferOneDoesNot) {
  const std::string bar =
      "modes --shape box --dims length_m=0.2,width_m=0.03,height_m=0.006 --count 4 --max-edge-m 0.015 -q ";
  const std::string damping = " --rayleigh-stiffness-s 1e-7 --rayleigh-mass-per-s 4 ";
  ASSERT_EQ(run_klang(bar + "--material steel -o bar.vtu", scratch_.path()).exit_code, 0);
  ASSERT_EQ(run_klang(bar + "--material lame_lambda_pa=1.16e11,lame_mu_pa=8.05e10,density_kg_m3=7850 -o other.vtu",
                      scratch_.path())
                .exit_code,
            0);
  ASSERT_EQ(run_klang("synth bar.vtu -o bar.wav --duration-s 1.5 -q" + damping, scratch_.path()).exit_code, 0);
  ASSERT_EQ(run_klang("regress make bar.vtu -o bar.json -q" + damping, scratch_.path()).exit_code, 0);
  EXPECT_EQ(run_klang("regress check bar.json bar.wav -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(run_klang("regress check bar.json other.vtu -q" + damping, scratch_.path()).exit_code, 1);
  const auto undamped = run_klang("regress make bar.vtu -o x.json", scratch_.path());
  EXPECT_EQ(undamped.exit_code, 2);
  EXPECT_NE(undamped.err.find("damping"), std::string::npos) << undamped.err;
}

TEST_F(KlangRegress, BadInputIsOneLineAndLeavesNothing) {
  json newer = read_json(scratch_.path() / "ref.json"), empty = newer;
  newer["schema_version"] = 99;
  empty["partials"] = json::array();
  scratch_.write("newer.json", newer.dump());
  scratch_.write("empty.json", empty.dump());
  scratch_.write("cut.json", newer.dump().substr(0, 3000));
  scratch_.write("silent.wav", klang::test::wav_bytes(std::vector<float>(8000, 0.0f), 1, 16000));
  const auto before = scratch_.files();
  for (const char* arguments :
       {"check newer.json a.wav -o out", "check empty.json a.wav -o out", "check cut.json a.wav -o out",
        "check a.wav a.wav -o out", "check gone.json a.wav -o out", "check ref.json silent.wav -o out",
        "check ref.json gone.wav -o out", "make silent.wav -o x.json", "make gone.wav -o x.json", "make a.wav",
        "check ref.json a.wav --false-alarm-rate 2 -o out", "check ref.json a.wav --band-hz 9:1 -o out",
        "make a.wav -o /proc/nowhere/x.json"}) {
    const auto run = run_klang(std::string("regress ") + arguments, scratch_.path());
    EXPECT_EQ(run.exit_code, 2) << arguments << run.out;
    EXPECT_EQ(run.err_lines(), 1) << arguments << ": " << run.err;
    EXPECT_EQ(scratch_.files(), before) << arguments;
  }
}

TEST_F(KlangRegress, HelpShowsExamples) {
  for (const char* child : {"make", "check"}) {
    const auto help = run_klang(std::string("regress ") + child + " --help", scratch_.path());
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.out.find("Examples"), std::string::npos);
    EXPECT_NE(help.out.find("--json"), std::string::npos);
  }
}

TEST(KlangValidate, PapersPassesAndWritesItsPage) {
  const Scratch scratch;
  // A run that was killed: what the program itself leaves in the folder before scene.json.
  const std::string scenes = klang::test::source_dir() + "/datasets-synthetic/scenes/sb/";
  ASSERT_EQ(run_klang("scene run " + scenes + "tile.toml -o RUNS/sb_tile --until-s 0.01 --no-sound --no-frames",
                      scratch.path())
                .exit_code,
            0);
  std::filesystem::copy(scratch.path() / "RUNS/sb_tile", scratch.path() / "RUNS/sb_slab");
  ASSERT_TRUE(std::filesystem::remove(scratch.path() / "RUNS/sb_slab/scene.json"));
  ASSERT_TRUE(std::filesystem::exists(scratch.path() / "RUNS/sb_slab/run.json"));
  const auto run = run_klang("validate papers -o out --markdown p.md --json p.json --scenes RUNS", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const std::string page = klang::read_file(scratch.path() / "p.md");
  EXPECT_NE(page.find("not run (unfinished)"), std::string::npos);
  EXPECT_NE(page.find("not judged: 0.01 s of a scene of 2 s"), std::string::npos);
  const json papers = read_json(scratch.path() / "p.json");
  EXPECT_EQ(papers, read_json(scratch.path() / "out/papers.json"));
  EXPECT_EQ(papers["status"], "passed");
  EXPECT_GE(papers["numbers"].size(), 80u);
  for (const char* key : {"printed", "ours", "reference", "tolerance", "tolerance_source", "verdict"})
    EXPECT_TRUE(papers["numbers"][0].contains(key)) << key;
  for (const char* file : {"out/report.html", "out/junit.xml", "p.md"})
    EXPECT_TRUE(std::filesystem::exists(scratch.path() / file)) << file;
  EXPECT_EQ(run_klang("report out/papers.json", scratch.path()).exit_code, 0);
  const auto empty = run_klang("validate papers --scenes ''", scratch.path());
  EXPECT_EQ(empty.exit_code, 2);
  EXPECT_NE(empty.err.find("--scenes"), std::string::npos) << empty.err;
  const auto help = run_klang("validate papers --help", scratch.path());
  EXPECT_NE(help.out.find("Examples"), std::string::npos);
}
