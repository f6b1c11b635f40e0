// klang listen and watch, and responses at several places through klang analyze.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/foundation/base/output_file.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

namespace klang::test {
namespace {

constexpr unsigned kRate = 16000;

/// Taps of 880 Hz (of a bar: its first flexural frequency) and, fainter, of another frequency at these times over faint noise.
std::vector<float> tap_samples(const std::vector<double>& times_s, double length_s, double other_hz = 0.0) {
  std::vector<float> samples(static_cast<std::size_t>(length_s * kRate));
  unsigned state = 1;
  for (float& sample : samples) {
    state = state * 1664525u + 1013904223u;
    sample = 2e-5f * (static_cast<float>(state >> 8) / 8388608.0f - 1.0f);
  }
  for (const double strike : times_s) {
    for (std::size_t i = static_cast<std::size_t>(strike * kRate); i < samples.size(); ++i) {
      const double t = static_cast<double>(i) / kRate - strike;
      samples[i] += static_cast<float>(0.4 * std::exp(-9 * t) * std::sin(2 * M_PI * 880 * t));
      if (other_hz > 0.0) samples[i] += static_cast<float>(0.1 * std::exp(-12 * t) * std::sin(2 * M_PI * other_hz * t));
    }
  }
  return samples;
}

std::string taps(const std::vector<double>& times_s, double length_s, double other_hz = 0.0) {
  return wav_bytes(tap_samples(times_s, length_s, other_hz), 1, kRate);
}

constexpr const char* kBarOptions = " --shape bar --length-m 0.18 --width-m 0.03 --thickness-m 0.0055 --mass-kg 0.0802";

/// E and G of the tests' bar by ASTM E1876, without the terms in (t / L)^4, which are below 1e-4.
double bar_youngs_modulus_pa(double flexural_hz, double nu) {
  const double slender = 0.0055 / 0.18;
  const double t1 = 1 + 6.585 * (1 + 0.0752 * nu + 0.8109 * nu * nu) * slender * slender;
  return 0.9465 * 0.0802 * flexural_hz * flexural_hz / 0.03 / std::pow(slender, 3) * t1;
}
double bar_shear_modulus_pa(double torsional_hz) {
  const double flat = 0.03 / 0.0055, wide = 0.03 / 0.18;
  const double r =
      (1 + flat * flat) / (4 - 2.521 / flat * (1 - 1.991 / (std::exp(M_PI * flat) + 1))) * (1 + 0.00851 * wide * wide) -
      0.060 * std::pow(wide, 1.5) * std::pow(flat - 1, 2);
  return 4 * 0.18 * 0.0802 * torsional_hz * torsional_hz / (0.03 * 0.0055) * r;
}

TEST(Listen, EachTapIsATakeWithItsNoteAndItsFile) {
  const Scratch scratch;
  scratch.write("session.wav", taps({0.5, 2.0, 3.5}, 5.0));
  const RunResult run = run_klang("listen --input session.wav --takes 2 -o out --json r.json", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json takes = read_json(scratch.path() / "r.json")["takes"];
  ASSERT_EQ(takes.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(takes[i]["strike_s"].get<double>(), 0.5 + 1.5 * static_cast<double>(i), 0.02);
    EXPECT_EQ(takes[i]["note"], "A5");
    EXPECT_NEAR(takes[i]["cents"].get<double>(), 0.0, 1.0);
    EXPECT_NEAR(takes[i]["partials"][0]["frequency_hz"].get<double>(), 880.0, 0.5);
    EXPECT_TRUE(std::filesystem::is_regular_file(scratch.path() / "out" / takes[i]["file"].get<std::string>()));
  }
}

TEST(Listen, OfABarWhoseDimensionsAreGivenEAndGStandBesideEachTap) {
  const Scratch scratch;
  scratch.write("session.wav", taps({0.5, 2.0, 3.5}, 5.0, 2900.0));
  const RunResult run = run_klang("listen --input session.wav -o out" + std::string(kBarOptions), scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = read_json(scratch.path() / "out/listen.json");
  ASSERT_EQ(result["moduli"].size(), 3u);
  for (const nlohmann::json& row : result["moduli"]) {
    const double young_pa = bar_youngs_modulus_pa(880.0, row["nu_e1876"]);
    EXPECT_NEAR(row["e_e1876_pa"].get<double>() / young_pa, 1.0, 5e-4) << run.out;
    EXPECT_NEAR(row["g_e1876_pa"].get<double>() / bar_shear_modulus_pa(2900.0), 1.0, 5e-4) << run.out;
    EXPECT_NEAR(row["e_model_pa"].get<double>() / young_pa, 1.0, 0.01);
  }
  EXPECT_NE(run.out.find("without the tolerances of dimensions and mass"), std::string::npos) << run.out;
  // From a specimens' file it is the same.
  scratch.write(
      "bars.csv",
      "specimen,shape,length_m,width_m,thickness_m,mass_kg\nA,bar,0.1,0.02,0.01,0.05\nB,bar,0.18,0.03,0.0055,0.0802\n");
  const RunResult named = run_klang("listen --input session.wav -o named --specimen bars.csv --name B", scratch.path());
  ASSERT_EQ(named.exit_code, 0) << named.err;
  const nlohmann::json again = read_json(scratch.path() / "named/listen.json");
  EXPECT_EQ(again["moduli"][0]["e_e1876_pa"], result["moduli"][0]["e_e1876_pa"]);
  EXPECT_EQ(again["moduli"][0]["specimen"], "B");
  EXPECT_TRUE(std::filesystem::is_regular_file(scratch.path() / "named/iet.csv"));
  expect_refused(scratch, "listen --input session.wav -o bad --specimen bars.csv", {"--name"});
  expect_refused(scratch, "listen --input session.wav -o bad --specimen bars.csv --name C", {"--name"});
  expect_refused(scratch, "listen --input session.wav -o bad --length-m 0.1 --mass-kg 1", {"--shape"});
  expect_refused(scratch, "listen --input session.wav -o bad --shape bar --length-m 0.1 --mass-kg 1", {"width_m"});
  expect_refused(scratch, "listen --input session.wav -o bad --shape rod --length-m 0.1 --diameter-m 0.01", {"mass"});
}

#ifdef KLANG_FAKE_PORTAUDIO
TEST(Listen, OfADeviceEachTapIsSaidWhileTheNextIsWaitedFor) {
  const Scratch scratch;
  const std::vector<float> samples = tap_samples({0.7, 2.4, 3.3, 7.0}, 9.0, 2900.0);
  scratch.write("played.raw", {reinterpret_cast<const char*>(samples.data()), samples.size() * sizeof(float)});
  const std::string fake =
      "LD_PRELOAD=" KLANG_FAKE_PORTAUDIO " KLANG_FAKE_INPUT=" + (scratch.path() / "played.raw").string();
  const RunResult run =
      run_klang("listen --device Fake --takes 3 -o out" + std::string(kBarOptions), scratch.path(), fake);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json result = read_json(scratch.path() / "out/listen.json");
  ASSERT_EQ(result["takes"].size(), 3u) << run.out;  // the fourth is not waited for
  const std::vector<double> strikes_s{0.7, 2.4, 3.3};
  for (std::size_t i = 0; i < 3; ++i) {
    const nlohmann::json& take = result["takes"][i];
    EXPECT_NEAR(take["strike_s"].get<double>(), strikes_s[i], 0.01);
    EXPECT_EQ(take["note"], "A5");
    EXPECT_NEAR(take["partials"][0]["frequency_hz"].get<double>(), 880.0, 0.5);
    const nlohmann::json& row = result["moduli"][i];
    EXPECT_NEAR(row["e_e1876_pa"].get<double>() / bar_youngs_modulus_pa(880.0, row["nu_e1876"]), 1.0, 2e-3);
  }
  const RunResult all = run_klang("listen --device Fake --longest-s 9 -o all", scratch.path(), fake);
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_EQ(read_json(scratch.path() / "all/listen.json")["takes"].size(), 4u) << all.out;
}
#endif

TEST(Listen, WithoutATapNothingIsWritten) {
  const Scratch scratch;
  scratch.write("quiet.wav", taps({}, 2.0));
  const RunResult run = run_klang("listen --input quiet.wav -o out", scratch.path());
  EXPECT_EQ(run.exit_code, 3) << run.err;
  EXPECT_EQ(run.err_lines(), 1) << run.err;
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "out"));
}

TEST(Watch, SurvivesBrokenFilesAndWaitsUntilAFileHasStoppedGrowing) {
  const Scratch scratch;
  std::filesystem::create_directories(scratch.path() / "in");
  const std::string whole = taps({0.2}, 2.0);
  scratch.write("in/a-broken.wav", "RIFF and no more");
  scratch.write("in/empty.wav", "");
  scratch.write("in/head-only.wav", whole.substr(0, 44));
  scratch.write("in/grows.wav", whole.substr(0, whole.size() / 2));
  std::thread later([&] {
    for (int i = 1; i <= 6; ++i) {  // faster than --settled-s
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      scratch.write("in/grows.wav",
                    whole.substr(0, whole.size() / 2 + static_cast<std::size_t>(i) * whole.size() / 12));
    }
    scratch.write("in/grows.wav", whole);
  });
  const RunResult run = run_klang("watch in -o out --every-s 0.1 --settled-s 2 --for-s 12", scratch.path());
  later.join();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("a-broken.wav"), std::string::npos) << run.err;
  for (const char* name : {"in/empty.wav: is empty", "head-only.wav"}) {  // one line each
    EXPECT_NE(run.err.find(name), std::string::npos) << run.err;
    EXPECT_EQ(run.err.find(name), run.err.rfind(name)) << run.err;
  }
  EXPECT_EQ(run.err.find("grows.wav"), std::string::npos) << "half a file was read: " << run.err;
  const nlohmann::json analysis = read_json(scratch.path() / "out/grows/analysis.json");
  EXPECT_EQ(analysis["kind"], "analysis");
  EXPECT_NEAR(analysis["partials"][0]["frequency_hz"].get<double>(), 880.0, 0.5);
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "out/a-broken"));
}

