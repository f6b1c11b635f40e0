// klang scene run of a liquid: bubbles, transfer, sound; tracked bubbles in and out.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using namespace klang;
using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;

namespace {

const std::string kPool =
    "name = \"pool\"\n[domain]\nsize_m = [0.12, 0.12, 0.12]\ncell_m = 0.02\nduration_s = 0.1\n[[pool]]\ndepth_m = "
    "0.08\n"
    "[[bubble]]\nradius_m = 0.003\nposition_m = [0.06, 0.06, 0.04]\nbirth_s = 0.01\n"
    "[listener]\nposition_m = [0.06, -0.5, 0.3]\n[entrainment]\nattempts_per_m2_s = 1e5\ncoverage = 0\n"
    "radii = { kind = \"gaussian\", mean_m = 0.002, std_m = 0.0005, smallest_m = 0.001, largest_m = 0.003 }\n"
    "[[entrainment.patch]]\nlow_m = [0.02, 0.02, 0.06]\nhigh_m = [0.1, 0.1, 0.1]\nstart_s = 0.0\nend_s = 0.1\n";

std::string read_text(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::vector<std::vector<std::string>> table(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(read_text(path));
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

}  // namespace

TEST(LiquidBubbles, APatchGivesItsRateAndEachStageIsDoneAgainAlone) {
  const Scratch scratch;
  scratch.write("pool.toml", kPool + "[transfer]\nmethod = \"half_space\"\n");
  const auto run = run_klang("scene run pool.toml -o out --seed 1", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto folder = scratch.path() / "out";
  const auto rows = table(folder / "bubbles.csv");
  EXPECT_EQ(rows[0], (std::vector<std::string>{"id", "birth_s", "end_s", "end_kind", "radius_m", "x_m", "y_m", "z_m",
                                               "depth_m", "frequency_start_hz", "frequency_end_hz"}));
  const double expected = 1e5 * 0.08 * 0.08 * 0.1 / 2.0 + 1.0;  // 33
  EXPECT_LE(std::abs(static_cast<double>(rows.size() - 1) - expected), 2.0);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double radius = std::stod(rows[i][4]);
    EXPECT_GE(radius, 0.001);
    EXPECT_LE(radius, 0.003);
    EXPECT_GE(std::stod(rows[i][8]), 0.0);
    EXPECT_LE(std::abs(std::stod(rows[i][9]) * radius / 3.283 - 1.0), 0.01);  // Minnaert
  }
  const nlohmann::json json = read_json(folder / "run.json");
  EXPECT_EQ(json["n_bubbles"].get<std::size_t>(), rows.size() - 1);
  EXPECT_LE(std::abs(json["births_per_s"].get<double>() - static_cast<double>(rows.size() - 1) / 0.1), 1.0);
  EXPECT_EQ(json["transfer"]["method"], "half_space");
  for (const char* stage : {"flow", "bubbles", "transfer", "sound"})
    EXPECT_EQ(json["stages"][stage]["status"], "done") << stage;
  EXPECT_GT(json["sound"]["peak_pressure_pa"].get<double>(), 0.0);

  const std::string flow = read_text(folder / "flow.csv"), bubbles = read_text(folder / "bubbles.csv"),
                    sound = read_text(folder / "sound.wav");
  ASSERT_EQ(run_klang("scene run pool.toml -o out --stage bubbles --seed 2", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "flow.csv"), flow);
  EXPECT_NE(read_text(folder / "bubbles.csv"), bubbles);
  EXPECT_NE(read_text(folder / "sound.wav"), sound);
  ASSERT_EQ(run_klang("scene run pool.toml -o out --stage bubbles --seed 1 --threads 1", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "bubbles.csv"), bubbles);
  EXPECT_EQ(read_text(folder / "sound.wav"), sound);
  expect_refused(scratch, "scene run pool.toml -o out --resume --seed 2", {"another seed"});
  EXPECT_EQ(run_klang("scene run pool.toml -o out --resume --seed 1", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "sound.wav"), sound);
  ASSERT_EQ(run_klang("scene run pool.toml -o out --stage sound --seed 7", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_text(folder / "sound.wav"), sound);
  // Of which seed the bubbles are does not change with that of a later stage.
  EXPECT_EQ(run_klang("scene run pool.toml -o out --resume --seed 1", scratch.path()).exit_code, 0);
  expect_refused(scratch, "scene run pool.toml -o out --resume --seed 7", {"another seed", "--seed 1"});
}

TEST(LiquidBubbles, ReciprocalTransferSaysItsErrorAndTheTanksModes) {
  const Scratch scratch;
  std::string scene = kPool;
  scene.erase(scene.find("[entrainment]"));
  scratch.write("pool.toml", scene);
  const auto run = run_klang("scene run pool.toml -o out", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json json = read_json(scratch.path() / "out/run.json");
  EXPECT_EQ(json["n_bubbles"], 1);
  EXPECT_EQ(json["transfer"]["method"], "reciprocal");
  EXPECT_GE(json["n_solves"].get<int>(), 10);
  EXPECT_LE(json["transfer"]["error_estimate"].get<double>(), 0.15);
  EXPECT_GT(json["sound"]["peak_pressure_pa"].get<double>(), 0.0);
}

TEST(TrackedScene, SoundsAndItsSecondTripIsTheSame) {
  const Scratch scratch;
  scratch.write(
      "t.txt",
      "Bub 7 0.002\n  Start: N 0.01\n  0.01 1640 0.1 0.05 -0.02 0 0.03\n  0.05 2100 0.1 0.07 -0.02 0 0.01\n  End: S "
      "0.05 8\n"
      "Bub 8 0.0015\n  Start: S 0.05 7\n  0.05 2200 0.1 0.07 -0.02\n  0.07 2300 0.1 0.075 -0.02\n  End: C 0.07\n");
  ASSERT_EQ(run_klang("scene import t.txt --kind tracked --listener 0,-1,0.5 -o D", scratch.path()).exit_code, 0);
  const auto run = run_klang("scene run D/scene.toml -o D --stage transfer", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_GT(read_json(scratch.path() / "D/run.json")["sound"]["peak_pressure_pa"].get<double>(), 0.0);
  const auto rows = table(scratch.path() / "D/bubbles.csv");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1][3], "split");
  EXPECT_EQ(rows[1][6], "0.02");  // our y is minus the file's z
  EXPECT_EQ(rows[1][9], "1640");
  ASSERT_EQ(run_klang("scene export D --tracked a.txt.xz", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene import a.txt.xz --kind tracked -o E", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene export E --tracked b.txt.xz", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_text(scratch.path() / "a.txt.xz"), read_text(scratch.path() / "b.txt.xz"));
}

TEST(TrackedScene, BadInputIsNamed) {
  const Scratch scratch;
  scratch.write("bad.txt", "Bub 1 0.002\n  Start: N 0\n  0 1000 0 0\n");
  scratch.write("t.txt", "Bub 1 0.002\n  Start: N 0\n  0 1000 0 0 0\n  End: C 0\n");
  expect_refused(scratch, "scene import bad.txt --kind tracked -o D", {"bad.txt", "line 3"});
  expect_refused(scratch, "scene import none.txt --kind tracked -o D", {"none.txt"});
  expect_refused(scratch, "scene import t.txt --kind smoke -o D", {"--kind", "tracked"});
  expect_refused(scratch, "scene import t.txt --kind tracked --listener 0,0,-1 -o D", {"--listener", "air"});
  expect_refused(scratch, "scene export D --tracked a.txt", {"D"});
}
