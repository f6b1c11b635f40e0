// klang scene import of other programs' liquids, and export as .vdb.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <map>
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
    "name = \"pool\"\n[domain]\nsize_m = [0.12, 0.1, 0.12]\ncell_m = 0.02\nduration_s = 0.03\nframe_rate_hz = 100\n"
    "[[pool]]\ndepth_m = 0.074\n[listener]\nposition_m = [0.06, -0.5, 0.3]\n";
const std::string kBubble = "[[bubble]]\nradius_m = 0.003\nposition_m = [0.06, 0.06, 0.04]\nbirth_s = 0.005\n";

std::string read_text(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// Depth of the only bubble at its birth.
double depth_m(const std::filesystem::path& folder) {
  std::istringstream lines(read_text(folder / "bubbles.csv"));
  std::string line, cell;
  std::getline(lines, line);
  std::getline(lines, line);
  std::istringstream cells(line);
  for (int c = 0; c < 9; ++c) std::getline(cells, cell, ',');
  return std::stod(cell);
}

/// Puts a bubble into an imported folder and hears it.
void expect_heard(const Scratch& scratch, const std::string& folder, double depth, double tolerance) {
  std::ofstream(scratch.path() / folder / "scene.toml", std::ios::app) << kBubble;
  const auto run = run_klang("scene run " + folder + "/scene.toml -o " + folder + " --stage bubbles", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_LE(std::abs(depth_m(scratch.path() / folder) - depth), tolerance) << folder;
  const nlohmann::json json = read_json(scratch.path() / folder / "run.json");
  EXPECT_GT(json["sound"]["peak_pressure_pa"].get<double>(), 0.0);
  EXPECT_LE(json["transfer"]["error_estimate"].get<double>(), 0.3);
}

/// An OpenFOAM case of 6 x 5 x 6 cells of 0.02 m, water up to a height.
void write_case(const Scratch& scratch, const std::string& folder, const std::vector<std::string>& times,
                double depth) {
  constexpr int kN[3] = {6, 5, 6};
  const auto point = [&](int i, int j, int k) { return i + (kN[0] + 1) * (j + (kN[1] + 1) * k); };
  const auto cell = [&](int i, int j, int k) { return i + kN[0] * (j + kN[1] * k); };
  std::ostringstream points, inner, outer, inner_owner, outer_owner, neighbour;
  int n_inner = 0, n_outer = 0;
  for (int k = 0; k <= kN[2]; ++k)
    for (int j = 0; j <= kN[1]; ++j)
      for (int i = 0; i <= kN[0]; ++i) points << "(" << 0.02 * i << " " << 0.02 * j << " " << 0.02 * k << ")\n";
  for (int k = 0; k < kN[2]; ++k)
    for (int j = 0; j < kN[1]; ++j)
      for (int i = 0; i < kN[0]; ++i)
        for (int side = 0; side < 6; ++side) {
          const int axis = side % 3, up = side < 3 ? 1 : 0, at[3] = {i, j, k};
          const int b = (axis + 1) % 3, c = (axis + 2) % 3;
          std::ostringstream face;
          face << "4(";
          for (int corner = 0; corner < 4; ++corner) {  // outwards by the right hand
            int x[3] = {i, j, k};
            x[axis] += up;
            const bool first = corner == 1 || corner == 2, second = corner >= 2;
            x[up == 1 ? b : c] += first ? 1 : 0;
            x[up == 1 ? c : b] += second ? 1 : 0;
            face << (corner > 0 ? " " : "") << point(x[0], x[1], x[2]);
          }
          face << ")\n";
          int beside[3] = {i, j, k};
          ++beside[axis];
          if (up == 1 && at[axis] + 1 < kN[axis]) {
            inner << face.str();
            inner_owner << cell(i, j, k) << "\n";
            neighbour << cell(beside[0], beside[1], beside[2]) << "\n";
            ++n_inner;
          } else if (up == 1 || at[axis] == 0) {
            outer << face.str();
            outer_owner << cell(i, j, k) << "\n";
            ++n_outer;
          }
        }
  const auto file = [&](const std::string& name, const std::string& kind, const std::string& text) {
    std::filesystem::create_directories((scratch.path() / folder / name).parent_path());
    std::ofstream(scratch.path() / folder / name)
        << "FoamFile\n{\n version 2.0;\n format ascii;\n class " << kind << ";\n object "
        << std::filesystem::path(name).filename().string() << ";\n}\n"
        << text;
  };
  const auto listed = [](int n, const std::string& text) { return std::to_string(n) + "\n(\n" + text + ")\n"; };
  file("constant/polyMesh/points", "vectorField", listed(7 * 6 * 7, points.str()));
  file("constant/polyMesh/faces", "faceList", listed(n_inner + n_outer, inner.str() + outer.str()));
  file("constant/polyMesh/owner", "labelList", listed(n_inner + n_outer, inner_owner.str() + outer_owner.str()));
  file("constant/polyMesh/neighbour", "labelList", listed(n_inner, neighbour.str()));
  file("constant/polyMesh/boundary", "polyBoundaryMesh",
       "1\n(\nwalls\n{\n type wall;\n nFaces " + std::to_string(n_outer) + ";\n startFace " + std::to_string(n_inner) +
           ";\n}\n)\n");
  file("system/controlDict", "dictionary", "startTime 0;\nendTime 1;\ndeltaT 0.01;\nwriteInterval 0.01;\n");
  for (const std::string& time : times) {
    std::ostringstream share;
    for (int c = 0; c < 180; ++c) share << std::clamp((depth - 0.02 * (c / 30)) / 0.02, 0.0, 1.0) << "\n";
    file(time + "/alpha.water", "volScalarField",
         "dimensions [0 0 0 0 0 0 0];\ninternalField nonuniform List<scalar>\n" + listed(180, share.str()) +
             ";\nboundaryField\n{\nwalls\n{\n type zeroGradient;\n}\n}\n");
  }
}

}  // namespace

#ifdef KLANG_HAS_OPENVDB
TEST(LiquidImport, VdbComesBackAsItWentAndSounds) {
  const Scratch scratch;
  scratch.write("pool.toml", kPool);
  ASSERT_EQ(run_klang("scene run pool.toml -o D", scratch.path()).exit_code, 0);
  const auto exported = run_klang("scene export D --vdb V", scratch.path());
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const std::string import = "scene import V/f_####.vdb --kind vdb --frame-step-s 0.01 ";
  ASSERT_EQ(run_klang(import + "-o E", scratch.path()).exit_code, 0);
  const nlohmann::json json = read_json(scratch.path() / "E/run.json");
  EXPECT_EQ(json["stages"]["flow"]["status"], "done");
  EXPECT_EQ(json["n_frames"], 4);
  EXPECT_EQ(json["imported"]["has_velocity"], true);
  EXPECT_LE(std::abs(json["volume"]["end_m3"].get<double>() / (0.12 * 0.1 * 0.074) - 1.0), 1e-4);
  expect_heard(scratch, "E", 0.034, 2e-5);
  expect_refused(scratch, "scene run E/scene.toml -o E2", {"another program"});
  expect_refused(scratch, "scene import V/f_####.vdb --kind vdb -o F", {"--frame-step-s"});
  expect_refused(scratch, import + "-o E", {"holds a run already"});
  std::filesystem::remove(scratch.path() / "V/f_0002.vdb");
  expect_refused(scratch, import + "-o F", {"f_0002.vdb"});
  std::string coarse = kPool;
  coarse.replace(coarse.find("cell_m = 0.02"), 13, "cell_m = 0.01");
  scratch.write("fine.toml", coarse);
  ASSERT_EQ(run_klang("scene run fine.toml -o G --until-s 0.01", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene export G --vdb W", scratch.path()).exit_code, 0);
  std::filesystem::copy_file(scratch.path() / "W/f_0001.vdb", scratch.path() / "V/f_0002.vdb");
  expect_refused(scratch, import + "-o F", {"voxel size changes"});
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "F"));
}
#endif

TEST(LiquidImport, SurfacesKeepTheirRegionsAndUnevenTimesAreRefused) {
  const Scratch scratch;
  scratch.write("pool.toml", kPool);
  ASSERT_EQ(run_klang("scene run pool.toml -o D", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene import D/frames.pvd --kind vtp -o E", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_json(scratch.path() / "E/run.json")["n_frames"], 4);
  expect_heard(scratch, "E", 0.034, 5e-4);
  std::string pvd = read_text(scratch.path() / "D/frames.pvd");
  pvd.replace(pvd.find("timestep=\"0.03\""), 15, "timestep=\"0.04\"");
  std::ofstream(scratch.path() / "D/frames.pvd") << pvd;
  expect_refused(scratch, "scene import D/frames.pvd --kind vtp -o F", {"uneven in time"});
  expect_refused(scratch, "scene import D/frames.pvd --kind abc -o F", {"vdb, vtp, openfoam"});
}

/// A closed box of water from 0 to size, each side of n x n quads, without groups.
std::string box_obj(const std::array<double, 3>& size, int n) {
  std::map<std::array<int, 3>, int> number;  // of the corners
  std::string vertices, faces;
  const auto corner = [&](const std::array<int, 3>& at) {
    const auto [it, is_new] = number.emplace(at, static_cast<int>(number.size()) + 1);
    if (is_new) {
      vertices += "v";
      for (std::size_t axis = 0; axis < 3; ++axis) vertices += " " + std::to_string(size[axis] * at[axis] / n);
      vertices += "\n";
    }
    return " " + std::to_string(it->second);
  };
  for (int side = 0; side < 6; ++side)
    for (int b = 0; b < n; ++b)
      for (int a = 0; a < n; ++a) {
        const std::size_t axis = static_cast<std::size_t>(side % 3), u = (axis + 1) % 3, v = (axis + 2) % 3;
        const auto at = [&](int along_u, int along_v) {
          std::array<int, 3> x{};
          x[axis] = side < 3 ? 0 : n;
          x[u] = along_u;
          x[v] = along_v;
          return corner(x);
        };
        faces += "f" + at(a, b) + (side < 3 ? at(a, b + 1) : at(a + 1, b)) + at(a + 1, b + 1) +
                 (side < 3 ? at(a + 1, b) : at(a, b + 1)) + "\n";
      }
  return vertices + faces;
}

TEST(LiquidImport, FloorAndSidesOfAnObjWithoutGroupsAreWalls) {
  const Scratch scratch;
  for (const char* name : {"w_0.obj", "w_1.obj", "w_2.obj"}) scratch.write(name, box_obj({0.12, 0.1, 0.074}, 10));
  const auto import = run_klang("scene import w_#.obj --kind vtp --frame-step-s 0.01 -o E", scratch.path());
  ASSERT_EQ(import.exit_code, 0) << import.err;
  EXPECT_NE(import.err.find("no regions"), std::string::npos) << import.err;
  std::string off = box_obj({0.12, 0.1, 0.074}, 10);
  off.replace(off.find("v 0.000000"), 10, "v -3e-19");
  for (const char* name : {"o_0.obj", "o_1.obj", "o_2.obj"}) scratch.write(name, off);
  ASSERT_EQ(run_klang("scene import o_#.obj --kind vtp --frame-step-s 0.01 -o O", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_json(scratch.path() / "O/run.json")["n_cells"], read_json(scratch.path() / "E/run.json")["n_cells"])
      << "round-off is no layer of cells";
  std::ofstream(scratch.path() / "E/scene.toml", std::ios::app)
      << "[[bubble]]\nradius_m = 0.003\nposition_m = [0.06, 0.05, 0.01]\nbirth_s = 0.005\n[transfer]\nmethod = "
         "\"half_space\"\n";
  ASSERT_EQ(run_klang("scene run E/scene.toml -o E --stage bubbles", scratch.path()).exit_code, 0);
  EXPECT_LE(std::abs(depth_m(scratch.path() / "E") - 0.064), 5e-4) << "not the 10 mm to the floor";
}

TEST(LiquidImport, AnOpenFoamCaseIsReadWhereHalfIsWater) {
  const Scratch scratch;
  write_case(scratch, "case", {"0", "0.01", "0.02", "0.03"}, 0.07);
  const auto import = run_klang("scene import case --kind openfoam -o E", scratch.path());
  ASSERT_EQ(import.exit_code, 0) << import.err;
  const nlohmann::json json = read_json(scratch.path() / "E/run.json");
  EXPECT_EQ(json["n_frames"], 4);
  EXPECT_EQ(json["n_cells"], 180);
  // The point at the middle of cell 3 (z = 0.07) is half full.
  EXPECT_LE(std::abs(json["volume"]["end_m3"].get<double>() / (0.12 * 0.1 * 0.07) - 1.0), 1e-3);
  expect_heard(scratch, "E", 0.03, 2e-4);
  write_case(scratch, "uneven", {"0", "0.01", "0.03"}, 0.07);
  expect_refused(scratch, "scene import uneven --kind openfoam -o F", {"uneven in time"});
  expect_refused(scratch, "scene import . --kind openfoam -o F", {"controlDict"});
}

TEST(LiquidImport, BrokenTextOfAnOpenFoamCaseIsRefusedBeforeItIsParsed) {
  const Scratch scratch;
  write_case(scratch, "case", {"0", "0.01"}, 0.07);
  const auto refused_with = [&](const std::string& name, const std::string& text, const std::string& complaint) {
    const std::filesystem::path file = scratch.path() / "case" / name;
    const std::string before = read_text(file);
    std::ofstream(file, std::ios::app) << text;
    expect_refused(scratch, "scene import case --kind openfoam -o F", {file.filename().string(), complaint});
    std::ofstream(file) << before;
  };
  std::string deep = "\n";
  for (int k = 0; k < 200000; ++k) deep += "a{";
  for (const char* const name : {"system/controlDict", "constant/polyMesh/boundary", "0.01/alpha.water"}) {
    refused_with(name, deep, "nest too deep");
    refused_with(name, "\nb " + std::string(200000, '('), "nest too deep");
    refused_with(name, "\nb {", "do not close");
    refused_with(name, "\nb }", "do not close");
    refused_with(name, std::string("\nb \0;", 6), "no text");
  }
  // What stands in comments and quotes is no bracket.
  std::ofstream(scratch.path() / "case/0.01/alpha.water", std::ios::app) << "// {\n/* ( */\nnote \"}\";\n";
  EXPECT_EQ(run_klang("scene import case --kind openfoam -o E", scratch.path()).exit_code, 0);
  // A field where the boundary should be ends VTK's reader at a null pointer.
  std::ofstream(scratch.path() / "case/constant/polyMesh/boundary") << read_text(scratch.path() / "case/0/alpha.water");
  expect_refused(scratch, "scene import case --kind openfoam -o F", {"case", "is damaged"});
}

TEST(SceneMatch, SetsRateAndRadiiAndSaysWhatIsPrediction) {
  const Scratch scratch;
  std::string drops =
      "name = \"d\"\n[sound]\nduration_s = 1.6\n[listener]\nmode = \"mono\"\nposition_m = [0, -0.5, 0.5]\n";
  for (int i = 0; i < 12; ++i)
    drops += "[[bubble]]\nradius_m = " + std::to_string(0.001 + 0.0005 * (i % 3)) +
             "\nbirth_s = " + std::to_string(0.05 + 0.12 * i) + "\nposition_m = [0.02, 0, -0.05]\n";
  scratch.write("drops.toml", drops);
  ASSERT_EQ(run_klang("bubble synth drops.toml -o drops.wav", scratch.path()).exit_code, 0);
  std::string scene = kPool;
  scene.replace(scene.find("duration_s = 0.03"), 17, "duration_s = 1.0 ");
  scene.replace(scene.find("frame_rate_hz = 100"), 19, "frame_rate_hz = 20 ");
  scratch.write("pool.toml", scene +
                                 "[transfer]\nmethod = \"half_space\"\n[entrainment]\nattempts_per_m2_s = "
                                 "1e4\ncoverage = 0\n[[entrainment.patch]]\nlow_m = [0.02, 0.02, 0.05]\n"
                                 "high_m = [0.1, 0.08, 0.1]\n");
  const auto run = run_klang("scene match pool.toml --recording drops.wav -o M --no-sound", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json match = read_json(scratch.path() / "M/match.json");
  EXPECT_EQ(match["recorded"]["n_bubbles"], 12);
  EXPECT_LE(std::abs(match["made"]["births_per_s"].get<double>() - 7.5), 1.01);
  EXPECT_LE(std::abs(match["made"]["radius_median_m"].get<double>() / 0.0015 - 1.0), 0.35);
  EXPECT_EQ(match["matched"][0], "births per second");
  EXPECT_FALSE(match["predicted"].empty());
  const nlohmann::json json = read_json(scratch.path() / "M/run.json");
  EXPECT_EQ(json["n_bubbles"], match["made"]["n_bubbles"]);
  // The matched scene is one that runs by itself.
  EXPECT_EQ(run_klang("scene check M/scene.toml", scratch.path()).exit_code, 0);
  // A second match into its folder: bubbles of the scene's own are no match, and nothing of the first one's sound stays.
  ASSERT_EQ(run_klang("scene run M/scene.toml -o M --stage sound --no-page", scratch.path()).exit_code, 2);
  ASSERT_EQ(run_klang("scene run M/scene.toml -o M --stage transfer", scratch.path()).exit_code, 0);
  ASSERT_TRUE(std::filesystem::exists(scratch.path() / "M/report.html"));
  std::string scripted = read_text(scratch.path() / "pool.toml");
  for (int i = 0; i < 9; ++i)
    scripted +=
        "[[bubble]]\nradius_m = 0.004\nbirth_s = 0.1\nposition_m = [0.0" + std::to_string(i + 1) + ", 0.05, 0.03]\n";
  scratch.write("scripted.toml", scripted);
  const auto again = run_klang("scene match scripted.toml --recording drops.wav -o M --no-sound", scratch.path());
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.err.find("9 bubble(s) of [[bubble]]"), std::string::npos) << again.err;
  const nlohmann::json with_scripted = read_json(scratch.path() / "M/match.json"),
                       rerun = read_json(scratch.path() / "M/run.json");
  EXPECT_EQ(with_scripted["made"]["n_bubbles"], match["made"]["n_bubbles"]);
  EXPECT_TRUE(rerun["sound"].is_null() && rerun["transfer"].is_null());
  for (const char* const gone : {"report.html", "sound.wav", "transfer.csv", "drops.next.json"})
    EXPECT_FALSE(std::filesystem::exists(scratch.path() / "M" / gone)) << gone;
  // One that cannot be: why, and the match before stays whole.
  std::string brief = kPool;
  scratch.write("brief.toml", brief + "[entrainment]\nattempts_per_m2_s = 1e4\n");
  const auto short_one = run_klang("scene match brief.toml --recording drops.wav -o B --no-sound", scratch.path());
  EXPECT_EQ(short_one.exit_code, 3) << short_one.err;
  EXPECT_NE(short_one.err.find("make the scene longer"), std::string::npos) << short_one.err;
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "B/drops.json"));
  // Radii by hand.
  const auto refused_radius = [&](const std::string& json, const std::string& word) {
    scratch.write("hand.json", json);
    scratch.write("hand.toml", std::string(kPool) +
                                   "[entrainment]\nattempts_per_m2_s = 1e4\nradii = { kind = "
                                   "\"recording\", file = \"hand.json\" }\n");
    expect_refused(scratch, "scene check hand.toml", {"hand.", word});
  };
  refused_radius(R"({"status": "ok", "bubbles": [{"radius_m": 0.001}, {"radius_m": -0.001}]})", "bubbles[1].radius_m");
  refused_radius(R"({"status": "ok", "bubbles": [{"radius_m": 0.02}]})", "smallest_m to largest_m");
  refused_radius(R"({"status": "not_bubbles", "bubbles": [{"radius_m": 0.002}]})", "not_bubbles");
  scratch.write("still.toml", scene);
  expect_refused(scratch, "scene match drops.toml --recording drops.wav -o N", {"[domain]"});
  const auto still = run_klang("scene match still.toml --recording drops.wav -o N --no-sound", scratch.path());
  EXPECT_EQ(still.exit_code, 3) << still.err;
  EXPECT_NE(still.err.find("entrains"), std::string::npos) << still.err;
}
