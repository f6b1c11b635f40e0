// The contract of the command line: keys, units and exit codes that others script against.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"
#include "tests/places.hpp"

using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;
using nlohmann::json;

TEST(KlangModes, ReferenceTubesTetrahedraMatchTheRitzSolutionWithin200Ppm) {
  const Scratch scratch;
  const auto result = run_klang(
      "modes --method tetrahedra --shape tube --dims length_m=0.505,outer_radius_m=0.0125,wall_m=0.001 "
      "--material lame_lambda_pa=4.98e10,lame_mu_pa=2.57e10,density_kg_m3=2700 --count 12 --json m.json",
      scratch.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json modes = read_json(scratch.path() / "m.json");
  EXPECT_EQ(modes["n_rigid_modes"], 6);
  EXPECT_EQ(modes["none_missing"], true);
  EXPECT_EQ(modes["element"], "p2");
  EXPECT_EQ(modes["modes"].size(), 12U);
  EXPECT_GT(modes["peak_memory_bytes"].get<double>(), 1e6);
  EXPECT_TRUE(modes["wall_time_s"].contains("total"));
  // tests/reference/chimes.json: tubes[0].ritz3d_bending[0]; the first bending pair is modes 0 and 1.
  const double ritz_hz = 587.8831103242787;
  for (const int i : {0, 1}) {
    EXPECT_LE(std::abs(modes["modes"][i]["frequency_hz"].get<double>() / ritz_hz - 1.0), 2e-4);
    EXPECT_LE(modes["modes"][i]["relative_residual"].get<double>(), 1e-6);
    EXPECT_GT(modes["modes"][i]["mesh_relative_error"].get<double>(), 0);
    EXPECT_LE(modes["modes"][i]["mesh_relative_error"].get<double>(), 2e-4);
  }
}

TEST(KlangModes, TubeGoesByHarmonicsUnlessAMeshOrASupportIsAskedFor) {
  const Scratch scratch;
  const std::string tube =
      "modes --shape tube --dims length_m=0.1,outer_radius_m=0.0125,wall_m=0.002 --count 2 --json m.json ";
  for (const auto& [options, method] : {std::pair{"", "harmonics"},
                                        {"--method tetrahedra", "tetrahedra"},
                                        {"--max-edge-m 0.02", "tetrahedra"},
                                        {"--support clamped:z=-0.05", "tetrahedra"}}) {
    ASSERT_EQ(run_klang(tube + options, scratch.path()).exit_code, 0) << options;
    EXPECT_EQ(read_json(scratch.path() / "m.json")["method"], method) << options;
  }
  const auto refused = run_klang(tube + "--method harmonics --lumped-mass", scratch.path());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("--method"), std::string::npos) << refused.err;
}

TEST(KlangModes, APlaneThroughTheMiddleOfTheBodyIsDoubtedAndItsEndIsNot) {
  const Scratch scratch;
  const std::string bar =
      "modes --shape box --dims length_m=0.1,width_m=0.02,height_m=0.01 --count 1 --json m.json --support clamped:";
  const auto middle = run_klang(bar + "x=0", scratch.path());
  EXPECT_EQ(middle.exit_code, 0) << middle.err;
  EXPECT_NE(middle.err.find("cuts through the body"), std::string::npos) << middle.err;
  EXPECT_NE(read_json(scratch.path() / "m.json")["warnings"].dump().find("cuts through the body"), std::string::npos);
  EXPECT_EQ(run_klang(bar + "x=min", scratch.path()).err.find("cuts through"), std::string::npos);
}

