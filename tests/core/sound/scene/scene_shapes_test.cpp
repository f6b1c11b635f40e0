// What cracking bodies look like at each frame: deformed, cracked, in pieces; kept, bounded, written and read again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/vtk_xml.hpp"
#include "core/sound/scene/scene_frames.hpp"
#include "core/sound/scene/scene_motion.hpp"

namespace klang::scene {
namespace {

using nlohmann::json;

/// A bar that is drawn at its end by a ramp of 10 ms to 0.1 m/s, and parts.
class SceneShapes : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(::testing::TempDir()) / ("shapes-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    std::ofstream(folder_ / "still.csv") << "time_s,x,y,z\n0,0,0,0\n";
    std::ofstream(folder_ / "pull.csv") << "time_s,x,y,z\n0,0,0,0\n0.01,0.1,0,0\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  Scene bar(double strength_pa) const {
    return parse_scene(
        "duration_s = 0.04\n[world]\ngravity_m_s2 = [0, 0, 0]\n[frames]\nrate_hz = 500\n[[material]]\nname = \"soft\"\n"
        "lame_lambda_pa = 4e6\nlame_mu_pa = 4e6\ndensity_kg_m3 = 1000\n[[body]]\nname = \"bar\"\nmaterial = \"soft\"\n"
        "model = \"cracking\"\nsound = \"none\"\nmax_edge_m = 0.06\nposition_m = [1, 2, 3]\n"
        "shape = { kind = \"box\", length_m = 0.3, width_m = 0.1, height_m = 0.1 }\n[crack]\nviscosity_mu_pa_s = 400\n"
        "strength_pa = " +
            std::to_string(strength_pa) + "\n[[hold]]\nbody = \"bar\"\nwhere = \"x=min\"\ncsv = \"still.csv\"\n" +
            "[[hold]]\nbody = \"bar\"\nwhere = \"x=max\"\nkind = \"velocity\"\ncsv = \"pull.csv\"\n",
        folder_ / "scene.toml");
  }
  static double drawn_m(double time_s) { return time_s < 0.01 ? 5.0 * time_s * time_s : 0.1 * (time_s - 0.005); }
  static Frames frames_of(const Scene& scene, const SceneMotion& motion) {
    std::vector<FrameBody> bodies = frame_bodies(scene);
    while (bodies.size() < motion.log.bodies.size())
      bodies.push_back({motion.log.bodies[bodies.size()].name, 0, nullptr, {}});
    return {scene, motion.log, bodies, motion.end_s, motion.shapes};
  }
  std::filesystem::path folder_;
};

/// Volume inside, and how many edges have no second triangle that runs the other way.
std::pair<double, int> volume_and_open_edges(const DeformedBody& body, const DeformedFrame& frame) {
  double volume = 0.0;
  std::map<std::pair<int, int>, int> edges;
  const auto place = [&](std::int32_t k) -> Eigen::Vector3d {
    return Eigen::Vector3f(frame.places_m.data() + 3 * k).cast<double>() - Eigen::Vector3d(1, 2, 3);
  };
  for (const auto& t : body.surfaces[static_cast<std::size_t>(frame.surface)].triangles) {
    volume += place(t[0]).dot(place(t[1]).cross(place(t[2]))) / 6.0;
    for (std::size_t k = 0; k < 3; ++k) {
      ++edges[{t[k], t[(k + 1) % 3]}];
      --edges[{t[(k + 1) % 3], t[k]}];
    }
  }
  int open = 0;
  for (const auto& [edge, n] : edges) open += n == 0 ? 0 : 1;
  return {volume, open};
}

TEST_F(SceneShapes, EachFrameHoldsTheClosedSurfaceOfThatMoment) {
  const SceneMotion motion = move(bar(5e4));
  ASSERT_EQ(motion.shapes.bodies.size(), 1u);
  const DeformedBody& body = motion.shapes.bodies[0];
  EXPECT_EQ(body.stride, 1);
  ASSERT_EQ(body.frames.size(), 21u);
  ASSERT_GE(body.surfaces.size(), 2u);
  for (const DeformedFrame& frame : body.frames) {
    const double time_s = frame.number / 500.0;
    float most = -HUGE_VALF;
    for (std::size_t c = 0; c < frame.places_m.size(); c += 3) most = std::max(most, frame.places_m[c]);
    EXPECT_LE(std::abs(most - (1.15 + drawn_m(time_s))), 1e-6) << time_s;
    const auto [volume, open] = volume_and_open_edges(body, frame);
    EXPECT_EQ(open, 0) << time_s;
    EXPECT_LE(std::abs(volume / 3e-3 - 1.0), 0.01) << time_s;
  }
  EXPECT_EQ(body.frames.front().surface, 0);
  EXPECT_EQ(static_cast<std::size_t>(body.frames.back().surface), body.surfaces.size() - 1);
}

TEST_F(SceneShapes, TheSeriesShowsTheBodyDrawnAndThenItsPieces) {
  const Scene scene = bar(5e4);
  const SceneMotion motion = move(scene);
  ASSERT_GE(motion.log.bodies.size(), 3u);
  const Frames frames = frames_of(scene, motion);
  const double broken_s = *motion.log.broken_s(0);
  for (const std::size_t frame : {std::size_t{1}, std::size_t{20}}) {
    const mesh::VtkXmlFile file(frames.vtp(frame), "frame", "PolyData");
    const auto owner = file.find(mesh::VtkPlace::kCellData, "body");
    ASSERT_TRUE(owner.has_value());
    const auto [low, high] = std::minmax_element(owner->integers.begin(), owner->integers.end());
    EXPECT_EQ(*low, frame / 500.0 < broken_s ? 0 : 1);
    EXPECT_EQ(*high, frame / 500.0 < broken_s ? 0 : static_cast<std::int64_t>(motion.log.bodies.size()) - 1);
    EXPECT_LE(std::abs(file.points().col(0).maxCoeff() - (1.15 + drawn_m(frame / 500.0))), 1e-6);
  }
  EXPECT_LE(std::abs(frames.high_m().x() - (1.15 + drawn_m(0.04))), 1e-6);
}

/// Numbers of a glTF file's accessors.
struct Gltf {
  json document;
  std::string data;
  explicit Gltf(const std::string& file) {
    std::uint32_t head[5];
    std::memcpy(head, file.data(), sizeof head);
    document = json::parse(file.substr(20, head[3]));
    data = file.substr(28 + head[3]);
  }
  std::vector<float> floats(const json& accessor) const {
    const json& a = document["accessors"][accessor.get<std::size_t>()];
    const json& view = document["bufferViews"][a["bufferView"].get<std::size_t>()];
    std::vector<float> values(view["byteLength"].get<std::size_t>() / sizeof(float));
    std::memcpy(values.data(), data.data() + view["byteOffset"].get<std::size_t>(), values.size() * sizeof(float));
    return values;
  }
  /// Times and values of a node's keys; empty: it has none.
  std::pair<std::vector<float>, std::vector<float>> keys(std::size_t node, const char* path) const {
    for (const json& channel : document["animations"][0]["channels"]) {
      if (channel["target"]["node"] != node || channel["target"]["path"] != path) continue;
      const json& sampler = document["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
      return {floats(sampler["input"]), floats(sampler["output"])};
    }
    return {};
  }
};

TEST_F(SceneShapes, TheGltfHasOneNodeThereAtEachFrameWithTheShapeOfThatFrame) {
  const Scene scene = bar(5e4);
  const SceneMotion motion = move(scene);
  const Gltf gltf(frames_of(scene, motion).glb());
  for (const DeformedFrame& frame : motion.shapes.bodies[0].frames) {
    const float time = static_cast<float>(frame.number / 500.0);
    int n_there = 0;
    for (std::size_t node = 1; node < gltf.document["nodes"].size(); ++node) {
      const auto [switch_s, size] = gltf.keys(node, "scale");
      std::size_t key = 0;
      while (key + 1 < switch_s.size() && switch_s[key + 1] <= time) ++key;
      if (!switch_s.empty() && size[3 * key] == 0.0F) continue;
      ++n_there;
      const json& primitive =
          gltf.document["meshes"][gltf.document["nodes"][node]["mesh"].get<std::size_t>()]["primitives"][0];
      std::vector<float> shape = gltf.floats(primitive["attributes"]["POSITION"]);
      const auto [times, weights] = gltf.keys(node, "weights");
      for (std::size_t i = 0; i < times.size(); ++i) {
        if (times[i] != time) continue;
        const json& targets = primitive["targets"];
        ASSERT_EQ(weights.size(), times.size() * targets.size());
        for (std::size_t k = 0; k < targets.size(); ++k) {
          const std::vector<float> moved = gltf.floats(targets[k]["POSITION"]);
          for (std::size_t c = 0; c < shape.size(); ++c) shape[c] += weights[i * targets.size() + k] * moved[c];
        }
      }
      ASSERT_EQ(shape.size(), frame.places_m.size()) << time;
      for (std::size_t c = 0; c < shape.size(); ++c) ASSERT_LE(std::abs(shape[c] - frame.places_m[c]), 1e-6F) << time;
    }
    EXPECT_EQ(n_there, 1) << time;
  }
}

TEST_F(SceneShapes, AModalBodySagsInItsFramesAndStaysWhereItIsHeld) {
  const Scene scene = parse_scene(
      "duration_s = 0.02\n[world]\ngravity_m_s2 = [0, 0, -10]\n[frames]\nrate_hz = 1000\n[[material]]\nname = "
      "\"soft\"\n"
      "youngs_modulus_pa = 1e8\npoissons_ratio = 0\ndensity_kg_m3 = 1000\n[[body]]\nname = \"bar\"\nmaterial = "
      "\"soft\"\n"
      "model = \"modal\"\nsound = \"none\"\nmax_edge_m = 0.02\n"
      "shape = { kind = \"box\", length_m = 0.2, width_m = 0.02, height_m = 0.02 }\n[modal]\nn_modes = 3\n"
      "[[hold]]\nbody = \"bar\"\nat_m = [0, 0.01, 0.01]\ncsv = \"still.csv\"\n",
      folder_ / "scene.toml");
  const SceneMotion motion = move(scene);
  ASSERT_EQ(motion.shapes.bodies.size(), 1u);
  const DeformedBody& body = motion.shapes.bodies[0];
  ASSERT_EQ(body.frames.size(), 21u);
  ASSERT_EQ(body.surfaces.size(), 1u);
  const std::vector<float>& start = body.frames[0].places_m;
  int n_held = 0;
  double bent_m = 0.0;  // how far the ends of the edge are below its middle, about which the bar rolls
  for (const DeformedFrame& frame : body.frames) {
    double ends_m = 0.0, middle_m = 0.0;
    for (std::size_t c = 0; c < start.size(); c += 3) {
      if (std::abs(start[c + 2] - 0.01F) > 1e-6F || std::abs(start[c + 1] - 0.01F) > 1e-6F) continue;
      if (std::abs(std::abs(start[c]) - 0.1F) < 1e-6F) ends_m += 0.5 * frame.places_m[c + 2];
      if (std::abs(start[c]) > 1e-6F) continue;
      ++n_held;
      middle_m = frame.places_m[c + 2];
      for (std::size_t k = 0; k < 3; ++k) EXPECT_LE(std::abs(frame.places_m[c + k] - start[c + k]), 1e-7F);
    }
    bent_m = std::max(bent_m, middle_m - ends_m);
  }
  EXPECT_EQ(n_held, 21);
  // It is put there unbent and swings about what its load bends it by: halves that are cantilevers, w (L/2)^4 / (8 E I); the one mode
  // that is symmetric there, of 22.37^2 E I / (rho A L^4) and 2 and -1.2157 at ends and middle, gives the same within a percent. The load
  // is 5/8 of the weight: the bar rolls about the edge, its centre begins to fall with g a^2/4 / (a^2/6 + a^2/2), 3/8 of g.
  const double sag_m = 0.625 * 4.0 * std::pow(0.1, 4) / (8.0 * 1e8 * std::pow(0.02, 4) / 12.0);
  EXPECT_GE(bent_m, 1.75 * sag_m);
  EXPECT_LE(bent_m, 2.1 * sag_m);
  EXPECT_EQ(mesh::VtkXmlFile(frames_of(scene, motion).vtp(7), "frame", "PolyData").points().rows(),
            static_cast<Eigen::Index>(start.size() / 3));
}

TEST_F(SceneShapes, TheyAreBoundedAndThenSayWhichFramesChange) {
  Scene scene = bar(1e9);
  const std::size_t all = [&] {
    const DeformedShapes shapes = move(scene).shapes;
    std::size_t sum = 0;
    for (const DeformedFrame& frame : shapes.bodies[0].frames) sum += 4 * frame.places_m.size();
    return sum;
  }();
  scene.frames.most_shape_bytes = all / 3;
  const SceneMotion motion = move(scene);
  EXPECT_EQ(motion.shapes.bodies[0].stride, 8);  // of 21 frames with their triangles a third is less than 7
  std::size_t sum = 0;
  for (const DeformedFrame& frame : motion.shapes.bodies[0].frames) {
    EXPECT_EQ(frame.number % motion.shapes.bodies[0].stride, 0);
    sum += 4 * frame.places_m.size();
  }
  EXPECT_LE(sum, scene.frames.most_shape_bytes);
  ASSERT_EQ(motion.cracks->warnings.size(), 1u);
  EXPECT_NE(motion.cracks->warnings[0].find("every 8th"), std::string::npos);
  const Frames frames = frames_of(scene, motion);
  EXPECT_EQ(mesh::VtkXmlFile(frames.vtp(15), "frame", "PolyData").points(),
            mesh::VtkXmlFile(frames.vtp(8), "frame", "PolyData").points());
}

TEST_F(SceneShapes, TheirFileComesBackToTheBitOrIsRefused) {
  const SceneMotion motion = move(bar(5e4));
  const int n_rows = static_cast<int>(motion.log.bodies.size());
  const std::filesystem::path path = folder_ / "shapes.bin";
  write_shapes(path, motion.shapes);
  const DeformedShapes read = read_shapes(path, n_rows);
  ASSERT_EQ(read.bodies.size(), 1u);
  const DeformedBody &a = motion.shapes.bodies[0], &b = read.bodies[0];
  ASSERT_EQ(a.frames.size(), b.frames.size());
  ASSERT_EQ(a.surfaces.size(), b.surfaces.size());
  for (std::size_t i = 0; i < a.frames.size(); ++i) {
    EXPECT_EQ(a.frames[i].places_m, b.frames[i].places_m);
    EXPECT_EQ(a.frames[i].number, b.frames[i].number);
    EXPECT_EQ(a.frames[i].surface, b.frames[i].surface);
  }
  for (std::size_t i = 0; i < a.surfaces.size(); ++i) {
    EXPECT_EQ(a.surfaces[i].triangles, b.surfaces[i].triangles);
    EXPECT_EQ(a.surfaces[i].rows, b.surfaces[i].rows);
  }
  EXPECT_THROW(read_shapes(path, 1), InputError) << "pieces that the log does not know";
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(2000);
  file.put('x');
  file.close();
  EXPECT_THROW(read_shapes(path, n_rows), InputError);
  EXPECT_THROW(read_shapes(folder_ / "none.bin", n_rows), InputError);
}

TEST_F(SceneShapes, NoneAreKeptWhereNoFramesAreWanted) {
  Scene scene = bar(1e9);
  scene.frames.glb = scene.frames.vtp = false;
  EXPECT_TRUE(move(scene).shapes.bodies.empty());
}

}  // namespace
}  // namespace klang::scene
