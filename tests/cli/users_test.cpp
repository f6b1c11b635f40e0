// What people type, and what they get: words that are nearly right, help, global options anywhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
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

TEST(DidYouMean, NearWordsOfEveryListAreNamed) {
  const Scratch scratch;
  expect_refused(scratch, "converge fmem", {"unknown study", "did you mean fem"});
  expect_refused(scratch, kSmallTube + "--method polinomial", {"did you mean polynomial"});
  expect_refused(scratch, kSmallTube + "--support clampd:x=min", {"did you mean clamped"});
  expect_refused(scratch, kSmallTube + "--material glass", {"did you mean soda_lime_glass"});
  expect_refused(scratch, "bubble info --radius-m 1e-3 --thermal prosperety", {"did you mean prosperetti"});
  expect_refused(scratch, "bubble info --radius-m 1e-3 --literature papr", {"did you mean paper"});
  const std::string tune = "tune --shape rod --dims length_m=0.2,radius_m=0.005 --material ";
  expect_refused(scratch, tune + "glass --vary length_m --target E5", {"did you mean soda_lime_glass"});
  expect_refused(scratch, tune + "steel --vary lenght_m --target E5", {"did you mean length_m"});
  expect_refused(scratch, tune + "steel --vary length_m --target humm=E5", {"did you mean hum"});
  expect_refused(scratch, tune + "steel --vary length_m --target \"bendin 1=E5\"", {"did you mean bending"});
  scratch.write("p.csv", "frequency_hz,kind\n440,decayng\n");
  scratch.write("s.toml",
                "[material]\npreset = \"steel\"\n[[specimen]]\nname = \"a\"\nshape = { kind = \"rod\", length_m = 0.2, "
                "radius_m = 0.005 }\npartials = "
                "\"p.csv\"\n[fit]\nparameters = [\"youngs_modulus_pa\"]\n");
  expect_refused(scratch, "fit s.toml -o out", {"p.csv", "unknown kind", "did you mean decaying"});
  scratch.write(
      "scene.toml",
      "[[material]]\nname = \"clay\"\npreset = \"porcelain\"\ndamping = { model = \"loss_facter\", loss_factor = "
      "1e-3 }\n");
  expect_refused(scratch, "scene check scene.toml", {"scene.toml:4", "did you mean loss_factor"});
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
  EXPECT_EQ(out("help help"), out("--help"));
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

/// Decaying sines as a WAV of one second.
std::string rung_wav(const std::vector<double>& frequencies_hz, double decay_per_s = 6.0) {
  constexpr int kRate = 16000;
  std::vector<float> samples(kRate, 0.0F);
  for (int i = 800; i < kRate; ++i) {
    const double t = (i - 800.0) / kRate;
    for (const double f : frequencies_hz)
      samples[static_cast<std::size_t>(i)] +=
          static_cast<float>(0.1 * std::exp(-decay_per_s * t) * std::sin(2.0 * M_PI * f * t));
  }
  return wav_bytes(samples, 1, kRate);
}

TEST(Notes, PartialsHaveNoteAndCentsInJsonTableAndTerminal) {
  const Scratch scratch;
  scratch.write("tap.wav", rung_wav({440.0, 1000.0}));
  const RunResult run = run_klang("analyze tap.wav --a4-hz 443 --json a.json --csv p.csv -o out", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json partials = read_json(scratch.path() / "a.json")["partials"];
  ASSERT_EQ(partials.size(), 2U);
  EXPECT_EQ(partials[0]["note"], "A4");
  EXPECT_NEAR(partials[0]["cents"].get<double>(), 1200.0 * std::log2(440.0 / 443.0), 0.05);
  EXPECT_EQ(partials[1]["note"], "B5");  // 987.77 Hz by 440
  EXPECT_NEAR(partials[1]["cents"].get<double>(), 1200.0 * std::log2(1000.0 / (443.0 * std::exp2(14.0 / 12.0))), 0.05);
  EXPECT_NE(run.out.find("A4"), std::string::npos) << run.out;
  for (const char* file : {"p.csv", "out/partials.csv"}) {
    std::ifstream csv(scratch.path() / file);
    std::string head, row;
    std::getline(csv, head);
    std::getline(csv, row);
    EXPECT_NE(head.find(",note,cents"), std::string::npos) << file << head;
    EXPECT_NE(row.find(",A4,"), std::string::npos) << file << row;
  }
  expect_refused(scratch, "analyze tap.wav --a4-hz 20", {"--a4-hz", "300"});
}

TEST(Notes, ABellsPartialsAreNamed) {
  const Scratch scratch;
  scratch.write("bell.wav", rung_wav({220, 440, 528, 660, 880, 1320, 1760}, 3.0));
  ASSERT_EQ(run_klang("analyze bell.wav --bell --json a.json", scratch.path()).exit_code, 0);
  const nlohmann::json bell = read_json(scratch.path() / "a.json")["bell"];
  const std::pair<const char*, double> wanted[] = {{"hum_hz", 220},   {"prime_hz", 440},   {"tierce_hz", 528},
                                                   {"quint_hz", 660}, {"nominal_hz", 880}, {"strike_note_hz", 440}};
  for (const auto& [key, value] : wanted) EXPECT_NEAR(bell[key].get<double>(), value, 0.05) << key;
  EXPECT_EQ(bell["strike_note"], "A4");
}

TEST(Files, ATableGoesToStandardOutputAlone) {
  const Scratch scratch;
  scratch.write("tap.wav", rung_wav({440.0}));
  const RunResult run = run_klang("analyze tap.wav --csv -", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out.substr(0, 13), "frequency_hz,");
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 2) << run.out;
  expect_refused(scratch, "analyze tap.wav --csv - --json -", {"--csv"});
}

constexpr const char* kTwoRods =
    "[material]\nyoungs_modulus_pa = 7e10\npoissons_ratio = 0.33\ndensity_kg_m3 = 2700\n"
    "[[specimen]]\nname = \"long\"\nshape = { kind = \"rod\", length_m = 0.2, radius_m = 0.005 }\npartials = "
    "\"partials.csv\"\n"
    "[[specimen]]\nname = \"short\"\nshape = { kind = \"rod\", length_m = 0.1, radius_m = 0.005 }\npartials = "
    "\"partials.csv\"\n"
    "[fit]\nparameters = [\"youngs_modulus_pa\"]\n";

TEST(Files, RowsOfATableAreChosenBySpecimenAndAFitGoesOnAsMaterial) {
  const Scratch scratch;
  const std::string material = " --material youngs_modulus_pa=7.1e10,poissons_ratio=0.33,density_kg_m3=2700 ";
  std::string table = "specimen,frequency_hz,frequency_std_hz\n";
  for (const auto& [name, length] : {std::pair{"long", "0.2"}, {"short", "0.1"}}) {
    const std::string rod = "modes --shape rod --dims length_m=" + std::string(length) + ",radius_m=0.005 --count 8";
    ASSERT_EQ(run_klang(rod + material + "--json m.json", scratch.path()).exit_code, 0);
    const nlohmann::json modes = read_json(scratch.path() / "m.json")["modes"];
    for (const auto& mode : modes) table += std::string(name) + "," + mode["frequency_hz"].dump() + ",0.1\n";
  }
  scratch.write("partials.csv", table);
  scratch.write("rods.toml", kTwoRods);
  const RunResult fit = run_klang("fit rods.toml -o out --no-pictures", scratch.path());
  ASSERT_EQ(fit.exit_code, 0) << fit.err;
  const nlohmann::json found = read_json(scratch.path() / "out/fit.json");
  EXPECT_NEAR(found["material"]["youngs_modulus_pa"].get<double>(), 7.1e10, 1e7);
  EXPECT_GE(found["matches"].size(), 12U);  // of 16; pairs of bending count once
  // The table that the page offers, and fit.json itself, go in again; so does the fit as a material.
  ASSERT_EQ(
      run_klang("modes --shape rod --dims length_m=0.2,radius_m=0.005 --count 1 --material out/fit.json --json m.json",
                scratch.path())
          .exit_code,
      0);
  const double again_hz = read_json(scratch.path() / "m.json")["modes"][0]["frequency_hz"];
  EXPECT_NEAR(again_hz, found["predicted"][0]["frequency_hz"].get<double>(), 1e-4 * again_hz);
  for (const char* source : {"out/partials.csv", "out/fit.json"}) {
    std::string text = kTwoRods;
    for (std::size_t at = 0; (at = text.find("\"partials.csv", at)) != std::string::npos; at += 20)
      text.replace(at, 14, "\"" + std::string(source) + "\"");
    const std::size_t material = text.find("youngs_modulus_pa = 7e10");
    text.replace(material, text.find("[[specimen]]") - material, "fit = \"out/fit.json\"\n");
    scratch.write("again.toml", text);
    const RunResult run = run_klang("fit again.toml -o again --no-pictures", scratch.path());
    ASSERT_EQ(run.exit_code, 0) << source << run.err;
    EXPECT_NEAR(read_json(scratch.path() / "again/fit.json")["material"]["youngs_modulus_pa"].get<double>(), 7.1e10,
                1e7);
  }
  std::string renamed = kTwoRods;
  renamed.replace(renamed.find("\"short\""), 7, "\"shortt\"");
  scratch.write("renamed.toml", renamed);
  expect_refused(scratch, "fit renamed.toml -o none", {"partials.csv", "shortt", "did you mean short"});
}

}  // namespace
}  // namespace klang::test
