// klang scene: exit codes, files, messages.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string_view>

#include "core/foundation/base/output_file.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::read_file;
using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::RunResult;
using klang::test::Scratch;
using nlohmann::json;

namespace {

const std::string kScene = R"(
duration_s = 0.4
[world.floor]
material = "steel"
[[material]]
name = "steel"
preset = "steel"
restitution = 0.6
damping = { model = "loss_factor", loss_factor = 2e-3 }
[[body]]
name = "bar"
shape = { kind = "box", length_m = 0.2, width_m = 0.04, height_m = 0.01 }
material = "steel"
max_edge_m = 0.02
position_m = [0, 0, 0.1]
rotation_deg = [8, 5, 0]
[sound]
band_hz = [20, 4000]
)";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

class KlangScene : public ::testing::Test {
 protected:
  void SetUp() override { scratch_.write("scene.toml", kScene); }
  std::string bytes(const std::string& name) const { return read_file(scratch_.path() / name); }
  Scratch scratch_;
};

TEST_F(KlangScene, RunWritesWhatTheContractNames) {
  const RunResult run = run_klang("scene run scene.toml -o out", scratch_.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json scene = read_json(scratch_.path() / "out/scene.json");
  ASSERT_EQ(scene["bodies"].size(), 1u);
  const json& bar = scene["bodies"][0];
  EXPECT_EQ(bar["name"], "bar");
  EXPECT_TRUE(bar["parent"].is_null());
  EXPECT_NEAR(bar["mass_kg"].get<double>(), 7850 * 0.2 * 0.04 * 0.01, 1e-9);
  EXPECT_GE(bar["n_modes"].get<int>(), 1);
  EXPECT_EQ(bar["proxy"], false);
  EXPECT_EQ(bar["final"]["position_m"].size(), 3u);
  EXPECT_EQ(bar["final"]["orientation_wxyz"].size(), 4u);
  EXPECT_LE(scene["ledger"]["residual_relative"].get<double>(), 1e-9);
  EXPECT_GT(scene["sound"]["peak_pressure_pa"].get<double>(), 0.0);
  EXPECT_NEAR(scene["sound"]["gain"].get<double>() * scene["sound"]["peak_pressure_pa"].get<double>(),
              std::pow(10.0, -0.15), 1e-9);

  const std::vector<std::string> ledger = lines_of(bytes("out/ledger.csv"));
  EXPECT_EQ(ledger.size(), 4002u);  // names, the start, a row per step
  for (const char* column : {"time_s", "kinetic_j", "potential_j", "strain_j", "contact_j", "friction_j", "fracture_j",
                             "vibration_j", "work_j", "residual_j"})
    EXPECT_NE(ledger[0].find(column), std::string::npos) << column;
  EXPECT_NE(bytes("out/report.html").find("<audio"), std::string::npos);

  ASSERT_EQ(run_klang("scene info out --impulses-csv i.csv", scratch_.path()).exit_code, 0);
  EXPECT_EQ(lines_of(bytes("i.csv"))[0], "time_s,body,other,x_m,y_m,z_m,jx_n_s,jy_n_s,jz_n_s,duration_s,kind");
}

TEST_F(KlangScene, ABodyAtRestIsNotRaisedToFullScale) {
  scratch_.write(
      "rest.toml",
      "[world.floor]\nmaterial = \"steel\"\n[[material]]\nname = \"steel\"\npreset = \"steel\"\nrestitution = "
      "0.3\nfriction = 0.3\n[[body]]\nname = \"block\"\nmaterial = \"steel\"\nposition_m = [0, 0, 0.01]\n"
      "shape = { kind = \"box\", length_m = 0.1, width_m = 0.05, height_m = 0.02 }\n");
  const RunResult run = run_klang("scene run rest.toml -o rest --no-page", scratch_.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("nobody hears"), std::string::npos) << run.err;
  const json sound = read_json(scratch_.path() / "rest/scene.json")["sound"];
  EXPECT_LE(sound["peak_pressure_pa"].get<double>(), 1e-9);
  EXPECT_NEAR(sound["gain"].get<double>() * 20e-6 * std::sqrt(2.0), std::pow(10.0, -0.15), 1e-12);
}

TEST_F(KlangScene, WhatFallsForEverIsRefusedByCheckAndRunUnlessItHasAnEnd) {
  scratch_.write(
      "fall.toml",
      "[[material]]\nname = \"steel\"\npreset = \"steel\"\n[[body]]\nname = \"block\"\nmaterial = \"steel\"\n"
      "shape = { kind = \"box\", length_m = 0.1, width_m = 0.05, height_m = 0.02 }\n");
  for (const char* command : {"scene check fall.toml", "scene run fall.toml -o fall"})
    expect_refused(scratch_, command, {"never comes to rest", "duration_s"});
  const RunResult run = run_klang("scene run fall.toml -o fall --until-s 0.01 --no-page", scratch_.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(KlangScene, ResumeOfAFinishedRunChangesNothingAndOfAnotherSceneIsRefused) {
  ASSERT_EQ(run_klang("scene run scene.toml -o out -q", scratch_.path()).exit_code, 0);
  const std::string scene = bytes("out/scene.json"), sound = bytes("out/sound.wav"), page = bytes("out/report.html");
  EXPECT_EQ(run_klang("scene run scene.toml -o out --resume -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/scene.json"), scene);
  EXPECT_EQ(bytes("out/report.html"), page);

  // What was lost is made again in the same bits: the sound from the motion and the modes that are there, then all of it.
  std::filesystem::remove(scratch_.path() / "out/scene.json");
  std::filesystem::remove(scratch_.path() / "out/sound.wav");
  EXPECT_EQ(run_klang("scene run scene.toml -o out --resume -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/sound.wav"), sound);
  std::filesystem::remove(scratch_.path() / "out/scene.json");
  std::filesystem::remove(scratch_.path() / "out/motion.json");
  EXPECT_EQ(run_klang("scene run scene.toml -o out --resume -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/sound.wav"), sound);

  scratch_.write("other.toml", kScene + "sample_rate_hz = 44100\n");
  const RunResult other = run_klang("scene run other.toml -o out --resume", scratch_.path());
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_EQ(other.err_lines(), 1) << other.err;
  EXPECT_EQ(bytes("out/sound.wav"), sound);
  EXPECT_EQ(run_klang("scene run scene.toml -o nowhere --resume", scratch_.path()).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "nowhere"));
}

TEST_F(KlangScene, ARunThatEndedEarlierGoesOnWithItsModesInTheBitsOfTheWholeRun) {
  ASSERT_EQ(run_klang("scene run scene.toml -o whole -q", scratch_.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene run scene.toml -o out --until-s 0.15 -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(read_json(scratch_.path() / "out/scene.json")["n_steps"], 1500);
  const std::filesystem::path modes = scratch_.path() / "out/modes/0-bar.vtu";
  const auto made = std::filesystem::last_write_time(modes);
  ASSERT_EQ(run_klang("scene run scene.toml -o out --until-s 0.3 --resume -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(read_json(scratch_.path() / "out/scene.json")["n_steps"], 3000);
  const std::string ended = bytes("out/scene.json");
  const RunResult back = run_klang("scene run scene.toml -o out --until-s 0.2 --resume", scratch_.path());
  EXPECT_EQ(back.exit_code, 2);
  EXPECT_NE(back.err.find("--until-s"), std::string::npos) << back.err;
  EXPECT_EQ(bytes("out/scene.json"), ended);
  ASSERT_EQ(run_klang("scene run scene.toml -o out --resume -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(std::filesystem::last_write_time(modes), made);
  for (const char* name : {"sound.wav", "ledger.csv", "scene.glb"})
    EXPECT_EQ(bytes(std::string("out/") + name), bytes(std::string("whole/") + name)) << name;
}

// What the motion warned of is said, and stands in the document, whenever the run was killed.
TEST_F(KlangScene, WarningsOfTheMotionOutliveIt) {
  const std::string glass = R"(
duration_s = 0.25
[world.floor]
material = "glass"
[fracture]
most_pieces = 4
[[material]]
name = "glass"
preset = "soda_lime_glass"
restitution = 0.3
tensile_strength_pa = 2e7
fracture_energy_j_m2 = 20
damping = { model = "loss_factor", loss_factor = 2e-3 }
[[body]]
name = "tile"
shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.006 }
material = "glass"
model = "breakable"
position_m = [0, 0, 0.25]
rotation_deg = [20, 10, 0]
stress_edge_m = 0.02
)";
  scratch_.write("glass.toml", glass);
  ASSERT_EQ(run_klang("scene run glass.toml -o out -q --no-sound --no-frames", scratch_.path()).exit_code, 0);
  const json warnings = read_json(scratch_.path() / "out/scene.json")["warnings"];
  ASSERT_NE(warnings.dump().find("most_pieces"), std::string::npos) << warnings;
  std::filesystem::remove(scratch_.path() / "out/scene.json");
  const RunResult again = run_klang("scene run glass.toml -o out -q --no-sound --no-frames --resume", scratch_.path());
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(read_json(scratch_.path() / "out/scene.json")["warnings"], warnings);
  EXPECT_NE(again.err.find("most_pieces"), std::string::npos) << again.err;
}

TEST_F(KlangScene, ResumeMakesSoundFramesAndPageThatAreAskedForAndMissing) {
  ASSERT_EQ(run_klang("scene run scene.toml -o whole -q", scratch_.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene run scene.toml -o out -q --no-sound --no-frames", scratch_.path()).exit_code, 0);
  ASSERT_FALSE(std::filesystem::exists(scratch_.path() / "out/sound.wav"));
  ASSERT_EQ(run_klang("scene run scene.toml -o out -q --resume", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/sound.wav"), bytes("whole/sound.wav"));
  EXPECT_EQ(bytes("out/scene.glb"), bytes("whole/scene.glb"));
  std::filesystem::remove(scratch_.path() / "out/report.html");
  ASSERT_EQ(run_klang("scene run scene.toml -o out -q --resume", scratch_.path()).exit_code, 0);
  EXPECT_NE(bytes("out/report.html").find("<audio"), std::string::npos);
}

TEST_F(KlangScene, ABodyAtRestIsAccountedFor) {
  std::string rest = kScene;
  rest.replace(rest.find("position_m = [0, 0, 0.1]\nrotation_deg = [8, 5, 0]"), 49, "position_m = [0, 0, 0.005]");
  scratch_.write("rest.toml", rest);
  const RunResult run = run_klang("scene run rest.toml -o rest -q --no-sound --no-frames", scratch_.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LE(read_json(scratch_.path() / "rest/scene.json")["ledger"]["residual_relative"].get<double>(), 1e-9);
}

TEST_F(KlangScene, ABodyThatSpinsTooFastForTheStepIsRefusedByCheckAndRun) {
  scratch_.write(
      "spin.toml",
      kScene +
          "\n[[body]]\nname = \"top\"\nshape = { kind = \"box\", length_m = 0.2, width_m = 0.02, height_m "
          "= 0.01 }\nmaterial = \"steel\"\nposition_m = [0, 0, 1]\nangular_velocity_rad_s = [0, 4e4, 4e3]\n");
  for (const char* command : {"scene check spin.toml", "scene run spin.toml -o spin --no-sound"}) {
    const RunResult run = run_klang(command, scratch_.path());
    EXPECT_EQ(run.exit_code, 2) << command;
    EXPECT_EQ(run.err_lines(), 1) << run.err;
    EXPECT_NE(run.err.find("top"), std::string::npos) << run.err;
    EXPECT_NE(run.err.find("turns too far"), std::string::npos) << run.err;
  }
}

TEST_F(KlangScene, SoundAgainIsTheSameSoundAndAnotherListenerHearsAnother) {
  ASSERT_EQ(run_klang("scene run scene.toml -o out -q", scratch_.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene sound out -o again.wav -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("again.wav"), bytes("out/sound.wav"));
  const std::string own = bytes("out/sound.wav");
  const RunResult over = run_klang("scene sound out -o out/../out/sound.wav --listener 0,-1,1", scratch_.path());
  EXPECT_EQ(over.exit_code, 2);
  EXPECT_NE(over.err.find("the run itself"), std::string::npos) << over.err;
  EXPECT_EQ(bytes("out/sound.wav"), own);
  const RunResult none = run_klang("scene sound nowhere -o again.wav", scratch_.path());
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("nowhere"), std::string::npos) << none.err;
  const RunResult near =
      run_klang("scene sound out -o near.wav --listener 0,-0.4,0.3 --stereo --json near.json", scratch_.path());
  ASSERT_EQ(near.exit_code, 0) << near.err;
  const json heard = read_json(scratch_.path() / "near.json")["sound"];
  EXPECT_EQ(heard["n_channels"], 2);
  EXPECT_GT(heard["peak_pressure_pa"].get<double>(),
            read_json(scratch_.path() / "out/scene.json")["sound"]["peak_pressure_pa"].get<double>());
  // The log alone, with the scene for its bodies.
  ASSERT_EQ(run_klang("scene sound out/events.h5 --scene scene.toml -o log.wav -q", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("log.wav"), bytes("out/sound.wav"));
}

TEST_F(KlangScene, BadScenesAreRefusedInOneLineAndLeaveNothing) {
  scratch_.write("typo.toml", kScene + "bandd_hz = [1, 2]\n");
  scratch_.write("deep.toml", [] {
    std::string text = kScene;
    return text.replace(text.find("[0, 0, 0.1]"), 11, "[0, 0, 0.0]");
  }());
  scratch_.write("never.toml", [] {
    std::string text = kScene;
    return text.replace(text.find("duration_s = 0.4"), 16, "longest_s = 0.05");
  }());
  for (const char* file : {"typo.toml", "deep.toml", "never.toml", "missing.toml"}) {
    const RunResult run = run_klang(std::string("scene run ") + file + " -o out", scratch_.path());
    EXPECT_EQ(run.exit_code, 2) << file;
    EXPECT_EQ(run.err_lines(), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out")) << file;
  }
  EXPECT_EQ(run_klang("scene check typo.toml", scratch_.path()).exit_code, 2);
  const RunResult check = run_klang("scene check scene.toml --json c.json", scratch_.path());
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_EQ(read_json(scratch_.path() / "c.json")["bodies"][0]["n_parts"], 1);
}

TEST_F(KlangScene, AFolderInWhichARunIsAtWorkIsRefusedAndStaysAsItIs) {
  ASSERT_EQ(run_klang("scene run scene.toml -o out --until-s 0.05 --no-sound --no-frames", scratch_.path()).exit_code,
            0);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/.lock"));
  const std::string before = bytes("out/scene.json");
  const int held = open((scratch_.path() / "out/.lock").c_str(), O_RDWR | O_CREAT, 0644);
  ASSERT_GE(held, 0);
  ASSERT_EQ(flock(held, LOCK_EX | LOCK_NB), 0);
  const RunResult second =
      run_klang("scene run scene.toml -o out --until-s 0.1 --no-sound --no-frames", scratch_.path());
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_NE(second.err.find("holds a run already"), std::string::npos) << second.err;
  EXPECT_EQ(lines_of(second.err).size(), 1u) << second.err;
  EXPECT_EQ(bytes("out/scene.json"), before);
  close(held);  // as a process that is killed does
  EXPECT_EQ(run_klang("scene run scene.toml -o out --until-s 0.1 --no-sound --no-frames", scratch_.path()).exit_code,
            0);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/.lock"));
}

TEST_F(KlangScene, ModesThatTheBandLacksAreRefusedBeforeAnythingMoves) {
  const std::string text = kScene;
  const std::string box = "shape = { kind = \"box\", length_m = 0.2, width_m = 0.04, height_m = 0.01 }";
  const std::string ball = "shape = { kind = \"sphere\", radius_m = 0.02 }\nsound = \"modes\"";
  for (const std::string model : {"", "\nmodel = \"modal\""}) {
    std::string scene = text;
    scratch_.write("ball.toml", scene.replace(text.find(box), box.size(), ball + model));
    for (const std::string command : {"scene check ball.toml", "scene run ball.toml -o deep/out"}) {
      const RunResult run = run_klang(command, scratch_.path());
      EXPECT_EQ(run.exit_code, 2) << command << model;
      EXPECT_NE(run.err.find("bar has no mode in the band"), std::string::npos) << run.err;
      EXPECT_EQ(lines_of(run.err).size(), 1u) << run.err;
    }
  }
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "deep"));
}

TEST_F(KlangScene, ASampleRateThatEndsBelowTheBandIsSaid) {
  scratch_.write("low.toml", kScene + "sample_rate_hz = 6000\n");
  const RunResult run = run_klang("scene check low.toml", scratch_.path());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("holds nothing above 3000 Hz"), std::string::npos) << run.err;
}

TEST_F(KlangScene, AnEarlierEndWithoutSoundIsMotionAlone) {
  ASSERT_EQ(
      run_klang("scene run scene.toml -o out --until-s 0.1 --no-sound -q --json run.json", scratch_.path()).exit_code,
      0);
  const json scene = read_json(scratch_.path() / "run.json");
  EXPECT_TRUE(scene["sound"].is_null());
  EXPECT_EQ(scene["n_steps"], 1000);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/sound.wav"));
}

}  // namespace

TEST_F(KlangScene, ACrackingBarWritesItsFacesAndSplits) {
  scratch_.write("still.csv", "time_s,x,y,z\n0,0,0,0\n");
  scratch_.write("pull.csv", "time_s,x,y,z\n0,0,0,0\n0.01,0.1,0,0\n");
  const std::string scene = R"(
duration_s = 0.035
[world]
gravity_m_s2 = [0, 0, 0]
[[material]]
name = "soft"
lame_lambda_pa = 4e6
lame_mu_pa = 4e6
density_kg_m3 = 1000
[[body]]
name = "bar"
shape = { kind = "box", length_m = 0.3, width_m = 0.1, height_m = 0.1 }
material = "soft"
model = "cracking"
max_edge_m = 0.06
sound = "none"
[crack]
strength_pa = 5e4
viscosity_mu_pa_s = 400
[[hold]]
body = "bar"
where = "x=min"
csv = "still.csv"
[[hold]]
body = "bar"
where = "x=max"
kind = "velocity"
csv = "pull.csv"
)";
  scratch_.write("crack.toml", scene);
  const RunResult run = run_klang("scene run crack.toml -o out", scratch_.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(scratch_.path() / "out/scene.json");
  const std::vector<std::string> faces = lines_of(read_file(scratch_.path() / "out/crack_faces.csv"));
  EXPECT_EQ(faces[0], "x_m,y_m,z_m,nx,ny,nz,area_m2,time_s");
  double area = 0.0;
  for (std::size_t i = 1; i < faces.size(); ++i) {
    std::istringstream cells(faces[i]);
    std::string cell;
    for (int k = 0; k < 7; ++k) std::getline(cells, cell, ',');
    area += std::stod(cell);
  }
  EXPECT_NEAR(area / result["cracks"]["new_area_m2"].get<double>(), 1.0, 1e-12);
  EXPECT_EQ(result["events"][0]["kind"], "split");
  EXPECT_GT(result["cracks"]["n_splits"].get<int>(), 0);
  EXPECT_LE(result["ledger"]["residual_relative"].get<double>(), 1e-3);
  EXPECT_NE(read_file(scratch_.path() / "out/ledger.csv").find("viscous_j,plastic_j"), std::string::npos);
  const json& split = result["events"][0];
  EXPECT_GT(split["strain_energy_j"].get<double>(), 0.0);
  EXPECT_GT(split["viscous_energy_j"].get<double>(), 0.0);
  EXPECT_TRUE(split["fracture_energy_j"].is_null() && split["vibration_energy_j"].is_null());
  const json& ledger = result["ledger"];
  EXPECT_GE(ledger["most_strain_j"].get<double>(), split["strain_energy_j"].get<double>() * 0.9);
  EXPECT_GT(ledger["work_j"].get<double>(), ledger["viscous_j"].get<double>());
  const std::string page = read_file(scratch_.path() / "out/report.html");
  for (const char* words :
       {" viscosity ", "what is held put in ", " J of strain", ">viscosity<", ">work put in<", ">strain<"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  EXPECT_EQ(page.find("plastic flow"), std::string::npos) << "nothing flows";
  EXPECT_EQ(run.err.find("neither deformed"), std::string::npos);
  // A run that was cut off after its motion draws the same frames.
  const std::string frame = bytes("out/frames/000001.vtp"), animation = bytes("out/scene.glb");
  for (const char* name : {"scene.json", "scene.glb", "frames/000001.vtp", "report.html"})
    std::filesystem::remove(scratch_.path() / "out" / name);
  ASSERT_EQ(run_klang("scene run crack.toml -o out --resume", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/frames/000001.vtp"), frame);
  EXPECT_EQ(bytes("out/scene.glb"), animation);
  // One that had no frames makes its motion again for them.
  ASSERT_EQ(run_klang("scene run crack.toml -o out --no-frames", scratch_.path()).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/shapes.bin"));
  std::filesystem::remove(scratch_.path() / "out/scene.json");
  ASSERT_EQ(run_klang("scene run crack.toml -o out --resume", scratch_.path()).exit_code, 0);
  EXPECT_EQ(bytes("out/scene.glb"), animation);
  std::string zero = scene;
  zero.replace(zero.find("5e4"), 3, "0.0");
  scratch_.write("zero.toml", zero);
  const RunResult refused = run_klang("scene run zero.toml -o no", scratch_.path());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_EQ(refused.err_lines(), 1);
  EXPECT_NE(refused.err.find("strength_pa"), std::string::npos);
}

TEST_F(KlangScene, FramesAreWrittenWholeUnlessTheyAreNotWanted) {
  ASSERT_EQ(run_klang("scene run scene.toml -o out --until-s 0.1 --no-sound -q", scratch_.path()).exit_code, 0);
  const json frames = read_json(scratch_.path() / "out/scene.json")["frames"];
  EXPECT_EQ(frames["n_frames"], 7);
  EXPECT_EQ(frames["animation"], "scene.glb");
  EXPECT_EQ(bytes("out/scene.glb").substr(0, 4), "glTF");
  EXPECT_NE(bytes("out/frames.pvd").find("frames/000006.vtp"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(scratch_.path() / "out/frames/000006.vtp"));
  ASSERT_EQ(run_klang("scene run scene.toml -o out --until-s 0.1 --no-sound --no-frames -q", scratch_.path()).exit_code,
            0);
  EXPECT_TRUE(read_json(scratch_.path() / "out/scene.json")["frames"].is_null());
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/scene.glb"));
  EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "out/frames/000006.vtp"));
}

TEST_F(KlangScene, ProxiesWithoutABankAreRefused) {
  for (const char* command :
       {"scene run scene.toml -o no --proxies-above-hz 0", "scene run scene.toml -o no --proxies-above-hz -1"}) {
    const RunResult run = run_klang(command, scratch_.path());
    EXPECT_EQ(run.exit_code, 2) << command;
    EXPECT_EQ(run.err_lines(), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(scratch_.path() / "no"));
  }
}

TEST_F(KlangScene, DrawsFromAFitSayHowSureTheSoundIs) {
  scratch_.write("fit.json", R"({"kind": "fit", "status": "converged",
"material": {"lame_lambda_pa": 1.0849e11, "lame_mu_pa": 8.0535e10, "density_kg_m3": 7850},
"parameters": [{"name": "youngs_modulus_pa", "value": 2.0729e11, "std": 4.1458e9, "identifiable": true}],
"correlation": {"names": ["youngs_modulus_pa"], "matrix": [[1.0]]}})");
  std::string scene = kScene;
  scene.replace(scene.find("preset = \"steel\""), 16, "fit = \"fit.json\"");
  scratch_.write("fitted.toml", scene);
  const RunResult run = run_klang("scene run fitted.toml -o out --no-frames --draws 40 -q", scratch_.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json draws = read_json(scratch_.path() / "out/scene.json")["draws"];
  EXPECT_EQ(draws["n"], 40);
  EXPECT_EQ(draws["materials"], json({"steel"}));
  EXPECT_EQ(draws["peak_pressure_pa"].size(), 40u);
  ASSERT_GE(draws["partials"].size(), 2u);
  // 2 % of E are 1 % of a frequency: nine of ten draws within 1.645 of it, here to the noise of 40 draws.
  for (const json& partial : draws["partials"]) {
    const double middle = partial["frequency_hz"].get<double>();
    EXPECT_NEAR((partial["high_hz"].get<double>() - partial["low_hz"].get<double>()) / middle, 2 * 1.645 * 0.01, 0.012);
    EXPECT_LT(partial["low_hz"].get<double>(), middle);
    EXPECT_GT(partial["high_hz"].get<double>(), middle);
  }
  EXPECT_NE(bytes("out/report.html").find("How sure the sound is"), std::string::npos);
  const RunResult without = run_klang("scene run scene.toml -o no --draws 3", scratch_.path());
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_EQ(without.err_lines(), 1) << without.err;
}
