#include <gtest/gtest.h>

#include <filesystem>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/scene/scene_check.hpp"
#include "tests/places.hpp"

namespace klang::scene {
namespace {

const std::string kScene = R"(
[world.floor]
material = "glass"
[[material]]
name = "glass"
preset = "soda_lime_glass"
restitution = 0.6
friction = 0.3
damping = { model = "loss_factor", loss_factor = 1e-3 }
[[body]]
name = "tile"
shape = { kind = "box", length_m = 0.1, width_m = 0.1, height_m = 0.008 }
material = "glass"
position_m = [0, 0, 0.3]
)";

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

std::string complaint(const std::string& toml) {
  try {
    const Scene scene = parse_scene(toml, "scene.toml");
    check_scene(scene);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(SceneParser, ReadsWhatStandsThereAndLeavesDefaults) {
  const Scene scene = parse_scene(kScene, "scene.toml");
  ASSERT_EQ(scene.bodies.size(), 1u);
  EXPECT_EQ(scene.bodies[0].position_m.z(), 0.3);
  EXPECT_TRUE(scene.bodies[0].sounds());
  ASSERT_TRUE(scene.solver.floor);
  EXPECT_EQ(scene.solver.floor->restitution, 0.6);
  EXPECT_EQ(scene.solver.rate_hz, 10000.0);
  EXPECT_FALSE(scene.duration_s);
  EXPECT_EQ(scene.materials[0].damping->law->name(), "loss_factor");
  const SceneCheckDocument check = check_scene(scene);
  EXPECT_LE(std::abs(check.bodies[0].mass_kg - 2500 * 0.1 * 0.1 * 0.008), 1e-12);
}

TEST(SceneParser, ComplainsInOneLineThatNamesThePlace) {
  const struct {
    std::string toml;
    const char* part;
  } cases[] = {
      {replaced(kScene, "position_m", "positon_m"), "positon_m: unknown key"},
      {replaced(kScene, "material = \"glass\"\nposition", "material = \"glas\"\nposition"), "unknown material"},
      {replaced(kScene, "name = \"tile\"", "name = \"floor\""), "is no name of a body"},
      {replaced(kScene, "restitution = 0.6", "restitution = 1.6"), "restitution"},
      {replaced(kScene, "loss_factor = 1e-3 }", "loss_factor = 1e-3, rayleigh_mass_per_s = 3 }"), "has no meaning"},
      {replaced(kScene, "height_m = 0.008 }", "height_m = 0 }"), "height_m"},
      {replaced(kScene, "[0, 0, 0.3]", "[0, 0, 0.003]"), "overlap"},
      {kScene + "velocity_m_s = [0, 0, -500]\n", "moves too far in a step"},
      {kScene + "fixed = true\nvelocity_m_s = [0, 0, -5]\n", "a fixed body does not move"},
      {kScene + "[[body]]\nname = \"tile\"\nshape = { kind = \"sphere\", radius_m = 0.1 }\nmaterial = \"glass\"\n",
       "given twice"},
      {kScene + "[[body]]\nname = \"tile/12\"\nshape = { kind = \"sphere\", radius_m = 0.1 }\nmaterial = \"glass\"\n",
       "what a piece may be called"},
      {kScene + "[[body]]\nname = \"b\"\nmaterial = \"glass\"\n", "has no shape"},
      {kScene + "mesh = \"x.stl\"\n", "has a shape and a mesh"},
      {kScene + "[sound]\nband_hz = [500, 20]\n", "is no band"},
      {kScene +
           "[sound.listener]\npath = [{ time_s = 1, position_m = [0, 0, 1] }, { time_s = 1, position_m = [0, 0, 2] "
           "}]\n",
       "does not rise"},
      {kScene + "[sound.listener]\nposition_m = [0, 0, 1]\npath = [{ time_s = 1, position_m = [0, 0, 1] }]\n",
       "stands beside a path"},
      {kScene + "model = \"breakable\"\n", "needs a strength and a toughness"},
      {kScene + "stress_edge_m = 0.01\n", "belongs to a breakable body"},
      {replaced(kScene, "name = \"tile\"", "name = \"ti\\nle\""), "control character"},
      {kScene + "[sound.listener]\nposition_m = [0, 0, -0.5]\n", "below the floor"},
      {"[[body]]\nname = \"b\"\n", "material"},
      {kScene + "[[cord]]\nbody = \"tyle\"\nat_m = [0, 0, 0]\nto_m = [0, 0, 1]\n", "unknown body"},
      {kScene + "[[cord]]\nbody = \"tyle\"\nat_m = [0, 0, 0]\nto_m = [0, 0, 1]\n", "did you mean tile"},
      {replaced(kScene, "height_m = 0.008 }", "height_m = 1e-9 }"), "dimensions too different"},
      {kScene + "[[cord]]\nbody = \"tile\"\nat_m = [0, 0, 0]\nto_m = [0, 0, 1]\nlength_m = 0.6\n",
       "farther apart than the cord is long"},
      {kScene + "[[cord]]\nbody = \"tile\"\nother = \"tile\"\nat_m = [0, 0, 0]\nto_m = [0, 0, 1]\n", "tied to itself"},
      {kScene + "[[hinge]]\nbody = \"tile\"\nat_m = [0, 0, 0]\naxis = [0, 0, 0]\n", "has no direction"},
      {kScene + "fixed = true\n[[hinge]]\nbody = \"tile\"\nat_m = [0, 0, 0]\n", "ties what does not move"},
  };
  for (const auto& c : cases) {
    const std::string text = complaint(c.toml);
    EXPECT_NE(text.find(c.part), std::string::npos) << c.part << " | " << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(text.find(".toml:"), text.rfind(".toml:")) << "the place stands twice: " << text;
  }
}

TEST(SceneParser, TwoBodiesThatOverlapAreNamed) {
  const std::string text =
      complaint(kScene +
                "[[body]]\nname = \"ball\"\nshape = { kind = \"sphere\", radius_m = 0.05 }\nmaterial = "
                "\"glass\"\nposition_m = [0, 0, 0.34]\n");
  EXPECT_NE(text.find("tile"), std::string::npos) << text;
  EXPECT_NE(text.find("ball"), std::string::npos) << text;
}

TEST(SceneParser, DocumentationHoldsTheKeys) {
  const std::string page = read_file(std::filesystem::path(klang::test::source_dir()) / "docs/scenes.md");
  EXPECT_NE(page.find(scene_schema_markdown()), std::string::npos) << scene_schema_markdown();
}

TEST(SceneParser, EveryExampleSceneCanBeRun) {
  const std::filesystem::path scenes = std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes";
  int n = 0;
  for (const char* folder : {"s02", "sb", "b99", "d02"}) {
    for (const auto& entry : std::filesystem::directory_iterator(scenes / folder)) {
      if (entry.path().extension() != ".toml") continue;
      ++n;
      EXPECT_NO_THROW(check_scene(read_scene(entry.path()))) << entry.path();
    }
  }
  EXPECT_GE(n, 8);
}

}  // namespace
}  // namespace klang::scene
