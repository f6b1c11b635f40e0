// Bad input: exit code 2, one line on standard error, nothing written, earlier results untouched.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::test::expect_refused;
using klang::test::run_klang;
using klang::test::Scratch;
using klang::test::wav_bytes;

namespace {

std::vector<float> ringing(int n_frames, int n_channels, double rate_hz) {
  std::vector<float> samples;
  for (int i = 0; i < n_frames; ++i) {
    const double t = i / rate_hz;
    for (int c = 0; c < n_channels; ++c) {
      samples.push_back(static_cast<float>(0.5 * std::exp(-8.0 * t) * std::sin(2764.6 * t)));
    }
  }
  return samples;
}

const std::string kTube =
    "modes --count 1 --shape tube --dims length_m=0.5,outer_radius_m=0.0125,wall_m=0.001 --json m.json ";

}  // namespace

TEST(BadSound, MissingFileIsNamed) {
  const Scratch scratch;
  expect_refused(scratch, "analyze nowhere.wav --json a.json -o out", {"nowhere.wav"});
}

TEST(BadSound, EmptyFileIsRefused) {
  const Scratch scratch;
  scratch.write("empty.wav", "");
  expect_refused(scratch, "analyze empty.wav --json a.json -o out", {"empty.wav"});
}

TEST(BadSound, NoFramesIsRefused) {
  const Scratch scratch;
  scratch.write("none.wav", wav_bytes({}, 1, 48000));
  expect_refused(scratch, "analyze none.wav --json a.json -o out", {"none.wav"});
}

TEST(BadSound, OneSampleIsRefused) {
  const Scratch scratch;
  scratch.write("one.wav", wav_bytes({0.5F}, 1, 48000));
  expect_refused(scratch, "analyze one.wav --json a.json -o out", {"one.wav"});
}

TEST(BadSound, TruncatedFileIsRefused) {
  const Scratch scratch;
  const std::string whole = wav_bytes(ringing(48000, 1, 48000), 1, 48000);
  scratch.write("cut.wav", std::string_view(whole).substr(0, whole.size() / 2));
  expect_refused(scratch, "analyze cut.wav --json a.json -o out", {"cut.wav", "truncated"});
}

TEST(BadSound, NotANumberIsNamedByItsFrame) {
  const Scratch scratch;
  auto samples = ringing(48000, 1, 48000);
  samples[1234] = std::numeric_limits<float>::quiet_NaN();
  scratch.write("nan.wav", wav_bytes(samples, 1, 48000));
  expect_refused(scratch, "analyze nan.wav --json a.json -o out", {"nan.wav", "1234"});
}

TEST(BadSound, SilenceIsRefused) {
  const Scratch scratch;
  scratch.write("silent.wav", wav_bytes(std::vector<float>(48000, 0.0F), 1, 48000));
  expect_refused(scratch, "analyze silent.wav --json a.json -o out", {"silent"});
}

TEST(BadSound, RateOfZeroIsRefused) {
  const Scratch scratch;
  scratch.write("zero.wav", wav_bytes(ringing(4800, 1, 48000), 1, 0));
  expect_refused(scratch, "analyze zero.wav --json a.json -o out", {"zero.wav"});
}

TEST(BadSound, SixtyFourChannelsAreRefused) {
  const Scratch scratch;
  scratch.write("wide.wav", wav_bytes(ringing(4800, 64, 48000), 64, 48000));
  expect_refused(scratch, "analyze wide.wav --json a.json -o out", {"64", "channels"});
}

TEST(NoPartials, NoiseAloneGivesExitThreeAndNothingWritten) {
  const Scratch scratch;
  std::vector<float> noise;
  std::uint32_t state = 1;
  for (int i = 0; i < 48000; ++i) {
    float sum = 0;
    for (int k = 0; k < 12; ++k) sum += static_cast<float>((state = state * 1664525U + 1013904223U) >> 8) / 16777216.0F;
    noise.push_back(0.05F * (sum - 6.0F));
  }
  scratch.write("noise.wav", wav_bytes(noise, 1, 48000));
  const auto before = scratch.files();
  const auto result = run_klang("analyze noise.wav --json a.json -o out", scratch.path());
  EXPECT_EQ(result.exit_code, 3) << result.out << result.err;
  EXPECT_EQ(result.err_lines(), 1) << result.err;
  EXPECT_EQ(scratch.files(), before);
}

TEST(BadShape, NegativeWallIsNamedWithItsValue) {
  const Scratch scratch;
  expect_refused(scratch, "modes --shape tube --dims length_m=0.5,outer_radius_m=0.0125,wall_m=-0.001 --json m.json",
                 {"wall_m", "-0.001"});
}