TEST(KlangModes, SameRunGivesTheSameFrequenciesOnAnyNumberOfThreads) {
  const Scratch scratch;
  const std::string run =
      "modes --shape tube --dims length_m=0.3,outer_radius_m=0.0125,wall_m=0.001 --material aluminium --count 6 ";
  ASSERT_EQ(run_klang(run + "--threads 1 --json a.json", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang(run + "--threads 2 --json b.json", scratch.path()).exit_code, 0);
  const json a = read_json(scratch.path() / "a.json"), b = read_json(scratch.path() / "b.json");
  for (int i = 0; i < 6; ++i) {
    const double fa = a["modes"][i]["frequency_hz"], fb = b["modes"][i]["frequency_hz"];
    EXPECT_LE(std::abs(fa / fb - 1.0), 1e-9);  // the solver's tolerance; BLAS sums in another order
  }
}

TEST(KlangBubbleFit, SyntheticTapGivesItsBubblesAndPitchConstants) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(std::string("dataset ") + klang::test::source_dir() +
                          "/datasets-synthetic/recipes/drops.toml -o made --seed 3",
                      scratch.path())
                .exit_code,
            0);
  const auto run =
      run_klang("bubble fit made/tap.wav --rise made/tap-rise.csv --phi0-m -0.01 --json d.json -o out", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json fit = read_json(scratch.path() / "d.json");
  ASSERT_EQ(fit["bubbles"].size(), 3u);
  const double radius_m[] = {0.0012, 0.0018, 0.0026},
               onset_s[] = {0.1, 0.5, 1.0};  // datasets-synthetic/recipes/drops.toml
  for (std::size_t i = 0; i < 3; ++i) {
    const json& bubble = fit["bubbles"][i];
    EXPECT_LE(std::abs(bubble["radius_m"].get<double>() / radius_m[i] - 1.0), 0.01);
    EXPECT_LE(std::abs(bubble["onset_s"].get<double>() - onset_s[i]), 0.002);
    EXPECT_GT(bubble["radius_std_m"].get<double>(), 0.0);
    EXPECT_GT(bubble["frequency_end_hz"].get<double>(), bubble["frequency_start_hz"].get<double>());
  }
  EXPECT_EQ(fit["pitch"]["status"], "fitted");
  EXPECT_EQ(fit["pitch"]["parameters"][0]["name"], "k_delta_per_m");
  EXPECT_LE(std::abs(fit["pitch"]["parameters"][0]["value"].get<double>() / 72.95 - 1.0), 0.1);
  EXPECT_LE(std::abs(fit["pitch"]["parameters"][1]["value"].get<double>() / 1.24 - 1.0), 0.1);
  for (const char* file : {"report.html", "bubbles.json", "recording.wav", "resynthesis.wav"})
    EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out" / file)) << file;
  EXPECT_EQ(run_klang("report out/bubbles.json", scratch.path()).exit_code, 0);
}

TEST(KlangBubbleFit, BadInputIsRefusedInOneLine) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(std::string("dataset ") + klang::test::source_dir() +
                          "/datasets-synthetic/recipes/drops.toml -o made --seed 3",
                      scratch.path())
                .exit_code,
            0);
  for (const char* bad :
       {"gone.wav", "made/tap.wav --rise gone.csv", "made/tap.wav --phi0-m 0.01", "made/tap.wav --band-hz 5000:200",
        "made/tap.wav --min-snr-db 3", "made/tap.wav --thermal warm", "made/truth.json"}) {
    const auto run = run_klang(std::string("bubble fit ") + bad + " -o out", scratch.path());
    EXPECT_EQ(run.exit_code, 2) << bad;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_FALSE(std::filesystem::exists(scratch.path() / "out")) << bad;
  }
}

TEST(KlangSynth, StrikeOfATubeSoundsAtItsModes) {
  const Scratch scratch;
  ASSERT_EQ(run_klang("modes --shape tube --dims length_m=0.3,outer_radius_m=0.0125,wall_m=0.001 --material aluminium "
                      "--count 6 -o tube.vtu",
                      scratch.path())
                .exit_code,
            0);
  ASSERT_EQ(
      run_klang("synth tube.vtu -o tube.wav --rayleigh-mass-per-s 8 --duration-s 1.5 --json s.json", scratch.path())
          .exit_code,
      0);
  ASSERT_EQ(run_klang("analyze tube.wav --json a.json", scratch.path()).exit_code, 0);
  const json synth = read_json(scratch.path() / "s.json"), analysis = read_json(scratch.path() / "a.json");
  ASSERT_GE(analysis["partials"].size(), 1U);
  const double f = analysis["partials"][0]["frequency_hz"], decay = analysis["partials"][0]["decay_per_s"];
  EXPECT_LE(std::abs(f / synth["modes"][0]["frequency_hz"].get<double>() - 1.0), 1e-4);
  EXPECT_LE(std::abs(decay - 4.0), 0.05);
}

