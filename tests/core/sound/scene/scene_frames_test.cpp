// Frames of a scene: VTK series and glTF with keyframes.
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/geometry/files/vtk_xml.hpp"
#include "core/sound/scene/scene_frames.hpp"

using namespace klang;
using nlohmann::json;

namespace {

const char* const kTwo = R"(
duration_s = 1.0
[[material]]
name = "m"
preset = "steel"
[[body]]
name = "box"
shape = { kind = "box", length_m = 0.2, width_m = 0.1, height_m = 0.05 }
material = "m"
sound = "none"
[[body]]
name = "twin"
shape = { kind = "box", length_m = 0.2, width_m = 0.1, height_m = 0.05 }
material = "m"
position_m = [1, 0, 0]
fixed = true
[frames]
rate_hz = 10
)";

/// The box falls by 1 m in 0.5 s at even speed and breaks then into a piece that stays.
events::EventLog falling_log() {
  events::EventLog log;
  log.bodies = {{"box", -1}, {"twin", -1}, {"box/1", 0}};
  log.poses = {{0, 0.0, {0, 0, 2}}, {0, 0.5, {0, 0, 1}}, {2, 0.5, {0, 0, 1}}, {2, 1.0, {0, 0, 1}}};
  log.fractures = {{0.5, 0}};
  return log;
}

struct Drawn {
  scene::Scene scene = scene::parse_scene(kTwo, "two.toml");
  events::EventLog log = falling_log();
  scene::Frames frames = [this] {
    std::vector<scene::FrameBody> bodies = scene::frame_bodies(scene);
    bodies.push_back({"box/1", 0, bodies[0].surface, {}});
    return scene::Frames(scene, log, bodies, 1.0);
  }();
};

TEST(SceneFrames, AFrameHoldsTheBodiesThatAreThereInTheWorld) {
  const Drawn drawn;
  ASSERT_EQ(drawn.frames.times_s().size(), 11u);
  for (const std::size_t frame : {std::size_t{2}, std::size_t{8}}) {
    const mesh::VtkXmlFile file(drawn.frames.vtp(frame), "frame", "PolyData");
    const auto owner = file.find(mesh::VtkPlace::kCellData, "body");
    ASSERT_TRUE(owner.has_value());
    const std::int64_t whole = *std::min_element(owner->integers.begin(), owner->integers.end());
    EXPECT_EQ(whole, frame == 2 ? 0 : 1);
    EXPECT_EQ(*std::max_element(owner->integers.begin(), owner->integers.end()), frame == 2 ? 1 : 2);
    const mesh::Points points = file.points();
    const double top = points.col(2).maxCoeff(), centre = frame == 2 ? 2.0 - 0.4 : 1.0;
    EXPECT_NEAR(top, centre + 0.025, 1e-6);
    EXPECT_EQ(file.n_cells(), static_cast<std::int64_t>(owner->size()));
  }
  EXPECT_NE(drawn.frames.pvd().find("timestep=\"0.5\" part=\"0\" file=\"frames/000005.vtp\""), std::string::npos);
  EXPECT_LE(drawn.frames.low_m().z(), -0.025);
  EXPECT_GE(drawn.frames.high_m().z(), 2.025);
}

TEST(SceneFrames, TheGltfIsWellFormedAndHasKeyframesOfPlaceTurnAndBirth) {
  const Drawn drawn;
  const std::string file = drawn.frames.glb();
  std::uint32_t head[5];
  std::memcpy(head, file.data(), sizeof head);
  EXPECT_EQ(head[0], 0x46546C67u);  // "glTF"
  EXPECT_EQ(head[1], 2u);
  EXPECT_EQ(head[2], file.size());
  EXPECT_EQ(head[4], 0x4E4F534Au);  // "JSON"
  const json document = json::parse(file.substr(20, head[3]));
  std::uint32_t binary[2];
  std::memcpy(binary, file.data() + 20 + head[3], sizeof binary);
  EXPECT_EQ(binary[1], 0x004E4942u);  // "BIN"
  EXPECT_EQ(binary[0] % 4, 0u);
  const std::string data = file.substr(28 + head[3]);
  EXPECT_EQ(data.size(), binary[0]);
  for (const json& view : document["bufferViews"])
    EXPECT_LE(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>(), data.size());
  EXPECT_EQ(document["meshes"].size(), 1u) << "bodies of one shape share it";
  ASSERT_EQ(document["nodes"].size(), 4u);
  EXPECT_EQ(document["nodes"][1]["name"], "box");

  const auto floats = [&](const json& accessor) {
    const json& view = document["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    std::vector<float> values(view["byteLength"].get<std::size_t>() / sizeof(float));
    std::memcpy(values.data(), data.data() + view["byteOffset"].get<std::size_t>(), values.size() * sizeof(float));
    return values;
  };
  const json& animation = document["animations"][0];
  const auto key = [&](int node, const std::string& path) {
    for (const json& channel : animation["channels"]) {
      if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
      const json& sampler = animation["samplers"][channel["sampler"].get<std::size_t>()];
      return std::pair(floats(document["accessors"][sampler["input"].get<std::size_t>()]),
                       floats(document["accessors"][sampler["output"].get<std::size_t>()]));
    }
    return std::pair<std::vector<float>, std::vector<float>>();
  };
  const auto [fall_s, fall_m] = key(1, "translation");
  ASSERT_EQ(fall_s.size(), 5u);  // until it breaks
  EXPECT_NEAR(fall_m[3 * 2 + 2], 1.6, 1e-6);
  EXPECT_TRUE(key(2, "translation").first.empty()) << "a body at rest has no keys";
  const auto [gone_s, gone] = key(1, "scale");
  EXPECT_EQ(gone_s, (std::vector<float>{0.0F, 0.5F}));
  EXPECT_EQ(gone, (std::vector<float>{1, 1, 1, 0, 0, 0}));
  const auto [born_s, born] = key(3, "scale");
  EXPECT_EQ(born_s, (std::vector<float>{0.0F, 0.5F}));
  EXPECT_EQ(born, (std::vector<float>{0, 0, 0, 1, 1, 1}));
}

}  // namespace