struct Line {
  double low_hz, step_hz;
  int n;
};

/// Dataset 58, accelerance: modes with these frequencies, decays and shapes over the places, struck at the first.
std::string universal_file(const Line& lines, const std::vector<double>& hz, const std::vector<double>& decay,
                           const std::vector<std::vector<double>>& shapes) {
  using Complex = std::complex<double>;
  std::string text;
  char part[96];
  for (std::size_t place = 0; place < shapes.size(); ++place) {
    text += "    -1\n    58\nNONE\nNONE\nNONE\nNONE\nNONE\n    4         0    0         0       NONE         " +
            std::to_string(place + 1) + "   3       NONE         1   3\n";
    std::snprintf(part, sizeof part, "         6%10d         1  %11.5E  %11.5E  0.00000E+00\n", lines.n, lines.low_hz,
                  lines.step_hz);
    text += part;
    text +=
        "        18    0    0    0            Frequency                   Hz\n"
        "        12    0    0    0         Acceleration                m/s^2\n"
        "        13    0    0    0                Force                    N\n"
        "         0    0    0    0                 NONE                 NONE\n";
    for (int i = 0; i < lines.n; ++i) {
      const Complex s(0, 2 * M_PI * (lines.low_hz + lines.step_hz * i));
      Complex h = 0;
      for (std::size_t mode = 0; mode < hz.size(); ++mode) {
        const double omega = 2 * M_PI * hz[mode];
        h += s * s * shapes[place][mode] * shapes[0][mode] /
             (s * s + 2 * decay[mode] * s + omega * omega + decay[mode] * decay[mode]);
      }
      std::snprintf(part, sizeof part, "%20.11E%20.11E", h.real(), h.imag());
      text += part;
      if (i % 2 == 1) text += "\n";
    }
    text += "    -1\n";
  }
  return text;
}

