// The whole chain on finite elements, against truth that no finite element made (Ritz series, a published table).
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "datasets-synthetic/recipe.hpp"
#include "datasets-synthetic/ritz_box.hpp"
#include "fit/run/fit.hpp"
#include "fit/run/fit_document.hpp"
#include "fit/tune/tune.hpp"
#include "tests/places.hpp"

namespace klang::fit {
namespace {

// tests/reference/chimes.json: material; tubes[].ritz3d_bending
const solid::Material kAluminium{4.98e10, 2.57e10, 2700.0, "", ""};
struct Chime {
  const char* name;
  double length_m;
  std::vector<double> bending_hz;
};
const std::vector<Chime> kChimes = {
    {"D3",
     0.505,
     {587.8831103242787, 1575.1159866675644, 2969.5312988027986, 4681.101830346376, 6630.651833302586,
      8750.000412714602}},
    {"D4", 0.353, {1185.4672628861772, 3095.019228731142, 5657.745289217874, 8635.76762217711}}};
constexpr double kStiffness = 1e-7, kMass = 1.5;  // Rayleigh

mesh::ShapeSpec tube(double length_m) {
  return {"tube", {{"length_m", length_m}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
}

std::filesystem::path table_file(const std::string& name, const std::vector<double>& frequency_hz, bool decays,
                                 std::uint64_t seed) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("klang-" + name + ".csv");
  std::ofstream file(path);
  file.precision(12);
  file << "frequency_hz,frequency_std_hz" << (decays ? ",decay_per_s,decay_std_per_s\n" : "\n");
  RandomStream random(seed, 1);
  for (const double f : frequency_hz) {
    const double omega = 2.0 * kPi * f, decay = 0.5 * (kStiffness * omega * omega + kMass);
    // What rings is the damped frequency.
    const double rings = decays ? std::sqrt(omega * omega - decay * decay) / (2.0 * kPi) : f;
    file << rings + 0.005 * random.normal() << ",0.005";
    if (decays) file << ',' << decay * (1.0 + 0.005 * random.normal()) << ',' << 0.005 * decay;
    file << '\n';
  }
  return path;
}

const FitParameter& named(const FitResult& result, const std::string& name) {
  for (const auto& parameter : result.parameters) {
    if (parameter.name == name) return parameter;
  }
  throw std::runtime_error("no " + name);
}

bool covers(const FitParameter& p, double truth) { return p.ci95 && (*p.ci95)[0] <= truth && truth <= (*p.ci95)[1]; }

TEST(RunFit, ChimesGiveEWithinTwoTenthsOfAPercentAndRayleighWithinThree) {
  FitProblem problem;
  problem.name = "chimes";
  problem.material = solid::from_youngs_modulus(0.8 * kAluminium.youngs_modulus_pa(), 0.30, 2700.0);
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa", "rayleigh_stiffness_s", "rayleigh_mass_per_s"};
  for (const Chime& chime : kChimes) {
    Specimen specimen;
    specimen.name = chime.name;
    specimen.shape = tube(chime.length_m);
    specimen.partials = table_file(chime.name, chime.bending_hz, true, 3);
    problem.specimens.push_back(specimen);
  }
  const FitResult result = run_fit(problem, {});
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_EQ(result.matches.size(), 10u);
  const auto& young = named(result, "youngs_modulus_pa");
  EXPECT_LE(std::abs(young.value / kAluminium.youngs_modulus_pa() - 1.0), 0.002) << young.value;
  EXPECT_TRUE(young.identifiable);
  EXPECT_TRUE(covers(young, kAluminium.youngs_modulus_pa()));
  EXPECT_LE(std::abs(named(result, "rayleigh_stiffness_s").value / kStiffness - 1.0), 0.03);
  EXPECT_LE(std::abs(named(result, "rayleigh_mass_per_s").value / kMass - 1.0), 0.03);
  EXPECT_EQ(result.damping.model, "rayleigh");
  for (const auto& parameter : result.parameters) {  // what is stated as known is right
    if (!parameter.identifiable) continue;
    if (parameter.name == "poissons_ratio")
      EXPECT_TRUE(covers(parameter, kAluminium.poissons_ratio())) << parameter.value;
    if (parameter.name == "lame_lambda_pa") EXPECT_TRUE(covers(parameter, 4.98e10)) << parameter.value;
    if (parameter.name == "lame_mu_pa") EXPECT_TRUE(covers(parameter, 2.57e10)) << parameter.value;
  }
  for (const auto& specimen : result.specimens) EXPECT_TRUE(specimen.none_missing) << specimen.name;

  const nlohmann::json json = json_of(fit_document(problem, result, {"1", "test", 1, {"{}"}, {}}));
  EXPECT_EQ(json["status"], "converged");
  EXPECT_EQ(json["matches"].size(), 10u);
  EXPECT_EQ(json["matches"][0]["specimen"], "D3");
  EXPECT_GE(json["predicted"].size(), 60u) << "all of the band, ring modes too";
  for (const auto& key : {"name", "value", "std", "ci95", "identifiable"})
    EXPECT_TRUE(json["parameters"][0].contains(key));
  EXPECT_EQ(json["specimens"][1]["files"]["recording"], nullptr);
  EXPECT_EQ(json["specimens"][1]["files"]["modes"], "modes-D4.vtu");
}

TEST(RunFit, BarGivesEWithinTwoAndGWithinThreeTenthsOfAPercent) {
  // Flexure, in-plane flexure, torsion and extension of a free bar by a Ritz series.
  const solid::Material truth = solid::from_youngs_modulus(210e9, 0.285, 7850.0);
  FitProblem problem;
  problem.material = solid::from_youngs_modulus(160e9, 0.33, 7850.0);
  problem.parameters = {"youngs_modulus_pa", "shear_modulus_pa"};
  Specimen specimen;
  specimen.name = "bar";
  specimen.shape = mesh::ShapeSpec{"box", {{"length_m", 0.16}, {"width_m", 0.03}, {"height_m", 0.008}}, {}};
  const datasets::RitzBox ritz({0.16, 0.03, 0.008}, truth);
  std::vector<double> modes;
  for (Eigen::Index k = 0; k < 9; ++k) modes.push_back(ritz.angular_frequency_rad_s()[k] / (2.0 * kPi));
  specimen.partials = table_file("bar", modes, false, 4);
  problem.specimens = {specimen};
  const FitResult result = run_fit(problem, {});
  EXPECT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_EQ(result.matches.size(), modes.size());
  EXPECT_LE(std::abs(named(result, "youngs_modulus_pa").value / truth.youngs_modulus_pa() - 1.0), 0.002);
  EXPECT_LE(std::abs(named(result, "shear_modulus_pa").value / truth.lame_mu_pa - 1.0), 0.003);
  EXPECT_TRUE(named(result, "shear_modulus_pa").identifiable);
}

TEST(RunFit, WholeTileGivesEAndGAndForetellsItsHalfWithinThreeTenthsOfAPercent) {
  const auto made =
      datasets::make_dataset(klang::test::source_dir() + "/datasets-synthetic/recipes/broken_tile.toml", 7);
  const auto folder = std::filesystem::path(testing::TempDir()) / ("klang-tile" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  for (const auto& recording : made.recordings)
    audio::write_sound(folder / (recording.name + ".wav"), recording.signal);
  const FitProblem problem = parse_fit_problem(made.specimen_toml, "tile", folder);
  const FitResult result = run_fit(problem, {}), again = run_fit(problem, {});
  std::filesystem::remove_all(folder);
  const auto text_of = [&](FitResult r) {
    r.wall_time_s.clear();
    return json_of(fit_document(problem, r, {"1", "test", 1, {"{}"}, {}})).dump();
  };
  EXPECT_EQ(text_of(result), text_of(again)) << "two bodies of tetrahedra side by side, twice";
  ASSERT_EQ(result.status, FitStatus::kConverged) << result.message;
  EXPECT_LE(std::abs(named(result, "youngs_modulus_pa").value / 70.5e9 - 1.0), 0.002);
  EXPECT_LE(std::abs(named(result, "shear_modulus_pa").value / 29.375e9 - 1.0), 0.003);
  EXPECT_TRUE(result.specimens[1].predicted);
  int n_predicted = 0;
  for (const PartialMatch& match : result.matches) {
    EXPECT_EQ(match.model_frequency_std_hz.has_value(), match.specimen == 1);
    if (match.specimen != 1) continue;
    ++n_predicted;
    const double off_hz = std::abs(match.frequency_hz - match.model_frequency_hz);
    EXPECT_LE(off_hz, 0.003 * match.frequency_hz);
    EXPECT_LE(off_hz, 3.0 * *match.model_frequency_std_hz);
  }
  EXPECT_GE(n_predicted, 6);
  EXPECT_TRUE(result.specimens[1].unmatched_partials.empty());
  // Loss factor and the foam's dampers, apart: broken_tile.toml.
  ASSERT_EQ(result.damping.model, "loss_factor_and_mount");
  const auto& damping = result.damping.candidates.front().parameters;
  EXPECT_LE(std::abs(damping[0].value / 1.2e-3 - 1.0), 0.01);
  EXPECT_TRUE(covers(damping[1], 0.5)) << damping[1].value;
}

TEST(RunFit, PublishedChimesAreMetWithinOnePercent) {
  // S02 Table 2: measured lengths [m] and frequencies [Hz] of six real chimes.
  const std::vector<std::tuple<const char*, double, double>> table = {{"D5", 0.505, 585.8}, {"E5", 0.475, 656.0},
                                                                      {"G5", 0.435, 781.8}, {"A5", 0.410, 877.5},
                                                                      {"B5", 0.388, 982.5}, {"D6", 0.353, 1167.0}};
  FitProblem problem;
  problem.material = kAluminium;
  problem.parameters = {"lame_lambda_pa", "lame_mu_pa"};
  for (const auto& [name, length_m, frequency_hz] : table) {
    Specimen specimen;
    specimen.name = name;
    specimen.shape = tube(length_m);
    specimen.partials = table_file(name, {frequency_hz}, false, 5);
    problem.specimens.push_back(specimen);
  }
  const FitResult result = run_fit(problem, {});
  EXPECT_EQ(result.status, FitStatus::kConverged);
  ASSERT_EQ(result.matches.size(), 6u);
  for (const auto& match : result.matches) {
    EXPECT_LE(match.mode, 1);
    EXPECT_LE(std::abs(match.frequency_hz / match.model_frequency_hz - 1.0), 0.01) << match.frequency_hz;
    RecordProperty(result.specimens[static_cast<std::size_t>(match.specimen)].name,
                   std::to_string(match.deviation_cents) + " cents");
  }
  EXPECT_TRUE(named(result, "youngs_modulus_pa").identifiable);
  EXPECT_FALSE(named(result, "lame_lambda_pa").identifiable) << "six fundamentals do not determine lambda";
  EXPECT_NE(named(result, "lame_lambda_pa").why.find("E = mu"), std::string::npos);
}

TEST(Tune, ChimeLengthBringsItsFirstBendingModeToTheNote) {
  Specimen specimen;
  specimen.name = "D5";
  specimen.shape = tube(0.505);
  TuneOptions options;
  options.dimensions = {"length_m"};
  options.targets = {{"bending 1", 587.33}};
  const TuneResult result = tune_dimensions(specimen, kAluminium, options);
  ASSERT_TRUE(result.usable()) << result.message;
  EXPECT_LE(std::abs(result.targets[0].residual_cents), 0.05);
  // f ~ L^-2 nearly: from 587.8831 Hz (Ritz) to 587.33 Hz is 0.505 m times 1.000236 within the mesh's 0.03 %.
  EXPECT_NEAR(result.dimensions[0].value_m, 0.505 * std::pow(587.8831 / 587.33, 1.0 / 1.985), 1.0e-4);
  EXPECT_NEAR(result.targets[0].hz_per_mm[0], -1.985 * 587.33 / 505.0, 0.02);
  EXPECT_NEAR(result.targets[0].cents_per_tenth_mm[0], -1.985 * 1e-4 / 0.505 * 1200 / std::log(2.0), 0.01);
}

TEST(Tune, BadRequestsAreRefused) {
  Specimen specimen;
  specimen.shape = tube(0.505);
  const auto refused = [&](TuneOptions options) {
    EXPECT_THROW(tune_dimensions(specimen, kAluminium, options), InputError);
  };
  refused({});
  refused({{"length_m"}, {}, 0.2, 0.05, 8});
  refused({{"radius_m"}, {{"0", 500.0}}, 0.2, 0.05, 8});
  refused({{"length_m"}, {{"0", -1.0}}, 0.2, 0.05, 8});
  refused({{"length_m"}, {{"0", std::nan("")}}, 0.2, 0.05, 8});
  refused({{"length_m"}, {{"0", 500.0}}, 0.9, 0.05, 8});
}

}  // namespace
}  // namespace klang::fit