TEST(KlangFit, OneFundamentalGivesEAndLeavesTheGivenPoissonsRatioWithoutAnInterval) {
  const Scratch scratch;
  scratch.write("d5.csv", "frequency_hz\n585.8\n");
  scratch.write("s.toml",
                "name = \"D5\"\n[material]\npreset = \"aluminium\"\n[[specimen]]\nname = \"D5\"\n"
                "shape = { kind = \"tube\", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }\n"
                "partials = \"d5.csv\"\n[fit]\nparameters = [\"youngs_modulus_pa\"]\n");
  const auto result = run_klang("fit s.toml -o out --no-pictures", scratch.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json fit = read_json(scratch.path() / "out/fit.json");
  EXPECT_EQ(fit["status"], "converged");
  ASSERT_EQ(fit["matches"].size(), 1U);
  EXPECT_LE(fit["matches"][0]["mode_index"].get<int>(), 1);
  for (const json& parameter : fit["parameters"]) {
    const bool fitted = parameter["name"] == "youngs_modulus_pa";
    EXPECT_EQ(parameter["identifiable"], fitted) << parameter;
    EXPECT_EQ(parameter["std"].is_number(), fitted) << parameter;
    EXPECT_EQ(parameter["ci95"].is_array(), fitted) << parameter;
    EXPECT_EQ(parameter["why"].get<std::string>().empty(), fitted) << parameter;
  }
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "out/report.html"));
}

TEST(KlangConverge, WritesTheStudyItsPageAndJUnitAndSaysPassed) {
  const Scratch scratch;
  const auto result = run_klang("converge synthesis --levels 4 --no-pictures -o out --json s.json", scratch.path());
  ASSERT_EQ(result.exit_code, 0) << result.err << result.out;
  const json study = read_json(scratch.path() / "out/study.json");
  EXPECT_EQ(study, read_json(scratch.path() / "s.json"));
  EXPECT_EQ(study["passed"], true);
  EXPECT_LE(std::abs(study["observed_order"].get<double>() - study["expected_order"].get<double>()), 0.1);
  ASSERT_EQ(study["levels"].size(), 4U);
  for (const json& level : study["levels"]) {
    EXPECT_TRUE(level.contains("h_m") || level.contains("n"));
    EXPECT_TRUE(level["error"].is_number());
  }
  for (const char* file : {"out/report.html", "out/junit.xml", "out/levels.csv", "out/figures/convergence.png"})
    EXPECT_TRUE(std::filesystem::exists(scratch.path() / file)) << file;
  // The page comes from study.json alone.
  std::filesystem::rename(scratch.path() / "out/report.html", scratch.path() / "first.html");
  ASSERT_EQ(run_klang("report out/study.json --no-pictures", scratch.path()).exit_code, 0);
  const auto bytes = [](const std::filesystem::path& path) {
    std::ifstream in(path, std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), {}};
  };
  EXPECT_EQ(bytes(scratch.path() / "out/report.html"), bytes(scratch.path() / "first.html"));
}

TEST(KlangConverge, OnlyRunsTheSeriesThatIsAskedFor) {
  const Scratch scratch;
  EXPECT_EQ(run_klang("converge fem --only bar-p2 --levels 3 --no-pictures -o bar", scratch.path()).exit_code, 0);
  const json study = read_json(scratch.path() / "bar/study.json");
  ASSERT_EQ(study["series"].size(), 1U);
  EXPECT_EQ(study["series"][0]["id"], "bar-p2");
  EXPECT_TRUE(study["levels"][0]["h_m"].is_number());
}

TEST(KlangConverge, BadInputIsOneLineAndLeavesNothing) {
  const Scratch scratch;
  for (const char* arguments :
       {"converge fluid -o out", "converge fem --levels 2 -o out", "converge fem --only x -o out", "converge fem",
        "converge synthesis -o /proc/nowhere/out"}) {
    const auto result = run_klang(arguments, scratch.path());
    EXPECT_EQ(result.exit_code, 2) << arguments;
    EXPECT_EQ(result.err_lines(), 1) << result.err;
    EXPECT_TRUE(scratch.files().empty()) << arguments;
  }
}

