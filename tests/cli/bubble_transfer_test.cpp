// klang bubble transfer: a ball and a tank from files, a series, and bad input.
#include <gtest/gtest.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "core/foundation/base/conventions.hpp"
#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"
#include "tests/core/sound/dual_domain/vtp_text.hpp"

using namespace klang;
using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;

namespace {

const std::string kTank =
    "bubble transfer --boundary tank.vtp --bubble 0.13,0.10,-0.05 --frequency-hz 1500 --fluid-sources 30 --air-sources "
    "20 "
    "--points pts.csv --json t.json ";

void write_tank(const Scratch& scratch) {
  scratch.write("tank.vtp", test::vtp_text(test::tank({0.30, 0.22, 0.15}, 0.02)));
  scratch.write("pts.csv", "x_m,y_m,z_m\n0.1,0.1,0.5\n0.6,0,0.2\n");
}

}  // namespace

TEST(BubbleTransfer, BallIsHeardAsTheExactTwoWayField) {
  const Scratch scratch;
  scratch.write("ball.vtp", test::vtp_text(test::ball(0.05, 10)));
  scratch.write("pts.csv", "0.5,0,0\n0,-0.3,0.4\n");
  const auto run = run_klang(
      "bubble transfer --boundary ball.vtp --bubble 0,0,0 --frequency-hz 1500 --radius-m 0.002 --fluid-sources 60 "
      "--air-sources 60 --points pts.csv --seed 1 --json t.json",
      scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const nlohmann::json t = read_json(scratch.path() / "t.json");
  const test::Complex exact(-8.46648322272779e-05,
                            7.732643034122478e-05);  // tests/reference/fluid.json: concentric_two_way_exact, S = 1
  const double strength = 4.0 * kPi * 1000.0 * std::pow(2.0 * kPi * 1500.0 * 0.002, 2);
  ASSERT_EQ(t["pressure"].size(), 2U);
  for (const auto& p : t["pressure"])
    EXPECT_LE(std::abs(test::Complex(p["re"], p["im"]) / strength - exact) / std::abs(exact), 1e-2);
  EXPECT_LE(t["fit_error_fluid"].get<double>(), 1e-3);
  EXPECT_LE(t["fit_error_air"].get<double>(), 1e-3);
  EXPECT_GT(t["wall_time_s"]["total"].get<double>(), 0.0);
}

TEST(BubbleTransfer, DefaultRadiusRingsAtTheFrequency) {
  const Scratch scratch;
  scratch.write("ball.vtp", test::vtp_text(test::ball(0.05, 6)));
  scratch.write("pts.csv", "0.5,0,0\n");
  ASSERT_EQ(run_klang("bubble transfer --boundary ball.vtp --bubble 0,0,0 --frequency-hz 3286 --fluid-sources 10 "
                      "--air-sources 10 --points pts.csv "
                      "--json t.json",
                      scratch.path())
                .exit_code,
            0);
  EXPECT_NEAR(read_json(scratch.path() / "t.json")["radius_m"].get<double>(), 0.001, 5e-6);
}

TEST(BubbleTransfer, SurfaceFileHoldsTheSlopeOfTheImages) {
  const Scratch scratch;
  write_tank(scratch);
  const auto run = run_klang(kTank + "-o v.vtp", scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const double strength = read_json(scratch.path() / "t.json")["source_strength_kg_m_s2"];
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((scratch.path() / "v.vtp").c_str());
  reader->Update();
  vtkDataArray* slope = reader->GetOutput()->GetPointData()->GetArray("surface_normal_derivative");
  ASSERT_NE(slope, nullptr);
  ASSERT_EQ(slope->GetNumberOfComponents(), 2);
  const test::TankImages images({0.30, 0.22, 0.15}, 2 * kPi * 1500 / 1497);
  double error = 0.0, size = 0.0;
  for (vtkIdType i = 0; i < 16 * 12; ++i) {  // the top is the first patch
    double x[3];
    reader->GetOutput()->GetPoint(i, x);
    ASSERT_EQ(x[2], 0.0);
    const double exact = images.top_slope(x[0], x[1], {0.13, 0.10, -0.05});
    error += std::norm(test::Complex(slope->GetComponent(i, 0), slope->GetComponent(i, 1)) / strength - exact);
    size += exact * exact;
  }
  EXPECT_LE(std::sqrt(error / size), 0.02);
}

TEST(BubbleTransfer, SameSeedSameBytesOtherSeedOtherSources) {
  const Scratch scratch;
  write_tank(scratch);
  const auto pressure = [&](const std::string& more) {
    EXPECT_EQ(run_klang(kTank + more, scratch.path()).exit_code, 0);
    return read_json(scratch.path() / "t.json")["pressure"];
  };
  const auto one = pressure("--seed 1 --threads 1"), two = pressure("--seed 1 --threads 2"),
             other = pressure("--seed 2");
  EXPECT_EQ(one, two);
  EXPECT_NE(one, other);
}

TEST(BubbleTransfer, PaperLeavesTheDensityRatioOut) {
  const Scratch scratch;
  scratch.write("ball.vtp", test::vtp_text(test::ball(0.05, 6)));
  scratch.write("pts.csv", "0.5,0,0\n");
  const std::string command =
      "bubble transfer --boundary ball.vtp --bubble 0,0,0.01 --frequency-hz 1000 --radius-m 0.003 --fluid-sources 10 "
      "--air-sources 10 --points pts.csv --json t.json ";
  ASSERT_EQ(run_klang(command, scratch.path()).exit_code, 0);
  const auto right = read_json(scratch.path() / "t.json")["pressure"][0];
  ASSERT_EQ(run_klang(command + "--literature paper", scratch.path()).exit_code, 0);
  const auto paper = read_json(scratch.path() / "t.json")["pressure"][0];
  const test::Complex gain = test::Complex(paper["re"], paper["im"]) / test::Complex(right["re"], right["im"]);
  EXPECT_NEAR(gain.real(), -1000.0 / 1.2041, 1e-3);
}

TEST(BubbleTransfer, ObjGroupsNameTheRegions) {
  const Scratch scratch;
  const bubble::BoundaryMesh tank = test::tank({0.30, 0.22, 0.15}, 0.03);
  std::string obj;
  for (Eigen::Index i = 0; i < tank.surface.vertices_m.rows(); ++i)
    obj += "v " + std::to_string(tank.surface.vertices_m(i, 0)) + " " + std::to_string(tank.surface.vertices_m(i, 1)) +
           " " + std::to_string(tank.surface.vertices_m(i, 2)) + "\n";
  for (Eigen::Index t = 0; t < tank.surface.triangles.rows(); ++t) {
    if (t == 0 || tank.region[static_cast<std::size_t>(t)] != tank.region[static_cast<std::size_t>(t) - 1])
      obj += "g region_" + std::to_string(tank.region[static_cast<std::size_t>(t)]) + "\n";
    obj += "f " + std::to_string(tank.surface.triangles(t, 0) + 1) + " " +
           std::to_string(tank.surface.triangles(t, 1) + 1) + " " + std::to_string(tank.surface.triangles(t, 2) + 1) +
           "\n";
  }
  scratch.write("tank.obj", obj);
  scratch.write("tank.vtp", test::vtp_text(tank));
  scratch.write("pts.csv", "0.1,0.1,0.5\n");
  nlohmann::json pressure[2];
  for (int i = 0; i < 2; ++i) {
    const auto run = run_klang(std::string("bubble transfer --boundary tank.") + (i == 0 ? "obj" : "vtp") +
                                   " --bubble 0.13,0.10,-0.05 --frequency-hz 1500 --fluid-sources 10 --air-sources 10 "
                                   "--points pts.csv --json t.json",
                               scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    pressure[i] = read_json(scratch.path() / "t.json")["pressure"][0];
  }
  EXPECT_NEAR(pressure[0]["re"].get<double>(), pressure[1]["re"].get<double>(),
              1e-3 * std::abs(pressure[1]["re"].get<double>()));
}

TEST(BubbleTransfer, SeriesWritesATransferOfGrowingStepsThatFreezesOutside) {
  const Scratch scratch;
  for (int i = 0; i < 12; ++i)
    scratch.write("tank_" + std::to_string(100 + i) + ".vtp", test::vtp_text(test::tank({0.30, 0.22, 0.15}, 0.03)));
  scratch.write("pts.csv", "0.1,0.1,0.5\n");
  scratch.write("path.csv", "time_s,x_m,y_m,z_m\n0,0.13,0.1,-0.04\n0.01,0.13,0.1,0.01\n");
  const auto series = [&](const std::string& decay_per_s) {
    const auto run = run_klang(
        "bubble transfer --boundary tank_###.vtp --frame-step-s 0.001 --path path.csv --frequency-hz 2000 "
        "--decay-per-s " +
            decay_per_s + " --fluid-sources 10 --air-sources 10 --points pts.csv -o z.csv --json t.json",
        scratch.path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return read_json(scratch.path() / "t.json");
  };
  const auto solved_ms = [](const nlohmann::json& t) {
    std::vector<long> times;
    for (const auto& step : t["transfer"])
      if (!step["frozen"].get<bool>()) times.push_back(std::lround(1e3 * step["time_s"].get<double>()));
    return times;
  };
  // The bubble is out after 8 frames of 1 ms. Steps grow as e^{beta t}: 1, 1.5, 2.2, 5 ms at 400 per s.
  nlohmann::json t = series("0");
  EXPECT_EQ(t["n_frames"], 12);
  EXPECT_EQ(solved_ms(t), (std::vector<long>{0, 1, 2, 3, 4, 5, 6, 7}));
  t = series("1000");  // ends at 1/1000 of the amplitude, 6.9 ms
  EXPECT_EQ(solved_ms(t), (std::vector<long>{0, 1, 4}));
  EXPECT_LE(t["transfer"].back()["time_s"].get<double>(), 0.0069);
  t = series("400");
  EXPECT_EQ(solved_ms(t), (std::vector<long>{0, 1, 2, 4}));
  EXPECT_TRUE(t["transfer"].back()["frozen"].get<bool>());
  std::ifstream csv(scratch.path() / "z.csv");
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "time_s,frequency_hz,re,im");
}

TEST(BubbleTransfer, ReciprocalIsWithinItsErrorEstimateAndSaysThatOfTheForwardMethod) {
  const Scratch scratch;
  scratch.write("tank.vtp", test::vtp_text(test::tank({0.30, 0.22, 0.15}, 0.02)));
  scratch.write("pts.csv", "x_m,y_m,z_m\n0.5,0.2,0.3\n0.15,0.1,0.5\n");
  const std::string command =
      "bubble transfer --boundary tank.vtp --bubble 0.13,0.10,-0.03 --frequency-hz 500 --points pts.csv --json t.json "
      "--method ";
  ASSERT_EQ(run_klang(command + "reciprocal", scratch.path()).exit_code, 0);
  const nlohmann::json reciprocal = read_json(scratch.path() / "t.json");
  ASSERT_EQ(run_klang(command + "reciprocal --device cpu", scratch.path()).exit_code, 0);
  const nlohmann::json device = read_json(scratch.path() / "t.json");
  ASSERT_EQ(run_klang(command + "forward", scratch.path()).exit_code, 0);
  const nlohmann::json forward = read_json(scratch.path() / "t.json");
  EXPECT_EQ(reciprocal["method"], "reciprocal");
  EXPECT_LE(reciprocal["error_estimate"].get<double>(), 0.02);
  const double strength = 4.0 * kPi * 1000.0 * std::pow(2.0 * kPi * 500.0 * forward["radius_m"].get<double>(), 2);
  // Driven by the sum over images, boundary elements extrapolated over their size.
  const double exact[] = {3.033e-4, 3.665e-4};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto value = [&](const nlohmann::json& t) {
      return test::Complex(t["pressure"][i]["re"], t["pressure"][i]["im"]) / strength;
    };
    EXPECT_LE(std::abs(std::abs(value(reciprocal)) / exact[i] - 1.0), 0.02) << i;
    EXPECT_LE(std::abs(value(device) - value(reciprocal)), 1e-6 * exact[i]) << i;
    const double off = std::abs(value(forward) - value(reciprocal)) / std::abs(value(reciprocal));
    EXPECT_LE(std::abs(forward["pressure"][i]["error_estimate"].get<double>() - off), 0.02) << i;
  }
}

TEST(BubbleTransfer, LossTamesTheModeThatTheWarningNames) {
  const Scratch scratch;
  write_tank(scratch);
  std::string command = kTank + "--method reciprocal ";
  command.replace(command.find("1500"), 4, "2495");  // c / (4 H)
  const auto size = [&](const std::string& loss) {
    const auto run = run_klang(command + loss, scratch.path());
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_NE(run.err.find("2495 Hz (0,0,0)"), std::string::npos) << run.err;
    const nlohmann::json t = read_json(scratch.path() / "t.json");
    EXPECT_EQ(t["tank_modes"][0]["p"], 0);
    return std::hypot(t["pressure"][0]["re"].get<double>(), t["pressure"][0]["im"].get<double>());
  };
  EXPECT_GE(size("--liquid-loss-factor 0.02"), 1.5 * size("--liquid-loss-factor 0.1"));
}

TEST(BubbleTransfer, BadInputIsNamed) {
  const Scratch scratch;
  write_tank(scratch);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string command = kTank;
    command.replace(command.find(from), from.size(), to);
    return command;
  };
  expect_refused(scratch, with("tank.vtp", "none.vtp"), {"none.vtp"});
  expect_refused(scratch, with("0.13,0.10,-0.05", "0.13,0.10,0.05"), {"outside the liquid"});
  expect_refused(scratch, with("0.13,0.10,-0.05", "0.13,0.10,0"), {"on the boundary"});
  expect_refused(scratch, with("0.13,0.10,-0.05", "-0.13,0.10,-0.05"), {"outside the liquid"});
  expect_refused(scratch, with("0.13,0.10,-0.05", "0.13,0.10"), {"--bubble"});
  expect_refused(scratch, with("1500", "0"), {"--frequency-hz"});
  expect_refused(scratch, with("1500", "1500 --radius-m 0"), {"--radius-m"});
  expect_refused(scratch, with("--fluid-sources 30", "--fluid-sources 0"), {"--fluid-sources", "1 to 400"});
  expect_refused(scratch, kTank + "--radius-m 1", {"--radius-m"});
  expect_refused(scratch, kTank + "--literature book", {"--literature", "right", "paper"});
  expect_refused(scratch, kTank + "-o v.png", {".vtp"});
  expect_refused(scratch, kTank + "--method backward", {"--method", "forward", "reciprocal"});
  expect_refused(scratch, kTank + "--device 4711", {"--device", "4711"});
  expect_refused(scratch, kTank + "--device cpu --literature paper", {"--device", "paper"});
  expect_refused(scratch, kTank + "--method reciprocal -o v.vtp", {"-o", "reciprocal"});
  expect_refused(scratch, kTank + "--liquid-loss-factor 2", {"--liquid-loss-factor", "0 to 0.5"});
  scratch.write("inside.csv", "0.1,0.1,-0.05\n");
  expect_refused(scratch, with("pts.csv", "inside.csv"), {"point 0", "inside the liquid"});
  bubble::BoundaryMesh turned = test::tank({0.30, 0.22, 0.15}, 0.05);
  for (Eigen::Index t = 0; t < turned.surface.triangles.rows(); ++t)
    if (turned.region[static_cast<std::size_t>(t)] == 0)
      std::swap(turned.surface.triangles(t, 1), turned.surface.triangles(t, 2));
  scratch.write("turned.vtp", test::vtp_text(turned));
  expect_refused(scratch, with("tank.vtp", "turned.vtp"), {"turned.vtp", "inconsistent normals"});
  scratch.write("nameless.vtp", test::vtp_text(test::tank({0.30, 0.22, 0.15}, 0.05), "colour"));
  expect_refused(scratch, with("tank.vtp", "nameless.vtp"), {"nameless.vtp", "region"});
  scratch.write("cut.vtp", test::vtp_text(turned).substr(0, 900));
  expect_refused(scratch, with("tank.vtp", "cut.vtp"), {"cut.vtp"});
}

TEST(BubbleTransfer, SeriesWithAMissingFrameIsRefused) {
  const Scratch scratch;
  write_tank(scratch);
  for (const int i : {0, 1, 3})
    scratch.write("tank_000" + std::to_string(i) + ".vtp", test::vtp_text(test::tank({0.30, 0.22, 0.15}, 0.05)));
  const std::string command =
      "bubble transfer --boundary tank_####.vtp --frame-step-s 0.001 --bubble 0.13,0.1,-0.05 --frequency-hz 1500 "
      "--fluid-sources 10 --air-sources 10 --points pts.csv -o z.csv";
  expect_refused(scratch, command, {"missing", "tank_0002.vtp"});
  scratch.write("tanks.pvd",
                "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"0\" file=\"tank_0000.vtp\"/>"
                "<DataSet timestep=\"1\" file=\"tank_0007.vtp\"/></Collection></VTKFile>");
  std::string collection = command;
  collection.replace(collection.find("tank_####.vtp"), 13, "tanks.pvd");
  expect_refused(scratch, collection, {"missing", "tank_0007.vtp"});
}
