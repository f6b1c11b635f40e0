// klang scene run --resume with a later end than before.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/foundation/base/output_file.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

using klang::read_file;
using klang::test::read_json;
using klang::test::run_klang;
using klang::test::Scratch;

namespace {

// With the later end a tile broke in the meantime, whose pieces stand where one of a cracking bar stood: none is heard by its mesh.
TEST(KlangSceneResume, PiecesOfAnEarlierEndDoNotStay) {
  const Scratch scratch;
  scratch.write("still.csv", "time_s,x,y,z\n0,0,0,0\n");
  scratch.write("pull.csv", "time_s,x,y,z\n0,0,0,0\n0.002,0.6,0,0\n");
  scratch.write("both.toml", R"(
duration_s = 0.03
[world]
gravity_m_s2 = [0, 0, 0]
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
[[material]]
name = "soft"
lame_lambda_pa = 4e6
lame_mu_pa = 4e6
density_kg_m3 = 1000
damping = { model = "loss_factor", loss_factor = 5e-2 }
[[body]]
name = "bar"
shape = { kind = "box", length_m = 0.3, width_m = 0.1, height_m = 0.1 }
material = "soft"
model = "cracking"
max_edge_m = 0.06
position_m = [0, 0, 1]
[[body]]
name = "tile"
shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.006 }
material = "glass"
model = "breakable"
position_m = [0, 0, 0.072]
velocity_m_s = [0, 0, -2.2]
rotation_deg = [20, 10, 0]
stress_edge_m = 0.02
sound = "none"
[crack]
strength_pa = 4e4
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
[sound]
band_hz = [20, 300]
)");
  const auto pieces = [&](const std::string& folder) {
    std::map<std::string, std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(scratch.path() / folder / "pieces"))
      found[entry.path().filename().string()] = read_file(entry.path());
    return found;
  };
  ASSERT_EQ(run_klang("scene run both.toml -o whole -q --no-frames", scratch.path()).exit_code, 0);
  ASSERT_EQ(run_klang("scene run both.toml -o out --until-s 0.015 -q --no-frames", scratch.path()).exit_code, 0);
  ASSERT_TRUE(pieces("out").contains("2.vtu"));  // bar/1
  ASSERT_EQ(run_klang("scene run both.toml -o out --resume -q --no-frames", scratch.path()).exit_code, 0);
  EXPECT_EQ(read_json(scratch.path() / "out/scene.json")["bodies"][2]["name"], "tile/1");
  EXPECT_EQ(pieces("out"), pieces("whole"));
  EXPECT_EQ(read_file(scratch.path() / "out/sound.wav"), read_file(scratch.path() / "whole/sound.wav"));
}

}  // namespace