TEST(KlangConverge, ControlCEndsWith130AndNothingWritten) {
  const Scratch scratch;
  const auto result = run_klang("converge fem -o out", scratch.path(), "timeout --preserve-status -s INT 1");
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(scratch.files().empty());
}

TEST(KlangTransfer, SphereMatchesTheReferenceAndHasTheKeysOfTheContract) {
  const Scratch scratch;
  const auto result =
      run_klang("transfer --sphere dipole --radius-m 0.05 --ka 1 --elements 500 --json s.json", scratch.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json sphere = read_json(scratch.path() / "s.json");
  EXPECT_LE(sphere["surface_pressure_relative_error"].get<double>(), 0.01);
  // tests/reference/radiation.json: ka 1, dipole_cos, M_n0_unit_velocity_SI
  const json& dipole = sphere["multipoles"][2];
  EXPECT_EQ(dipole["n"], 1);
  EXPECT_EQ(dipole["m"], 0);
  EXPECT_LE(std::abs(dipole["re"].get<double>() / 375.8531198039518 - 1.0), 0.005);
  EXPECT_LE(std::abs(dipole["im"].get<double>() / -40.4270105278931 - 1.0), 0.005);
}

TEST(KlangTransfer, ModalModelGivesAnEntryForEveryMode) {
  const Scratch scratch;
  ASSERT_EQ(
      run_klang("modes --shape box --dims length_m=0.1,width_m=0.03,height_m=0.01 --count 2 -o m.vtu", scratch.path())
          .exit_code,
      0);
  const auto result = run_klang("transfer m.vtu -o t.vtu --json t.json", scratch.path());
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const json transfer = read_json(scratch.path() / "t.json");
  ASSERT_EQ(transfer["modes"].size(), 2U);
  for (int i = 0; i < 2; ++i) {
    const json& mode = transfer["modes"][i];
    EXPECT_EQ(mode["index"], i);
    EXPECT_GT(mode["frequency_hz"].get<double>(), 1000.0);
    EXPECT_GE(mode["order"].get<int>(), 2);
    EXPECT_GT(mode["radiated_power_w"].get<double>(), 0.0);
    EXPECT_EQ(mode["decay_radiation_per_s"], mode["radiated_power_w"]);
    EXPECT_GE(mode["bem_elements"].get<int>(), 100);
    EXPECT_LE(mode["residual"].get<double>(), 1e-9);
  }
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"m.vtu", "t.json", "t.vtu"}));
}

TEST(KlangHelp, EverySubcommandHasAnExample) {
  const Scratch scratch;
  for (const char* name : {"mesh", "modes", "analyze", "converge", "fit", "tune", "synth", "transfer", "regress make",
                           "regress check", "dataset", "report", "doctor"}) {
    const auto help = run_klang(std::string(name) + " --help", scratch.path());
    EXPECT_EQ(help.exit_code, 0) << name;
    EXPECT_NE(help.out.find("Example"), std::string::npos) << name;
    EXPECT_NE(help.out.find("--json"), std::string::npos) << name;
  }
}

TEST(KlangDoctor, ListsTheLibrariesAndThreads) {
  const Scratch scratch;
  ASSERT_EQ(run_klang("doctor --json d.json", scratch.path()).exit_code, 0);
  const json doctor = read_json(scratch.path() / "d.json");
  EXPECT_GE(doctor["threads"].get<int>(), 1);
  for (const char* library : {"Ceres", "Eigen", "FFTW", "libsndfile", "Spectra", "TetGen"}) {
    EXPECT_TRUE(doctor["libraries"].contains(library)) << library;
  }
}

TEST(KlangInterrupt, TwoSignalsInARowTidyUpAsOneDoes) {
  const Scratch scratch;
  const auto result = run_klang("converge fem -o out", scratch.path(),
                                "sh -c '\"$@\" & p=$!; until [ -n \"$(ls -A)\" ]; do sleep 0.02; done; "
                                "kill -INT $p; sleep 0.01; kill -INT $p; wait $p' sh");
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(scratch.files().empty());
}

TEST(KlangInterrupt, ControlCEndsWith130AndNothingWritten) {
  const Scratch scratch;
  const auto result =
      run_klang("modes --shape box --dims length_m=0.3,width_m=0.3,height_m=0.02 --refine 3 --count 50 --json m.json",
                scratch.path(), "timeout --preserve-status -s INT 1");
  EXPECT_EQ(result.exit_code, 130) << result.err;
  EXPECT_TRUE(scratch.files().empty());
}