TEST(Responses, PolesAndShapesStandInTheAnalysis) {
  const Scratch scratch;
  const std::string file = universal_file({20, 0.25, 1200}, {100, 230}, {2, 5}, {{1.0, -0.7}, {0.5, 1.0}});
  scratch.write("hammer.uff", file);
  const RunResult run = run_klang("analyze hammer.uff -o out --csv p.csv", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json analysis = read_json(scratch.path() / "out/analysis.json");
  EXPECT_EQ(analysis["kind"], "analysis");
  EXPECT_EQ(analysis["responses"]["unit"], "m/s^2/N");  // as of MATLAB files
  const std::string page = read_file(scratch.path() / "out/report.html");
  for (const char* hook :
       {"data-figure=\"spectrum\"", "data-range-hz=\"0 ", "data-layer=\"measured\"", "data-layer=\"partials\"",
        "data-readout", "data-figure=\"stability\"", "Level [dB re 1 m/s^2/N]"})
    EXPECT_NE(page.find(hook), std::string::npos) << hook;
  ASSERT_EQ(analysis["partials"].size(), 2u) << run.out;
  EXPECT_NEAR(analysis["partials"][0]["frequency_hz"].get<double>(), 100.0, 1e-5);
  EXPECT_NEAR(analysis["partials"][1]["frequency_hz"].get<double>(), 230.0, 1e-5);
  EXPECT_NEAR(analysis["partials"][1]["decay_per_s"].get<double>(), 5.0, 1e-4);
  EXPECT_NEAR(analysis["partials"][0]["shape"][1][0].get<double>(), 0.5, 1e-6);
  EXPECT_NEAR(analysis["partials"][1]["shape"][0][0].get<double>(), -0.7, 1e-6);
  EXPECT_NEAR(analysis["partials"][1]["shape"][0][1].get<double>(), 0.0, 1e-6);
  EXPECT_FALSE(analysis["responses"]["stability"].empty());
  EXPECT_TRUE(std::filesystem::is_regular_file(scratch.path() / "out/report.html"));
  scratch.write("half.uff", file.substr(0, file.size() / 3));
  expect_refused(scratch, "analyze half.uff -o bad", {"half.uff", "truncated"});
  scratch.write("none.mat", "MATLAB no more");
  expect_refused(scratch, "analyze none.mat -o bad", {"none.mat"});
  expect_refused(scratch, "analyze hammer.uff --bell", {"--bell"});
}

TEST(Responses, PolesGoIntoAFitAsItsPartials) {
  const Scratch scratch;
  const RunResult modes = run_klang(
      "modes --shape rod --dims length_m=0.2,radius_m=0.005 --count 6 --quiet --json m.json --material "
      "youngs_modulus_pa=7.1e10,poissons_ratio=0.33,density_kg_m3=2700",
      scratch.path());
  ASSERT_EQ(modes.exit_code, 0) << modes.err;
  std::vector<double> hz;
  const nlohmann::json result = read_json(scratch.path() / "m.json");
  for (const auto& mode : result["modes"]) {
    const double f = mode["frequency_hz"];
    if (hz.empty() || f > hz.back() + 1.0) hz.push_back(f);
  }
  ASSERT_GE(hz.size(), 3u);
  hz.resize(3);
  scratch.write("rod.uff", universal_file({800, 2, 4000}, hz, {4, 10, 19}, {{1.0, 0.8, 0.6}}));
  const std::string rod =
      "[material]\nyoungs_modulus_pa = 7e10\npoissons_ratio = 0.33\ndensity_kg_m3 = 2700\n[[specimen]]\nname = "
      "\"rod\"\n"
      "shape = { kind = \"rod\", length_m = 0.2, radius_m = 0.005 }\n";
  const std::string wanted = "[fit]\nparameters = [\"youngs_modulus_pa\"]\n";
  scratch.write("rod.toml", rod + "partials = \"rod.uff\"\n" + wanted);
  const RunResult run = run_klang("fit rod.toml -o out --no-pictures", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json fit = read_json(scratch.path() / "out/fit.json");
  EXPECT_NEAR(fit["parameters"][0]["value"].get<double>(), 7.1e10, 1e6);
  EXPECT_EQ(fit["specimens"][0]["partials"].size(), 3u);
  scratch.write("wrong.toml", rod + "recording = \"rod.uff\"\n" + wanted);
  expect_refused(scratch, "fit wrong.toml -o none", {"partials = \"rod.uff\""});
}

TEST(Listen, ADeviceThatIsNotThereIsRefusedInOneLine) {
  expect_refused(Scratch(), "listen --device no-such-thing -o none", {"--device"});
}

TEST(Help, OfAMistypedCommandAsksWhatWasMeant) {
  const Scratch scratch;
  expect_refused(scratch, "stres --help", {"did you mean stress"});
  expect_refused(scratch, "bubble inof -h", {"did you mean info"});
  const RunResult run = run_klang("bubble info --radius-m 0.001 --verbose", scratch.path());
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

}  // namespace
}  // namespace klang::test