TEST(BadShape, UnknownMissingAndRepeatedDimensionsAreNamed) {
  const Scratch scratch;
  expect_refused(scratch, "modes --shape rod --dims length_m=0.5,radius_m=0.01,colour=3", {"colour"});
  expect_refused(scratch, "modes --shape rod --dims length_m=0.5", {"radius_m"});
  expect_refused(scratch, "modes --shape rod --dims length_m=0.5,length_m=0.6,radius_m=0.01", {"length_m"});
  expect_refused(scratch, "modes --shape rod --dims length_m=nan,radius_m=0.01", {"length_m"});
  expect_refused(scratch, "modes --shape teapot --dims length_m=1", {"teapot"});
}

TEST(BadMaterial, PoissonsRatioOfOneHalfIsRefused) {
  const Scratch scratch;
  expect_refused(scratch, kTube + "--material youngs_modulus_pa=7e10,poissons_ratio=0.5,density_kg_m3=2700",
                 {"poissons_ratio", "0.5"});
}

TEST(BadMaterial, ImpossibleNumbersAreRefused) {
  const Scratch scratch;
  expect_refused(scratch, kTube + "--material lame_lambda_pa=5e10,lame_mu_pa=-1,density_kg_m3=2700", {"lame_mu_pa"});
  expect_refused(scratch, kTube + "--material lame_lambda_pa=5e10,lame_mu_pa=2e10,density_kg_m3=0", {"density_kg_m3"});
  expect_refused(scratch, kTube + "--material unobtainium", {"unobtainium"});
  expect_refused(scratch, kTube + "--material lame_lambda_pa=5e10,density_kg_m3=2700", {"lame_mu_pa"});
}

TEST(BadMesh, NonManifoldSurfaceIsRefusedWithTheFace) {
  const Scratch scratch;
  // Two tetrahedra that share one edge only.
  scratch.write("two.off",
                "OFF\n6 8 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n0 0 -1\n"
                "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n3 0 1 4\n3 0 5 1\n3 1 5 4\n3 0 4 5\n");
  expect_refused(scratch, "modes --mesh two.off --count 1 --json m.json", {"two.off", "face"});
}

TEST(BadMesh, NonManifoldStlIsRefused) {
  const Scratch scratch;
  std::string stl = "solid fin\n";
  const char* corners[4] = {"0 0 0", "0.1 0 0", "0 0.1 0", "0 0 0.1"};
  const int faces[5][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}, {0, 1, -1}};
  for (const auto& face : faces) {
    stl += "facet normal 0 0 0\nouter loop\n";
    for (const int v : face) stl += std::string("vertex ") + (v < 0 ? "0 -0.1 -0.1" : corners[v]) + "\n";
    stl += "endloop\nendfacet\n";
  }
  scratch.write("fin.stl", stl + "endsolid fin\n");
  expect_refused(scratch, "modes --mesh fin.stl --count 1 --json m.json", {"fin.stl"});
}

TEST(BadMesh, OpenSurfaceAndGarbageAreRefused) {
  const Scratch scratch;
  scratch.write("open.off", "OFF\n4 3 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n");
  expect_refused(scratch, "mesh open.off -o x.vtu", {"open.off"});
  scratch.write("garbage.msh", "\x01\x02 this is no mesh");
  expect_refused(scratch, "modes --mesh garbage.msh --json m.json", {"garbage.msh"});
  scratch.write("nan.off", "OFF\n4 4 0\n0 0 0\nnan 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n");
  expect_refused(scratch, "mesh nan.off -o x.vtu", {"nan.off"});
}

TEST(BadSpecimen, UnknownKeyIsNamedWithItsLine) {
  const Scratch scratch;
  scratch.write("s.csv", "frequency_hz\n587\n");
  scratch.write("s.toml",
                "name = \"x\"\n[material]\npreset = \"aluminium\"\n[[specimen]]\nname = \"D3\"\n"
                "shape = { kind = \"tube\", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }\n"
                "partials = \"s.csv\"\ncolour = \"red\"\n[fit]\nparameters = [\"youngs_modulus_pa\"]\n");
  expect_refused(scratch, "fit s.toml -o out", {"s.toml", "colour", "8"});
}