// mesh_signals_ignored
TEST(KlangInterrupt, EverySignalEndsAMeshThatTheLibraryWillNotStopAndNothingIsLeft) {
  const Scratch scratch;
  // A surface whose tetrahedra take much longer than the signal waits.
  std::string obj;
  constexpr int kAround = 300;
  for (int i = 0; i < kAround; ++i)
    for (int k = 0; k < kAround; ++k) {
      const double u = 2.0 * M_PI * i / kAround, v = 2.0 * M_PI * k / kAround, r = 0.05 + 0.02 * std::cos(v);
      obj += "v " + std::to_string(r * std::cos(u)) + " " + std::to_string(r * std::sin(u)) + " " +
             std::to_string(0.02 * std::sin(v)) + "\n";
    }
  const auto at = [](int i, int k) { return std::to_string(1 + (i % kAround) * kAround + k % kAround); };
  for (int i = 0; i < kAround; ++i)
    for (int k = 0; k < kAround; ++k)
      obj += "f " + at(i, k) + " " + at(i + 1, k) + " " + at(i + 1, k + 1) + " " + at(i, k + 1) + "\n";
  scratch.write("ring.obj", obj);
  for (const auto& [name, code] : {std::pair("INT", 130), std::pair("TERM", 143), std::pair("HUP", 129)}) {
    const auto result = run_klang("mesh ring.obj -o ring.vtu", scratch.path(),
                                  std::string("timeout --preserve-status -k 20 -s ") + name + " 1");
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_NE(result.err.find("interrupted"), std::string::npos);
    EXPECT_EQ(scratch.files(), (std::vector<std::string>{"ring.obj"}));
  }
}

TEST(KlangInterrupt, WhatAKilledRunLeftIsGoneAfterTheNext) {
  const Scratch scratch;
  run_klang("converge fem -o out", scratch.path(),
            "sh -c '\"$@\" & p=$!; until [ -n \"$(ls -A)\" ]; do sleep 0.02; done; kill -KILL $p; wait $p' sh");
  ASSERT_FALSE(scratch.files().empty() && std::filesystem::is_empty(scratch.path()));
  scratch.write(".mine.tmp-notes", "kept");
  ASSERT_EQ(run_klang("mesh box --dims length_m=0.1,width_m=0.1,height_m=0.1 -o b.vtu", scratch.path()).exit_code, 0);
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{".mine.tmp-notes", "b.vtu"}));
}

TEST(KlangInput, ADeviceWithoutEndIsRefusedAndAPipeIsRead) {
  const Scratch scratch;
  const auto zero = run_klang("report /dev/zero -o out", scratch.path(), "timeout 60");
  EXPECT_EQ(zero.exit_code, 2) << zero.err;
  EXPECT_TRUE(scratch.files().empty());
}

TEST(KlangModes, CountsFromTheLowestUpAndSaysWhatLiesBelowABand) {
  const Scratch scratch;
  // A steel rod of 3 m: free bending from 2.5 Hz on.
  const std::string rod = "modes --shape rod --dims length_m=3,radius_m=0.0025 --material steel --no-mesh-error ";
  ASSERT_EQ(run_klang(rod + "--count 2 --json low.json", scratch.path()).exit_code, 0);
  const json low = read_json(scratch.path() / "low.json");
  // Euler and Bernoulli: 22.3733 / (2 pi) (r / 2) sqrt(E / rho) / L^2
  const double lowest_hz = 22.3733 / (2.0 * M_PI) * 0.00125 * std::sqrt(210e9 / 7850.0) / 9.0;
  EXPECT_LE(std::abs(low["modes"][0]["frequency_hz"].get<double>() / lowest_hz - 1.0), 0.05);
  const auto banded = run_klang(rod + "--band-hz 20:40 --json band.json", scratch.path());
  ASSERT_EQ(banded.exit_code, 0) << banded.err;
  EXPECT_NE(banded.out.find("6 modes below the band"), std::string::npos) << banded.out;
  EXPECT_EQ(read_json(scratch.path() / "band.json")["n_below_band"], 6);
}
