// For those who make and test things: fits that are played, exported, cut and tuned; specimens by impulse excitation.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/sound/audio/sound_file.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"
#include "tests/places.hpp"

namespace klang::test {
namespace {

using nlohmann::json;

constexpr const char* kAluminium = " --material youngs_modulus_pa=7.1e10,poissons_ratio=0.33,density_kg_m3=2700 ";

json run_json(const Scratch& scratch, const std::string& arguments) {
  const RunResult run = run_klang(arguments + " --quiet --json result.json", scratch.path());
  EXPECT_EQ(run.exit_code, 0) << arguments << "\n" << run.err;
  return run.exit_code == 0 ? read_json(scratch.path() / "result.json") : json::object();
}

std::string slurp(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Two rods of aluminium, their frequencies from the model with decays of a loss factor 1/1000, fitted into out/.
class FittedRods : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch_ = new Scratch;
    std::string table = "specimen,frequency_hz,frequency_std_hz,decay_per_s,decay_std_per_s\n";
    for (const auto& [name, length] : {std::pair{"long", "0.2"}, {"short", "0.1"}}) {
      const json modes = run_json(*scratch_, "modes --shape rod --dims length_m=" + std::string(length) +
                                                 ",radius_m=0.005 --count 8" + kAluminium)["modes"];
      for (const json& mode : modes) {
        const double f = mode["frequency_hz"], decay = M_PI * f * 1e-3;
        table += std::string(name) + "," + std::to_string(f) + ",0.1," + std::to_string(decay) + "," +
                 std::to_string(0.02 * decay) + "\n";
      }
    }
    scratch_->write("partials.csv", table);
    scratch_->write("rods.toml",
                    "[material]\nyoungs_modulus_pa = 7e10\npoissons_ratio = 0.33\n"
                    "[[specimen]]\nname = \"long\"\nshape = { kind = \"rod\", length_m = { value = 0.2, std = 1e-4 }, "
                    "radius_m = { value = 0.005, std = 1e-5 } }\nmass_kg = { value = 0.0424115, std = 1e-5 }\n"
                    "partials = \"partials.csv\"\n"
                    "[[specimen]]\nname = \"short\"\nshape = { kind = \"rod\", length_m = 0.1, radius_m = 0.005 }\n"
                    "mass_kg = 0.02120575\npartials = \"partials.csv\"\n"
                    "[fit]\nparameters = [\"youngs_modulus_pa\", \"rayleigh_stiffness_s\", \"rayleigh_mass_per_s\"]\n");
    const RunResult fit = run_klang("fit rods.toml -o out --no-pictures", scratch_->path());
    ASSERT_EQ(fit.exit_code, 0) << fit.err;
    printed_ = fit.out;
  }
  static void TearDownTestSuite() { delete scratch_; }
  static inline Scratch* scratch_ = nullptr;
  static inline std::string printed_;
};

TEST_F(FittedRods, BudgetsAddUpAndMissingTolerancesAreSaidAtTheNumber) {
  const json fit = read_json(scratch_->path() / "out/fit.json");
  for (const json& parameter : fit["parameters"]) {
    if (parameter["std"].is_null()) continue;
    double sum_sq = 0.0, shares = 0.0;
    for (const json& entry : fit["budget"]) {
      if (entry["parameter"] != parameter["name"] || entry["contribution_std"].is_null()) continue;
      sum_sq += std::pow(entry["contribution_std"].get<double>(), 2);
      shares += entry["share"].get<double>();
    }
    const double std = parameter["std"];
    EXPECT_LE(std::abs(std::sqrt(sum_sq) / std - 1.0), 1e-9) << parameter["name"];
    EXPECT_LE(std::abs(shares - 1.0), 1e-9) << parameter["name"];
  }
  const std::string words = "without the tolerances of short.";
  EXPECT_NE(printed_.find(words), std::string::npos) << printed_;  // those of "short" are missing
  EXPECT_NE(slurp(scratch_->path() / "out/report.html").find(words), std::string::npos);
  EXPECT_NE(printed_.find("given"), std::string::npos) << printed_;  // Poisson's ratio
}

TEST_F(FittedRods, SensitivityOfYoungsModulusIsThatOfASlenderBar) {
  // One rod alone: E ~ m f^2 L^3 / r^4.
  std::string text = slurp(scratch_->path() / "rods.toml");
  text.erase(text.find("[[specimen]]\nname = \"short\""),
             text.find("[fit]") - text.find("[[specimen]]\nname = \"short\""));
  text.replace(text.find("partials.csv"), 12, "first.csv");
  const std::string table = slurp(scratch_->path() / "partials.csv");
  std::istringstream lines(table);
  std::string first, line;
  for (int i = 0; i < 3 && std::getline(lines, line); ++i) first += line + "\n";  // the head and the first bending pair
  scratch_->write("first.csv", first);
  scratch_->write("one.toml", text);
  ASSERT_EQ(run_klang("fit one.toml -o one --no-pictures", scratch_->path()).exit_code, 0);
  const json fit = read_json(scratch_->path() / "one/fit.json");
  const std::pair<const char*, double> wanted[] = {
      {"long.length_m", 3.0}, {"long.radius_m", -4.0}, {"long.mass_kg", 1.0}};
  for (const auto& [source, sensitivity] : wanted) {
    bool found = false;
    for (const json& entry : fit["budget"]) {
      if (entry["parameter"] != "youngs_modulus_pa" || entry["source"] != source) continue;
      found = true;
      EXPECT_NEAR(entry["sensitivity"].get<double>(), sensitivity, 0.05) << source;
      EXPECT_GT(entry["contribution_std"].get<double>(), 0.0);
    }
    EXPECT_TRUE(found) << source;
  }
  EXPECT_EQ(slurp(scratch_->path() / "one/report.html").find("without the tolerances"), std::string::npos);
}

TEST_F(FittedRods, FittedMaterialHasDensityAndRayleighDamping) {
  const json material = read_json(scratch_->path() / "out/fit.json")["material"];
  EXPECT_NEAR(material["density_kg_m3"].get<double>(), 2700.0, 1.0);
  EXPECT_GT(material["rayleigh_stiffness_s"].get<double>(), 0.0);
  EXPECT_TRUE(material.contains("rayleigh_mass_per_s"));
}

TEST_F(FittedRods, SoundHasTheFitsDampingAndOtherDimensionsOtherFrequencies) {
  const json sound = run_json(*scratch_, "synth out/fit.json --specimen long -o a.wav");
  for (const json& mode : sound["modes"]) {
    const double f = mode["frequency_hz"];
    EXPECT_NEAR(mode["decay_per_s"].get<double>() / (M_PI * f * 1e-3), 1.0, 0.05);
  }
  const json file = run_json(*scratch_, "synth out/modes-long.vtu -o b.wav");
  EXPECT_EQ(file["modes"], sound["modes"]);
  const json longer = run_json(*scratch_, "synth out/fit.json --specimen long --dims length_m=0.25 -o c.wav");
  EXPECT_NEAR(longer["modes"][0]["frequency_hz"].get<double>() / sound["modes"][0]["frequency_hz"].get<double>(), 0.64,
              0.01);
  // Half as long: its modes lie up to four times as high, and there are as many.
  const json shorter = run_json(*scratch_, "synth out/fit.json --specimen long --dims length_m=0.1 -o e.wav");
  EXPECT_GE(shorter["modes"].size(), sound["modes"].size());
  expect_refused(*scratch_, "synth out/fit.json -o d.wav", {"--specimen", "long, short"});
  expect_refused(*scratch_, "synth out/fit.json --specimen lonk -o d.wav", {"did you mean long"});
}

TEST_F(FittedRods, UndampedModesAreSaidToBe) {
  ASSERT_EQ(run_klang("modes --shape rod --dims length_m=0.1,radius_m=0.005 --count 2 -o plain.vtu", scratch_->path())
                .exit_code,
            0);
  const RunResult run = run_klang("synth plain.vtu -o plain.wav --duration-s 0.1", scratch_->path());
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_NE(run.err.find("damp"), std::string::npos) << run.err;
}

TEST_F(FittedRods, WithoutMeasuredDampingEveryCommandAssumesTheSameAndSaysTheSame) {
  std::string text = slurp(scratch_->path() / "rods.toml"), table;
  text.replace(text.find(", \"rayleigh_stiffness_s\", \"rayleigh_mass_per_s\""),
               std::string(", \"rayleigh_stiffness_s\", \"rayleigh_mass_per_s\"").size(), "");
  for (std::size_t at; (at = text.find("partials.csv")) != std::string::npos;) text.replace(at, 12, "plain.csv");
  std::istringstream lines(slurp(scratch_->path() / "partials.csv"));
  for (std::string line; std::getline(lines, line);) {
    std::size_t end = 0;
    for (int comma = 0; comma < 3; ++comma) end = line.find(',', end) + 1;
    table += line.substr(0, end - 1) + "\n";
  }
  scratch_->write("plain.csv", table);
  scratch_->write("plain.toml", text);
  ASSERT_EQ(run_klang("fit plain.toml -o plain --no-pictures", scratch_->path()).exit_code, 0);
  for (const char* command :
       {"chime plain/fit.json --notes D6 -o plain-set", "synth plain/fit.json --specimen long -o plain.wav",
        "synth plain/modes-long.vtu -o plain-model.wav", "export plain/fit.json --sfz plain-sfz",
        "export plain/fit.json --csv -o plain-bank.csv"}) {
    const RunResult run = run_klang(std::string(command) + " --json said.json", scratch_->path());
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_NE(run.err.find("no damping was measured ("), std::string::npos) << command << run.err;
    EXPECT_NE(run.err.find("): a loss factor of 1/1000 is assumed"), std::string::npos) << command << run.err;
    EXPECT_EQ(read_json(scratch_->path() / "said.json")["warnings"].size(), 1U) << command;
  }
  const json sound = run_json(*scratch_, "synth plain/fit.json --specimen long -o plain.wav");
  for (const json& mode : sound["modes"])
    EXPECT_NEAR(mode["decay_per_s"].get<double>(), M_PI * 1e-3 * mode["frequency_hz"].get<double>(), 1e-9);
  const RunResult run = run_klang("synth plain/fit.json --specimen long --loss-factor 0 -o ring.wav", scratch_->path());
  EXPECT_NE(run.err.find("damping that was given is 0: the modes ring on"), std::string::npos) << run.err;
}

TEST_F(FittedRods, SfzCoversEveryKeyOnceAndTheLowestPartialIsInTune) {
  const RunResult run = run_klang("export out/fit.json --sfz sfz", scratch_->path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::istringstream lines(slurp(scratch_->path() / "sfz/sfz.sfz"));
  std::vector<std::map<std::string, std::string>> regions;
  for (std::string line; std::getline(lines, line);) {
    if (line == "<region>") regions.emplace_back();
    if (const auto equals = line.find('='); equals != std::string::npos)
      regions.back()[line.substr(0, equals)] = line.substr(equals + 1);
  }
  ASSERT_EQ(regions.size(), 2U);
  int next = 0;
  const json fit = read_json(scratch_->path() / "out/fit.json");
  for (auto& region : regions) {
    EXPECT_EQ(std::stoi(region["lokey"]), next);
    next = std::stoi(region["hikey"]) + 1;
    EXPECT_TRUE(std::filesystem::exists(scratch_->path() / "sfz" / region["sample"])) << region["sample"];
    const std::string specimen = region["sample"].find("long") != std::string::npos ? "long" : "short";
    for (const json& mode : fit["predicted"]) {
      if (mode["specimen"] != specimen || mode["mode_index"] != 0) continue;
      // What the centre key plays: the sample shifted by transpose and tune.
      const double key = std::stod(region["pitch_keycenter"]);
      const double shift = std::stod(region["transpose"]) + std::stod(region["tune"]) / 100.0;
      const double played = 69.0 + 12.0 * std::log2(mode["frequency_hz"].get<double>() / 440.0) + shift;
      EXPECT_LE(std::abs(played - key), 0.01) << specimen;
    }
  }
  EXPECT_EQ(next, 128);
}

TEST_F(FittedRods, FaustRendersWhatSynthPlays) {
  const std::filesystem::path sources =
      std::filesystem::path(klang::test::source_dir()) / "tests/cli/faust_impulse.cpp.in";
  const json sound = run_json(*scratch_, "synth out/fit.json --specimen long -o long.wav --duration-s 1");
  ASSERT_EQ(run_klang("export out/fit.json --specimen long --faust -o long.dsp", scratch_->path()).exit_code, 0);
  const std::string build = "cd '" + scratch_->path().string() + "' && faust -double -a '" + sources.string() +
                            "' long.dsp -o long.cpp && c++ -O1 long.cpp -o long && ./long 48000 48000 > long.raw";
  ASSERT_EQ(std::system(build.c_str()), 0);
  const std::string raw = slurp(scratch_->path() / "long.raw");
  std::vector<double> rendered(raw.size() / sizeof(double));
  ASSERT_EQ(rendered.size(), 48000U);
  std::copy(raw.begin(), raw.end(), reinterpret_cast<char*>(rendered.data()));
  const audio::Signal played = audio::read_sound(scratch_->path() / "long.wav");
  ASSERT_EQ(played.n_frames(), 48000);
  const Eigen::VectorXd ours = played.samples.col(0);
  const Eigen::Map<const Eigen::VectorXd> theirs(rendered.data(), 48000);
  const double gain = ours.dot(theirs) / theirs.squaredNorm();
  EXPECT_LE((ours - gain * theirs).norm() / ours.norm(), 1e-3);
  EXPECT_NEAR(gain, 1.0, 1e-3);  // both peak at -3 dB
}

TEST_F(FittedRods, ChimesAreCutToTheirNotes) {
  const RunResult run = run_klang("chime out/fit.json --notes \"D6 E6\" -o set", scratch_->path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json notes = read_json(scratch_->path() / "set/chime.json")["notes"];
  const std::string kWords = "without the tolerances of short.";  // "long" has its own
  for (const std::string& said :
       {run.out, slurp(scratch_->path() / "set/cut-list.csv"), slurp(scratch_->path() / "set/report.html")}) {
    std::size_t n = 0;
    for (std::size_t at = said.find(kWords); at != std::string::npos; at = said.find(kWords, at + 1)) ++n;
    EXPECT_GE(n, 2U) << said.substr(0, 2000);  // at each of the two lengths
  }
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_NEAR(notes[0]["frequency_hz"].get<double>(), 440.0 * std::exp2(17.0 / 12.0), 1e-6);
  for (const json& note : notes) {
    const json modes =
        run_json(*scratch_, "modes --shape rod --count 1 --material out/fit.json --dims radius_m=0.005,length_m=" +
                                note["length_m"].dump())["modes"];
    EXPECT_LE(std::abs(1200.0 * std::log2(modes[0]["frequency_hz"].get<double>() / note["frequency_hz"].get<double>())),
              0.2);
    const double length = note["length_m"];
    EXPECT_NEAR(note["node_m"].get<double>() / length, 0.2242, 0.004);  // of a slender bar; thick ones a little less
    EXPECT_NEAR(note["cents_per_tenth_mm"].get<double>(), -2.0 * 1e-4 / length * 1200.0 / std::log(2.0), 0.15);
    EXPECT_GT(note["length_std_m"].get<double>(), 0.0);
    EXPECT_EQ(note["length_caveat"].get<std::string>().find(kWords), 0U) << note;
  }
  for (const char* file : {"cut-list.csv", "set.wav", "report.html"})
    EXPECT_TRUE(std::filesystem::exists(scratch_->path() / "set" / file)) << file;
  expect_refused(*scratch_, "chime out/fit.json --notes \"D6 D6\" -o none", {"D6", "twice"});
  expect_refused(*scratch_, "chime out/fit.json --notes \"D6 X4\" -o none", {"X4"});
}

TEST_F(FittedRods, TuneStartsFromAFitAndTakesNotes) {
  const json tuned = run_json(*scratch_, "tune --from out/fit.json --specimen long --vary length_m --target C6");
  EXPECT_NEAR(tuned["targets"][0]["wanted_hz"].get<double>(), 440.0 * std::exp2(15.0 / 12.0), 1e-6);
  EXPECT_LE(std::abs(tuned["targets"][0]["residual_cents"].get<double>()), 0.05);
}

TEST(UndercutBar, IsTunedToANoteAndARatioByTwoDimensionsAndTheSlopesAreThoseOfDifferences) {
  const Scratch scratch;
  const std::string material = " --material youngs_modulus_pa=1.6e10,poissons_ratio=0.35,density_kg_m3=830 ";
  const std::string fixed = "--shape undercut_bar --dims length_m=0.4,width_m=0.05,height_m=0.022,";
  const json tuned = run_json(scratch, "tune " + fixed + "undercut_length_m=0.24,undercut_depth_m=0.012" + material +
                                           "--vary undercut_depth_m --vary undercut_length_m --target \"bending 1=C4\" "
                                           "--target \"bending 2/bending 1=4\"");
  EXPECT_EQ(tuned["targets"][1]["mode"], "bending 2/bending 1");
  for (const json& target : tuned["targets"]) EXPECT_LE(std::abs(target["residual_cents"].get<double>()), 0.05);
  EXPECT_LE(std::abs(tuned["targets"][0]["reached_hz"].get<double>() - 261.6256), 0.01);
  // By a mesh of another size, the lower two bending modes by differences of 1 mm in the undercut's length.
  const double depth_m = tuned["dimensions"][0]["value_m"], length_m = tuned["dimensions"][1]["value_m"];
  const auto lowest_hz = [&](double cut_m) {
    return run_json(scratch, "modes " + fixed + "undercut_length_m=" + std::to_string(cut_m) +
                                 ",undercut_depth_m=" + std::to_string(depth_m) + material +
                                 "--max-edge-m 0.016 --count 1 --no-mesh-error")["modes"][0]["frequency_hz"]
        .get<double>();
  };
  const double slope = (lowest_hz(length_m + 0.001) - lowest_hz(length_m - 0.001)) / 2.0;
  const double said = tuned["targets"][0]["hz_per_mm"]["undercut_length_m"];
  EXPECT_LE(std::abs(said / slope - 1.0), 0.03) << said << " and " << slope;
}

/// A struck bar as its model has it: the modes' frequencies, a loss factor of 1/500.
void write_bar(const Scratch& scratch, const std::string& name, const std::string& dims, double young_pa) {
  constexpr int kRate = 48000;
  const json modes = run_json(scratch, "modes --shape box --count 5 --dims " + dims +
                                           " --material youngs_modulus_pa=" + std::to_string(young_pa) +
                                           ",poissons_ratio=0.28,density_kg_m3=7850")["modes"];
  std::vector<float> samples(kRate / 2, 0.0F);
  for (std::size_t i = 2000; i < samples.size(); ++i) {
    for (const json& mode : modes) {
      const double f = mode["frequency_hz"], t = (static_cast<double>(i) - 2000.0) / kRate;
      if (f < 20000.0)
        samples[i] += static_cast<float>(0.1 * std::exp(-M_PI * f * 2e-3 * t) * std::sin(2.0 * M_PI * f * t));
    }
  }
  scratch.write(name, wav_bytes(samples, 1, kRate));
}

TEST(Iet, OneRecordingForSeveralSpecimensIsSaidAndHasNoSpread) {
  const Scratch scratch;
  write_bar(scratch, "bar.wav", "length_m=0.1,width_m=0.02,height_m=0.006", 210e9);
  std::string table = "specimen,shape,length_m,width_m,thickness_m,mass_kg,recording\n";
  for (const char* name : {"a", "b", "c", "d"}) table += std::string(name) + ",bar,0.1,0.02,0.006,0.0942,bar.wav\n";
  scratch.write("bars.csv", table);
  const RunResult run = run_klang("iet bars.csv -o out", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("a, b, c and 1 more have one and the same recording"), std::string::npos) << run.err;
  for (const json& line : read_json(scratch.path() / "out/iet.json")["summary"]) EXPECT_EQ(line["std"], 0.0) << line;
  EXPECT_EQ(slurp(scratch.path() / "out/report.html").find("± 0.0"), std::string::npos);
}

TEST(Iet, BarsGiveTheirModuliByTheStandardAndByTheModelWithoutTheOutlier) {
  const Scratch scratch;
  const std::string dims = "length_m=0.1,width_m=0.02,height_m=0.006";
  std::string table =
      "specimen,shape,length_m,width_m,thickness_m,mass_kg,recording,operator,date,temperature_c,support,device\n";
  const double young_gpa[] = {210.0, 211.0, 209.0, 210.5, 260.0};
  for (int i = 0; i < 5; ++i) {
    const std::string name = "bar" + std::to_string(i + 1);
    write_bar(scratch, name + ".wav", dims, 1e9 * young_gpa[i]);
    table += name + ",bar,0.1,0.02,0.006," + std::to_string(0.1 * 0.02 * 0.006 * 7850.0) + "," + name +
             ".wav,A. Tester,2026-11-27,21,foam,microphone\n";
  }
  scratch.write("bars.csv", table);
  const RunResult run = run_klang("iet bars.csv -o out", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json result = read_json(scratch.path() / "out/iet.json");
  EXPECT_NE(run.out.find("(n = 4, without the tolerances of dimensions and mass)"), std::string::npos) << run.out;
  for (int i = 0; i < 5; ++i) {
    const json& row = result["specimens"][static_cast<std::size_t>(i)];
    EXPECT_NEAR(row["e_model_pa"].get<double>(), 1e9 * young_gpa[i], 0.002e9 * young_gpa[i]) << row;
    EXPECT_NEAR(row["g_model_pa"].get<double>(), 1e9 * young_gpa[i] / 2.56, 0.002e9 * young_gpa[i]) << row;
    EXPECT_NEAR(row["e_e1876_pa"].get<double>(), 1e9 * young_gpa[i], 0.005e9 * young_gpa[i]) << row;
    EXPECT_NEAR(row["g_e1876_pa"].get<double>(), 1e9 * young_gpa[i] / 2.56, 0.005e9 * young_gpa[i]) << row;
    EXPECT_NEAR(row["q_inverse_flexural"].get<double>(), 2e-3, 2e-5);
    EXPECT_EQ(row["outlier"], i == 4) << row;
  }
  for (const json& line : result["summary"]) {
    if (line["quantity"] != "e_model_pa") continue;
    EXPECT_EQ(line["shape"], "bar");
    EXPECT_EQ(line["n"], 4);
    EXPECT_NEAR(line["mean"].get<double>(), 210.125e9, 0.2e9);
    EXPECT_NEAR(line["std"].get<double>(), 0.8539e9, 0.02e9);  // of 210, 211, 209, 210.5 with n - 1
  }
  const std::string page = slurp(scratch.path() / "out/report.html");
  for (const char* words :
       {"A. Tester", "2026-11-27", "foam", "microphone", "without the tolerances of dimensions and mass"})
    EXPECT_NE(page.find(words), std::string::npos) << words;
  scratch.write("bad.csv", "specimen,shape,lenght_m\n");
  expect_refused(scratch, "iet bad.csv -o none", {"bad.csv", "did you mean length_m"});
  scratch.write("bad.csv", "specimen,shape,diameter_m,thickness_m,mass_kg,recording\na,disk,1,1,1,bar1.wav\n");
  expect_refused(scratch, "iet bad.csv -o none", {"line 2", "did you mean disc"});
}

}  // namespace
}  // namespace klang::test
