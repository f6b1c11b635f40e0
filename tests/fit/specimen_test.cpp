#include "fit/specimen/specimen.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "tests/places.hpp"

namespace klang::fit {
namespace {

constexpr const char* kGood = R"(name = "two chimes"
[material]
youngs_modulus_pa = 70e9
poissons_ratio = 0.33
density_kg_m3 = 2700
[[specimen]]
name = "D3"
shape = { kind = "tube", length_m = 0.505, outer_radius_m = 0.0125, wall_m = 0.001 }
support = { kind = "clamped", where = "z=0" }
[[specimen]]
shape = { kind = "box", length_m = 0.1, width_m = 0.02, height_m = 3e-3 }
strike_m = [0, 0, 1]
[fit]
parameters = ["youngs_modulus_pa", "poissons_ratio", "D3.length_m"]
band_hz = [50, 9000]
[fit.priors]
D3.length_m = { mean = 0.505, std = 0.0005 }
youngs_modulus_pa = { mean = 70e9, std = 1e9 }
)";

FitProblem parse(const std::string& text) { return parse_fit_problem(text, "test.toml", "/"); }

std::string complaint(const std::string& text) {
  try {
    parse(text);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

TEST(SpecimenFile, EveryFieldArrives) {
  const FitProblem problem = parse(kGood);
  EXPECT_EQ(problem.name, "two chimes");
  EXPECT_NEAR(problem.material.youngs_modulus_pa(), 70e9, 1.0);
  EXPECT_NEAR(problem.material.poissons_ratio(), 0.33, 1e-12);
  EXPECT_TRUE(problem.density_given);
  ASSERT_EQ(problem.specimens.size(), 2u);
  EXPECT_EQ(problem.specimens[0].name, "D3");
  EXPECT_EQ(problem.specimens[0].shape->dims.at("wall_m"), 0.001);
  EXPECT_EQ(problem.specimens[0].support.kind, solid::SupportKind::kClamped);
  EXPECT_EQ(problem.specimens[1].name, "specimen-2");
  EXPECT_EQ((*problem.specimens[1].strike_m)[2], 1.0);
  EXPECT_EQ(problem.parameters.size(), 3u);
  EXPECT_EQ(problem.band.low_hz, 50.0);
  EXPECT_EQ(problem.priors.at("D3.length_m").std, 0.0005);
  EXPECT_EQ(problem.priors.at("youngs_modulus_pa").mean, 70e9);
  EXPECT_EQ(problem.source_text, kGood);
}

TEST(SpecimenFile, ComplaintsNameFileLineKeyValueAndWhatIsAllowed) {
  const std::string negative = complaint(replaced(kGood, "wall_m = 0.001", "wall_m = -0.001"));
  EXPECT_EQ(negative.rfind("test.toml:8: specimen[1].shape.wall_m", 0), 0u) << negative;
  EXPECT_NE(negative.find("-0.001; allowed: above 0"), std::string::npos) << negative;
  const std::string half = complaint(replaced(kGood, "poissons_ratio = 0.33", "poissons_ratio = 0.5"));
  EXPECT_EQ(half.rfind("test.toml:4: material.poissons_ratio", 0), 0u) << half;
  EXPECT_NE(half.find("below 0.5"), std::string::npos) << half;
  const std::string unknown = complaint(replaced(kGood, "wall_m", "wal_m"));
  EXPECT_NE(unknown.find("specimen[1].shape.wal_m: unknown key"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("wall_m"), std::string::npos) << unknown;
}

TEST(SpecimenFile, BadInputIsRefused) {
  const std::string good = kGood;
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "material"},
      {"a = ", "test.toml:1"},
      {replaced(good, "name = \"two chimes\"", "nme = \"x\""), "unknown key"},
      {replaced(good, "wall_m = 0.001", "wall_m = 0.5"), "wall"},
      {replaced(good, "wall_m = 0.001", "wall_m = nan"), "out of range"},
      {replaced(good, "wall_m = 0.001", "wall_m = \"thin\""), "must be a number"},
      {replaced(good, "wall_m = 0.001", "radius_m = 0.001"), "no dimension of a tube"},
      {replaced(good, ", wall_m = 0.001", ""), "wall_m: is missing"},
      {replaced(good, "kind = \"tube\"", "kind = \"tub\""), "tub"},
      {replaced(good, "name = \"D3\"", "name = \"D/3\""), "file name"},
      {replaced(good, "name = \"D3\"", "name = \"specimen-2\""), "used twice"},
      {replaced(good, "name = \"D3\"", "mesh = \"x.msh\""), "both given"},
      {replaced(good, "name = \"D3\"", "mass_kg = 0.1"), "mass and density_kg_m3 are both given"},
      {replaced(good, "density_kg_m3 = 2700", ""), "neither a mass_kg nor a density"},
      {replaced(good, "name = \"D3\"", "recording = \"nowhere.wav\""), "no such file"},
      {replaced(good, "name = \"D3\"", "recordings = []"), "empty list"},
      {replaced(good, "where = \"z=0\"", "where = \"q=0\""), "support"},
      {replaced(good, "name = \"D3\"", "predict = 1"), "must be true or false"},
      {replaced(good, "name = \"D3\"", "mount = [{ direction = [0, 0, 1] }]"), "at_m: is missing"},
      {replaced(good, "name = \"D3\"", "mount = [{ at_m = [0, 0, 0], direction = [0, 0, 0] }]"), "is zero"},
      {replaced(good, "name = \"D3\"", "mount = [3]"), "must be a table"},
      {"[material]\npreset = \"aluminium\"\n[[specimen]]\npredict = true\n"
       "shape = { kind = \"sphere\", radius_m = 0.02 }\n",
       "all have predict"},
      {replaced(good, "kind = \"clamped\"", "kind = \"glued\""), "glued"},
      {replaced(good, "youngs_modulus_pa = 70e9", "preset = \"aluminium\""), "elasticity twice"},
      {replaced(good, "youngs_modulus_pa = 70e9", ""), "stands alone"},
      {replaced(good, "\"poissons_ratio\", ", "\"poisson\", "), "unknown parameter"},
      {replaced(good, "D3.length_m\"]", "D3.radius_m\"]"), "unknown dimension"},
      {replaced(good, "D3.length_m\"]", "D4.length_m\"]"), "unknown specimen"},
      {replaced(good, "\"D3.length_m\"]", "\"lame_mu_pa\"]"), "two elastic constants"},
      {replaced(good, "\"D3.length_m\"]", "\"poissons_ratio\"]"), "named twice"},
      {replaced(good, "\"D3.length_m\"]", "\"D3.wall_m\"]"), "not fitted"},
      {replaced(good, "std = 0.0005", "std = 0"), "out of range"},
      {replaced(good, "[50, 9000]", "[9000, 50]"), "must rise"},
      {replaced(good, "[50, 9000]", "[50]"), "wrong number of entries"},
      {replaced(good, "[0, 0, 1]", "[0, 0, inf]"), "out of range"},
      {"specimen = 3\n[material]\npreset = \"aluminium\"\n", "list of 1 to 1000"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string message = complaint(text);
    EXPECT_NE(message.find(expected), std::string::npos) << message << "\nwanted: " << expected;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
}

TEST(SpecimenFile, DefaultsToLameAndRayleigh) {
  const FitProblem problem = parse(
      "[material]\npreset = \"aluminium\"\n[[specimen]]\nmass_kg = 0.1028\n"
      "shape = { kind = \"rod\", length_m = 0.2, radius_m = 0.005 }\n");
  const std::vector<std::string> expected = {"lame_lambda_pa", "lame_mu_pa", "rayleigh_stiffness_s",
                                             "rayleigh_mass_per_s"};
  EXPECT_EQ(problem.parameters, expected);
  EXPECT_EQ(problem.name, "test");
  EXPECT_EQ(problem.specimens[0].mass_kg, 0.1028);
}

TEST(SpecimenFile, CommittedDocumentIsTheGeneratedOne) {
  EXPECT_EQ(read_file(klang::test::source_dir() + "/docs/specimen.md"), specimen_schema_markdown())
      << "write specimen_schema_markdown() to docs/specimen.md";
}

}  // namespace
}  // namespace klang::fit
