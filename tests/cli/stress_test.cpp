// `klang stress` as a user sees it.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"
#include "tests/places.hpp"

using klang::test::expect_refused;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;
using nlohmann::json;

namespace {

const std::string kGlass = " --material youngs_modulus_pa=62e9,poissons_ratio=0.2,density_kg_m3=2600 ";
const std::string kBeam =
    "stress --shape box --dims length_m=0.2,width_m=0.01,height_m=0.01 --max-edge-m 0.005" + kGlass;

/// tests/reference/quasistatic.json: mesh, as a Gmsh 2.2 file.
std::string reference_msh(const json& mesh) {
  std::string text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(mesh["nodes_m"].size()) + "\n";
  int number = 0;
  for (const json& x : mesh["nodes_m"])
    text += std::to_string(++number) + " " + x[0].dump() + " " + x[1].dump() + " " + x[2].dump() + "\n";
  text += "$EndNodes\n$Elements\n" + std::to_string(mesh["tetrahedra"].size()) + "\n";
  number = 0;
  for (const json& e : mesh["tetrahedra"]) {
    text += std::to_string(++number) + " 4 2 1 1";
    for (const json& node : e) text += " " + std::to_string(node.get<int>() + 1);
    text += "\n";
  }
  return text + "$EndElements\n";
}

std::string force_option(const json& place, const json& force) {
  return " --force=" + place[0].dump() + "," + place[1].dump() + "," + place[2].dump() + ":" + force[0].dump() + "," +
         force[1].dump() + "," + force[2].dump();
}

}  // namespace

TEST(KlangStress, ReferenceMeshGivesTheEnergyAndStressOfThePseudoInverse) {
  const Scratch scratch;
  const json mesh = read_json(klang::test::source_dir() + "/tests/reference/quasistatic.json")["mesh"];
  scratch.write("m.msh", reference_msh(mesh));
  for (const json& load : mesh["cases"]) {
    std::string forces;
    for (const auto& [node, force] : load["force_n"].items())
      forces += force_option(mesh["nodes_m"][std::stoul(node)], force);
    for (const auto& [options, key] : {std::pair{"", "inertia_relief_consistent"},
                                       {" --lumped-mass", "inertia_relief_lumped"},
                                       {" --literature paper", "euclidean_projection_as_printed"}}) {
      const auto run =
          run_klang("stress --mesh m.msh --element p1 --json s.json" + kGlass + forces + options, scratch.path());
      ASSERT_EQ(run.exit_code, 0) << run.err;
      const json s = read_json(scratch.path() / "s.json");
      const double energy = load[key]["energy_j"], stress = load[key]["largest_principal_stress_pa"];
      EXPECT_LE(std::abs(s["strain_energy_j"].get<double>() / energy - 1.0), 1e-10) << key;
      EXPECT_LE(std::abs(s["max_principal_stress_pa"].get<double>() / stress - 1.0), 1e-10) << key;
      const json& element = mesh["tetrahedra"][load[key]["its_element"].get<std::size_t>()];
      for (std::size_t a = 0; a < 3; ++a) {
        double centre = 0.0;
        for (const json& node : element) centre += 0.25 * mesh["nodes_m"][node.get<std::size_t>()][a].get<double>();
        EXPECT_LE(std::abs(s["place_m"][a].get<double>() - centre), 1e-12);
      }
      EXPECT_EQ(s["n_nodes"], 24);
      EXPECT_EQ(s["n_elements"], 36);
      EXPECT_LE(s["relative_residual"].get<double>(), 1e-12);
    }
  }
}