TEST(BadSpecimen, MissingRecordingAndBrokenTomlAreNamed) {
  const Scratch scratch;
  scratch.write("s.toml",
                "name = \"x\"\n[material]\npreset = \"aluminium\"\n[[specimen]]\nname = \"D3\"\n"
                "shape = { kind = \"tube\", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }\n"
                "recording = \"gone.wav\"\n[fit]\nparameters = [\"youngs_modulus_pa\"]\n");
  expect_refused(scratch, "fit s.toml -o out", {"gone.wav"});
  scratch.write("t.toml", "name = \n");
  expect_refused(scratch, "fit t.toml -o out", {"t.toml"});
}

TEST(BadOption, UnknownOptionsAndSubcommandsGiveOneLine) {
  const Scratch scratch;
  expect_refused(scratch, "modes --frobnicate", {"frobnicate"});
  expect_refused(scratch, "sing", {"sing", "modes"});
  expect_refused(scratch, kTube + "--count 0", {"count"});
  expect_refused(scratch, kTube + "--band-hz 200:100", {"band"});
}

TEST(FullDisk, LeavesExitTwoAndOneLine) {
  const Scratch scratch;
  const auto result = run_klang(
      "modes --count 1 --element p2 --quiet --shape box --dims length_m=0.1,width_m=0.1,height_m=0.01 --json /dev/full",
      scratch.path());
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err_lines(), 1) << result.err;
  EXPECT_NE(result.err.find("/dev/full"), std::string::npos) << result.err;
}

TEST(FullDisk, EarlierResultStaysWhenTheFileSizeIsLimited) {
  const Scratch scratch;
  scratch.write("m.vtu", "earlier");
  // The shell's limit of one 512-byte block stands in for a full disk: writing past it fails.
  const auto result =
      run_klang("modes --count 1 --element p1 --shape box --dims length_m=0.1,width_m=0.1,height_m=0.01 -o m.vtu",
                scratch.path(), "trap '' XFSZ; ulimit -f 1;");
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"m.vtu"});
  EXPECT_EQ(std::filesystem::file_size(scratch.path() / "m.vtu"), 7U);
}

TEST(FullDisk, ASceneThatFindsNoRoomSaysSoInOneLineAndHalvesNothing) {
  const Scratch scratch;
  scratch.write(
      "ball.toml",
      "duration_s = 0.2\n[world.floor]\nmaterial = \"steel\"\n[[material]]\nname = \"steel\"\npreset = \"steel\"\n"
      "[[body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_m = 0.01 }\nmaterial = \"steel\"\n"
      "position_m = [0.0, 0.0, 0.05]\n");
  // In blocks of 512 bytes: at none of these does everything fit, and files of HDF5 end within their head, tables and rows.
  for (const int blocks : {1, 8, 20, 60, 120}) {
    const auto result = run_klang("scene run ball.toml -o out", scratch.path(),
                                  "trap '' XFSZ; ulimit -f " + std::to_string(blocks) + ";");
    EXPECT_EQ(result.exit_code, 2) << blocks << ": " << result.err;
    EXPECT_EQ(result.err_lines(), 1) << blocks << ": " << result.err;
    EXPECT_NE(result.err.find("cannot write"), std::string::npos) << result.err;
    for (const std::string& file : scratch.files()) EXPECT_EQ(file.find("tmp"), std::string::npos) << file;
    std::filesystem::remove_all(scratch.path() / "out");
  }
}

TEST(Output, AFolderThatCannotBeMadeIsRefusedBeforeTheWork) {
  const Scratch scratch;
  scratch.write("file", "x");
  scratch.write("r.wav", wav_bytes(ringing(48000, 1, 48000), 1, 48000));
  expect_refused(scratch, "analyze r.wav -o file/sub", {"file"});
}

