#include <gtest/gtest.h>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "tests/places.hpp"

namespace klang::liquid_scene {
namespace {

const std::string kDomain =
    "[domain]\nsize_m = [0.1, 0.1, 0.2]\ncell_m = 0.01\nduration_s = 0.5\nframe_rate_hz = 100\n";
const std::string kPool = "[[pool]]\ndepth_m = 0.05\n";

LiquidScene parsed(const std::string& text) { return parse_liquid_scene(text, "scene.toml", "."); }

/// The complaint about a scene, in one line.
std::string complaint(const std::string& text) {
  try {
    parsed(text);
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "no complaint";
}

TEST(LiquidScene, IsReadWithItsDefaults) {
  const LiquidScene scene = parsed(kDomain + kPool);
  EXPECT_EQ(scene.setup.shape.nz, 20);
  EXPECT_EQ(scene.n_frames(), 51U);
  EXPECT_EQ(scene.setup.options.longest_step_s, 1e-3);
  EXPECT_FALSE(scene.setup.options.tension);
  EXPECT_FALSE(scene.entrainment.given);
  EXPECT_EQ(scene.transfer.method, TransferMethod::kReciprocal);
  EXPECT_EQ(scene.transfer.bins_per_octave, 6);
  EXPECT_EQ(scene.transfer.liquid_loss_factor, 0.02);
  EXPECT_TRUE(is_liquid_scene(kDomain));
  EXPECT_FALSE(is_liquid_scene("[[body]]\nname = \"a\"\n"));
}

TEST(LiquidScene, BadOnesAreRefusedWithOneLineThatNamesTheKey) {
  struct Case {
    std::string text, word;
  };
  const std::string sphere = "[[solid]]\nshape = { kind = \"sphere\", radius_m = 0.02 }\nposition_m = ";
  const std::string inlet = "[[inlet]]\nshape = { kind = \"disc\", radius_m = 0.02 }\nspeed_m_s = 0.4\nposition_m = ";
  const Case cases[] = {
      {kDomain, "no liquid"},
      {kDomain + kPool + "depth = 3\n", "depth"},
      {kDomain + "[[pool]]\ndepth_m = 0.005\n", "larger than the pool"},
      {kDomain + "[[pool]]\ndepth_m = 0.2\n", "fills the box"},
      {kDomain + "[[pool]]\nlow_m = [0, 0, 0]\n", "high_m"},
      {kDomain + kPool + sphere + "[0.5, 0.05, 0.05]\n", "outside the box"},
      {kDomain + kPool + sphere + "[0.05, 0.05, 0.05]\nmotion = \"free\"\n", "density_kg_m3"},
      {kDomain + kPool + sphere + "[0.05, 0.05, 0.05]\nmotion = \"flying\"\n", "unknown motion"},
      {kDomain + kPool + inlet + "[0.0, 0.05, 0.15]\n", "wall"},
      {kDomain + kPool + inlet + "[0.05, 0.05, 0.0]\n", "wall"},
      {kDomain + kPool + sphere + "[0.05, 0.05, 0.15]\n" + inlet + "[0.05, 0.05, 0.16]\n", "inlet runs into"},
      {kDomain + kPool + inlet + "[0.05, 0.05, 0.15]\nflow_l_s = 0.6\n", "flow_l_s"},
      {kDomain + kPool + "[entrainment]\ncoverage = 0.5\n", "attempts_per_m2_s"},
      {kDomain + kPool + "[transfer]\nmethod = \"magic\"\n", "method"},
      {"[domain]\nsize_m = [0.1, 0.1, 0.2]\ncell_m = 0.03\nduration_s = 1\n" + kPool, "whole number of cells"},
      {"[domain]\nsize_m = [10, 10, 10]\ncell_m = 0.001\nduration_s = 1\n" + kPool, "too many cells"},
  };
  for (const Case& c : cases)
    EXPECT_NE(complaint(c.text).find(c.word), std::string::npos) << c.text << complaint(c.text);
  EXPECT_NO_THROW(parsed(kDomain + kPool + sphere + "[0.11, 0.05, 0.05]\n")) << "half of it is in the box";
  EXPECT_NO_THROW(parsed(kDomain + kPool + inlet + "[0.05, 0.05, 0.15]\nflow_l_s = 0.504\n")) << "within 1 %";
}

TEST(LiquidScene, DocumentationHoldsTheKeys) {
  const std::string page = read_file(std::filesystem::path(klang::test::source_dir()) / "docs/liquid.md");
  EXPECT_NE(page.find(liquid_scene_schema_markdown()), std::string::npos) << liquid_scene_schema_markdown();
}

TEST(LiquidScene, ExamplesAreThePapersGrids) {
  const std::filesystem::path folder =
      std::filesystem::path(klang::test::source_dir()) / "datasets-synthetic/scenes/liquid";
  struct Case {
    const char* file;
    int nx, ny, nz;
    double duration_s;
  };
  for (const Case& c : {Case{"droplet.toml", 70, 70, 90, 6.4}, Case{"splash.toml", 90, 90, 100, 1.5},
                        Case{"pouring.toml", 50, 50, 80, 5.0}, Case{"water_step.toml", 100, 60, 30, 8.6}}) {
    const LiquidScene scene = read_liquid_scene(folder / c.file);
    EXPECT_EQ(scene.setup.shape.nx, c.nx) << c.file;
    EXPECT_EQ(scene.setup.shape.ny, c.ny) << c.file;
    EXPECT_EQ(scene.setup.shape.nz, c.nz) << c.file;
    EXPECT_EQ(scene.duration_s, c.duration_s) << c.file;
  }
}

}  // namespace
}  // namespace klang::liquid_scene