TEST(KlangStress, StruckBeamBendsAndSaysWhetherItWouldBreak) {
  const Scratch scratch;
  // Free beam struck in the middle: moment F L / 8, tension 6 M / (b h^2) = 15 MPa on the other side.
  const std::string struck = kBeam + "--force 0,0,0.005:0,0,-100 --json s.json ";
  for (const auto& [strength, breaks] : {std::pair{"10e6", true}, {"20e6", false}}) {
    const auto run = run_klang(struck + "-o s.vtu --tensile-strength-pa " + strength, scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json s = read_json(scratch.path() / "s.json");
    const double tension =
        s["max_is_at_a_load"].get<bool>() ? s["away_from_loads"]["stress_pa"] : s["max_principal_stress_pa"];
    EXPECT_LE(std::abs(tension / 15e6 - 1.0), 0.05);
    EXPECT_EQ(s["would_break_away_from_loads"], breaks);
    EXPECT_LE(std::abs(s["mass_kg"].get<double>() / (2600 * 0.2 * 1e-4) - 1.0), 1e-9);
    EXPECT_LE(std::abs(s["net_force_n"][2].get<double>() + 100.0), 1e-9);
    EXPECT_LE(std::abs(s["net_moment_n_m"][1].get<double>()), 1e-9);
    EXPECT_LE(std::abs(s["acceleration_m_s2"][2].get<double>() / (-100.0 / 0.052) - 1.0), 1e-9);
    EXPECT_LT(s["min_principal_stress"]["stress_pa"].get<double>(), -15e6);  // under the force
    EXPECT_GT(s["max_von_mises_stress"]["stress_pa"].get<double>(), 15e6);
  }
  EXPECT_GT(std::filesystem::file_size(scratch.path() / "s.vtu"), 10000u);
  EXPECT_EQ(run_klang("mesh s.vtu", scratch.path()).exit_code, 0);  // any reader of meshes takes it
  ASSERT_EQ(run_klang(struck, scratch.path()).exit_code, 0);
  EXPECT_FALSE(read_json(scratch.path() / "s.json").contains("would_break"));
}

TEST(KlangStress, LinearElementsThatLockAreWarnedOf) {
  const Scratch scratch;
  const auto run =
      run_klang("stress --shape box --dims length_m=0.2,width_m=0.01,height_m=0.01 --max-edge-m 0.01 --element p1" +
                    kGlass + "--force 0,0,0.005:0,0,-100 --json s.json",
                scratch.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("--element p2"), std::string::npos) << run.err;
  EXPECT_GE(read_json(scratch.path() / "s.json")["energy_share_missing"].get<double>(), 0.1);
}

TEST(KlangStress, SameRunGivesTheSameStressOnAnyNumberOfThreads) {
  const Scratch scratch;
  for (const char* threads : {"1", "2"})
    ASSERT_EQ(
        run_klang(kBeam + "--force 0.03,0.002,0.005:1,2,-100 --threads " + threads + " --json " + threads + ".json",
                  scratch.path())
            .exit_code,
        0);
  const json a = read_json(scratch.path() / "1.json"), b = read_json(scratch.path() / "2.json");
  for (const char* key : {"strain_energy_j", "max_principal_stress_pa", "energy_share_missing"})
    EXPECT_LE(std::abs(a[key].get<double>() / b[key].get<double>() - 1.0), 1e-10) << key;  // BLAS sums in another order
  EXPECT_EQ(a["place_m"], b["place_m"]);
}

TEST(KlangStress, BadInputIsRefusedInOneLine) {
  const Scratch scratch;
  const std::string out = " -o s.vtu --json s.json";
  expect_refused(scratch, kBeam + out, {"--force"});
  expect_refused(scratch, kBeam + "--force 0,0,0.02:0,0,-1" + out, {"surface", "0.015"});
  expect_refused(scratch, kBeam + "--force 0,0,0:0,0,-1" + out, {"surface"});  // inside
  expect_refused(scratch, kBeam + "--force 0,0,nan:0,0,-1" + out, {"--force", "nan"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,inf,-1" + out, {"--force", "inf"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005" + out, {"--force", "x,y,z:fx,fy,fz"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0" + out, {"--force"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0,1:2" + out, {"--force"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0,1e300" + out, {"--force", "too large"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0,0" + out, {"zero"});
  for (const char* strength : {"0", "-1", "nan", "inf"})
    expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0,1 --tensile-strength-pa=" + strength + out, {"trength"});
  expect_refused(scratch, "stress --force 0,0,0.005:0,0,1" + out, {"--shape"});
  expect_refused(scratch, kBeam + "--force 0,0,0.005:0,0,1 --lumped-mass --literature paper" + out, {"--lumped-mass"});
  // Two tetrahedra that share one node.
  scratch.write(
      "hinge.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 -1 0 0\n6 0 -1 0\n"
      "7 0 0 -1\n$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 1 6 5 7\n$EndElements\n");
  expect_refused(scratch, "stress --mesh hinge.msh --force 1,0,0:0,0,1" + kGlass + out, {"2 pieces"});
}

namespace {

const std::string kSoft = " --material lame_lambda_pa=6e8,lame_mu_pa=4e8,density_kg_m3=1000 ";
const std::string kHead = "f11,f12,f13,f21,f22,f23,f31,f32,f33\n";

}  // namespace

TEST(KlangStressHistory, StretchesGiveTheReferenceStates) {
  const Scratch scratch;
  const json rows =
      read_json(klang::test::source_dir() + "/tests/reference/plastic.json")["uniaxial_volume_preserving"]["rows"];
  std::string csv = kHead;
  for (const json& row : rows) {
    const double a = row["stretch"];
    const std::string side = json(1.0 / std::sqrt(a)).dump();
    csv += json(a).dump() + ",0,0,0," + side + ",0,0,0," + side + "\n";
  }
  scratch.write("h.csv", csv);
  const auto engineering = [](double gamma1, double gamma2) {
    return "--yield-stress-pa " + json(std::sqrt(1.5) * 4e8 * gamma1).dump() + " --plastic-strain-limit " +
           json(gamma2 / 2).dump();
  };
  for (const std::string& options : {std::string("--gamma1 0.02 --gamma2 0.15"), engineering(0.02, 0.15)}) {
    const auto run = run_klang("stress --history h.csv --json o.json " + options + kSoft, scratch.path());
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const json states = read_json(scratch.path() / "o.json")["states"];
    ASSERT_EQ(states.size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const double stress = states[i]["pk2_pa"][0], energy = states[i]["dissipated_j_m3"];
      EXPECT_LE(std::abs(stress / rows[i]["PK2_xx"].get<double>() - 1.0), 1e-12) << i;
      EXPECT_LE(std::abs(energy / rows[i]["dissipated_density"].get<double>() - 1.0), 1e-12) << i;
    }
  }
}

TEST(KlangStressHistory, WhatItCannotDriveIsRefused) {
  const Scratch scratch;
  scratch.write("h.csv", kHead + "1.1,0,0,0,1,0,0,0,1\n");
  scratch.write("inverted.csv", kHead + "1,0,0,0,1,0,0,0,1\n-1.1,0,0,0,1,0,0,0,1\n");
  scratch.write("short.csv", "f11,f12\n1,0\n");
  expect_refused(scratch, "stress --history h.csv --gamma1 0.1 --gamma2 1.2248" + kSoft, {"1.2247"});
  expect_refused(scratch, "stress --history h.csv --yield-stress-pa 1e6 --plastic-strain-limit 0.6124" + kSoft,
                 {"plastic"});
  expect_refused(scratch, "stress --history h.csv --gamma2 0.1" + kSoft, {"--gamma1"});
  expect_refused(scratch, "stress --history inverted.csv" + kSoft, {"line 3"});
  expect_refused(scratch, "stress --history short.csv" + kSoft, {"f13"});
  expect_refused(scratch, "stress --history h.csv --force 0,0,0:1,0,0" + kSoft, {"--history"});
  expect_refused(scratch, "stress --shape box --dims length_m=1,width_m=1,height_m=1" + kSoft, {"--force"});
}