namespace {

/// A cube of edge 0.1 m as OFF; with turned faces, or the last one missing.
std::string cube_off(bool turned, int n_faces) {
  std::string text = "OFF\n8 " + std::to_string(n_faces) + " 0\n";
  for (const char* z : {"0", "0.1"}) {
    for (const char* corner : {"0 0 ", "0.1 0 ", "0.1 0.1 ", "0 0.1 "}) text += std::string(corner) + z + "\n";
  }
  const int faces[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                            {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  for (int f = 0; f < n_faces; ++f) {
    text += "3 " + std::to_string(faces[f][0]) + " " + std::to_string(faces[f][turned ? 2 : 1]) + " " +
            std::to_string(faces[f][turned ? 1 : 2]) + "\n";
  }
  return text;
}

std::string rows(const std::string& row, int n) {
  std::string text = "re,im\n";
  for (int i = 0; i < n; ++i) text += row + "\n";
  return text;
}

struct TransferInput : Scratch {
  TransferInput() {
    write("cube.off", cube_off(false, 12));
    write("v.csv", rows("1,0", 12));
    write("pts.csv", "x_m,y_m,z_m\n0.5,0,0\n");
  }
};

const std::string kRest = " --velocity-csv v.csv --frequency-hz 200 --points pts.csv --json p.json";

}  // namespace

TEST(BadTransfer, GoodInputIsAccepted) {
  const TransferInput scratch;
  const auto result = run_klang("transfer --surface cube.off" + kRest, scratch.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
}

TEST(BadTransfer, OpenSurfaceIsRefused) {
  const TransferInput scratch;
  scratch.write("open.off", cube_off(false, 11));
  expect_refused(scratch, "transfer --surface open.off" + kRest, {"open.off", "not closed"});
}

TEST(BadTransfer, NormalsPointingInAreRefused) {
  const TransferInput scratch;
  scratch.write("in.off", cube_off(true, 12));
  expect_refused(scratch, "transfer --surface in.off" + kRest, {"in.off", "inside-out"});
}

TEST(BadTransfer, TooCoarseASurfaceNamesTheElementSizeItNeeds) {
  const TransferInput scratch;
  expect_refused(scratch,
                 "transfer --surface cube.off --velocity-csv v.csv --frequency-hz 4000 --points pts.csv --json p.json",
                 {"too coarse", "0.02144 m"});
  const auto result = run_klang(
      "transfer --surface cube.off --velocity-csv v.csv --frequency-hz 4000 --points pts.csv --json p.json "
      "--allow-coarse",
      scratch.path());
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.err.find("warning"), std::string::npos);
  expect_refused(scratch, "transfer --sphere dipole --ka 30 --elements 500 --json s.json", {"too coarse"});
}

TEST(BadTransfer, VelocityFileOfTheWrongLengthOrContentIsRefused) {
  const TransferInput scratch;
  scratch.write("v.csv", rows("1,0", 11));
  expect_refused(scratch, "transfer --surface cube.off" + kRest, {"v.csv", "11", "12 (triangles)", "8 (vertices)"});
  scratch.write("v.csv", rows("nan,0", 12));
  expect_refused(scratch, "transfer --surface cube.off" + kRest, {"v.csv, line 2", "not finite"});
  scratch.write("v.csv", rows("1", 12));
  expect_refused(scratch, "transfer --surface cube.off" + kRest, {"v.csv, line 2", "columns"});
  scratch.write("v.csv", "re,im\n");
  expect_refused(scratch, "transfer --surface cube.off" + kRest, {"v.csv", "no rows"});
}

TEST(BadTransfer, PointsInsideTheBodyAreNamed) {
  const TransferInput scratch;
  scratch.write("pts.csv", "0.5,0,0\n0.05,0.05,0.05\n");
  expect_refused(scratch, "transfer --surface cube.off" + kRest, {"point 1", "inside"});
}

TEST(BadTransfer, OptionsOutOfRangeAreRefused) {
  const TransferInput scratch;
  expect_refused(scratch, "transfer --json p.json", {"transfer", "0 given"});
  expect_refused(scratch, "transfer --sphere cube --ka 1 --json p.json", {"--sphere", "pulsating"});
  expect_refused(scratch, "transfer --sphere dipole --json p.json", {"--ka"});
  expect_refused(scratch, "transfer --sphere dipole --ka 1 --radius-m -1 --json p.json", {"--radius-m"});
  expect_refused(scratch, "transfer --sphere dipole --ka 1 --density-kg-m3 0 --json p.json", {"--density-kg-m3"});
  expect_refused(scratch, "transfer --surface cube.off --json p.json", {"--velocity-csv"});
  expect_refused(scratch,
                 "transfer --surface cube.off --velocity-csv v.csv --frequency-hz nan --points pts.csv --json p.json",
                 {"--frequency-hz"});
  expect_refused(scratch, "transfer nowhere.vtu -o t.vtu", {"nowhere.vtu"});
}

TEST(BadBubble, RadiusOutOfRangeIsNamed) {
  const Scratch scratch;
  expect_refused(scratch, "bubble info --radius-m 0 --json b.json", {"radius_m", "0"});
  expect_refused(scratch, "bubble info --radius-m 1 --json b.json", {"radius_m", "1"});
  expect_refused(scratch, "bubble info --radius-m nan --json b.json", {"radius_m"});
  expect_refused(scratch, "bubble info --radius-m 0.001 --literature poem --json b.json", {"--literature", "poem"});
  expect_refused(scratch, "bubble info --radius-m 0.001 --surface-tension-n-m -1 --json b.json",
                 {"--surface-tension-n-m", "0 to 1"});
  expect_refused(scratch, "bubble", {"subcommand"});
  expect_refused(scratch, "bubble sing", {"sing"});
}

TEST(BadBubble, ScenesWithMistakesAreRefusedWithTheirLine) {
  const Scratch scratch;
  const std::string bubble = "[[bubble]]\nradius_m = 0.001\nposition_m = [0, 0, -0.01]\n";
  const auto refused = [&](const std::string& toml, const std::vector<std::string>& words) {
    scratch.write("scene.toml", toml);
    expect_refused(scratch, "bubble synth scene.toml -o s.wav --json s.json", words);
  };
  refused("colour = \"red\"\n" + bubble, {"scene.toml:1", "colour"});
  refused("[[bubble]]\nradius_m = 0.0\nposition_m = [0, 0, -0.01]\n", {"scene.toml:2", "radius_m"});
  refused("[[bubble]]\nradius_m = 1.0\nposition_m = [0, 0, -0.01]\n", {"scene.toml:2", "radius_m"});
  refused("[[bubble]]\nradius_m = 0.001\nposition_m = [0, 0, 0.0]\n", {"scene.toml:3", "not in the liquid"});
  refused(bubble + "phi_csv = \"gone.csv\"\n", {"scene.toml:4", "gone.csv"});
  refused("name = \"nothing\"\n", {"no bubbles"});
  refused("name = \n", {"scene.toml:1"});
  scratch.write("gap.csv", "time_s,phi_m\n0,-0.01\n0.001,-0.01\n0.002,-0.01\n0.004,-0.01\n");
  refused(bubble + "phi_csv = \"gap.csv\"\n", {"gap.csv", "misses frames"});
  expect_refused(scratch, "bubble synth nowhere.toml -o s.wav", {"nowhere.toml"});
  scratch.write("scene.toml", bubble);
  expect_refused(scratch, "bubble synth scene.toml -o s.ogg", {"s.ogg"});
}

TEST(BadDrops, RecipesWithMistakesAreRefusedWithTheirLine) {
  const Scratch scratch;
  scratch.write("d.toml",
                "kind = \"drops\"\n[[recording]]\nname = \"a\"\ndrop = [{ onset_s = 0.1, radius_m = 0.0 }]\n");
  expect_refused(scratch, "dataset d.toml -o out", {"d.toml:4", "radius_m"});
  scratch.write("d.toml", "kind = \"drops\"\ncolour = 1\n");
  expect_refused(scratch, "dataset d.toml -o out", {"d.toml:2", "colour"});
}

TEST(GoodBubble, BelowZeroDecibelsItIsNotRaisedAndSaysSo) {
  const Scratch scratch;
  scratch.write("scene.toml",
                "[listener]\nposition_m = [0, 0, 1000]\n[[bubble]]\nradius_m = 5e-4\nposition_m = [0, 0, -0.01]\n");
  const auto synth = run_klang("bubble synth scene.toml -o s.wav --json s.json", scratch.path());
  ASSERT_EQ(synth.exit_code, 0) << synth.err;
  EXPECT_NE(synth.err.find("0 dB re 20 uPa"), std::string::npos) << synth.err;
  const nlohmann::json result = klang::test::read_json(scratch.path() / "s.json");
  EXPECT_EQ(result["warnings"].size(), 1U);
  EXPECT_LE(result["peak_level_db_re_20upa"].get<double>(), -40.0);
  EXPECT_LE(result["gain"].get<double>(), 1.0 / (20e-6 * std::sqrt(2.0)) + 1.0);
}

TEST(GoodBubble, SceneAndDropsAreWritten) {
  const Scratch scratch;
  scratch.write("scene.toml", "[[bubble]]\nradius_m = 0.001\nposition_m = [0, 0, -0.01]\n");
  const auto synth = run_klang("bubble synth scene.toml -o s.wav --json s.json", scratch.path());
  EXPECT_EQ(synth.exit_code, 0) << synth.err;
  scratch.write("d.toml",
                "kind = \"drops\"\n[sound]\nduration_s = 0.3\n[[recording]]\nname = \"a\"\ndrop = [{ onset_s = 0.1, "
                "radius_m = 0.001 }]\n");
  const auto drops = run_klang("dataset d.toml -o out", scratch.path());
  EXPECT_EQ(drops.exit_code, 0) << drops.err;
  const std::vector<std::string> wanted = {"d.toml",         "out",    "out/a-rise.csv", "out/a.wav",
                                           "out/truth.json", "s.json", "s.wav",          "scene.toml"};
  EXPECT_EQ(scratch.files(), wanted);
}
