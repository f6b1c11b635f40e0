// Additive plasticity of one element against tests/reference/plastic.json.
#include "core/physics/fracture/dynamic/plasticity.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/dynamic/strain_history.hpp"
#include "tests/places.hpp"

namespace klang::fracture {
namespace {

nlohmann::json reference() {
  std::ifstream file(klang::test::source_dir() + "/tests/reference/plastic.json");
  return nlohmann::json::parse(file);
}

solid::Material material_of(const nlohmann::json& values) {
  solid::Material material;
  material.lame_lambda_pa = values.at("lam");
  material.lame_mu_pa = values.at("mu");
  material.density_kg_m3 = 1000.0;
  return material;
}

double close(double value, double expected, double scale) { return std::abs(value - expected) / scale; }

// Erratum 65: as printed the sum over k of B99 (7) holds 2 mu eps_ij too, which counts it three times.
TEST(StrainHistory, ShearIsCountedOnceAndNotThreeTimes) {
  solid::Material material;
  material.lame_lambda_pa = 6e8;
  material.lame_mu_pa = 4e8;
  material.density_kg_m3 = 1000.0;
  const double shear = 0.02;
  const HistoryState state = strain_history({{1, shear, 0, 0, 1, 0, 0, 0, 1}}, material, {}).states.back();
  double printed = 0.0;
  for (int k = 0; k < 3; ++k) printed += 2.0 * material.lame_mu_pa * 0.5 * shear;
  EXPECT_LE(std::abs(state.pk2_pa[3] / (material.lame_mu_pa * shear) - 1.0), 1e-14);
  EXPECT_LE(std::abs(printed / state.pk2_pa[3] - 3.0), 1e-13);
}

TEST(Plasticity, StretchAndSquashFollowTheScalarRule) {
  const nlohmann::json values = reference().at("uniaxial_volume_preserving");
  const solid::Material material = material_of(values);
  std::vector<Gradient> path;
  for (const auto& row : values.at("rows")) {
    const double a = row.at("stretch"), b = 1.0 / std::sqrt(a);
    path.push_back({a, 0, 0, 0, b, 0, 0, 0, b});
  }
  const HistoryDocument history = strain_history(path, material, {values.at("gamma1"), values.at("gamma2")});
  ASSERT_EQ(history.states.size(), values.at("rows").size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const auto& row = values.at("rows")[i];
    const HistoryState& state = history.states[i];
    const double pa = row.at("von_mises_PK2");
    EXPECT_LE(close(state.pk2_pa[0], row.at("PK2_xx"), pa), 1e-12) << i;
    EXPECT_LE(close(state.pk2_pa[1], row.at("PK2_yy"), pa), 1e-12) << i;
    EXPECT_LE(close(state.pk2_pa[2], row.at("PK2_yy"), pa), 1e-12) << i;
    EXPECT_LE(close(state.elastic_energy_j_m3, row.at("elastic_energy_density"), row.at("elastic_energy_density")),
              1e-12);
    EXPECT_LE(close(state.dissipated_j_m3, row.at("dissipated_density"), row.at("dissipated_density")), 1e-12) << i;
    const double p = row.at("eps_p_amplitude");
    EXPECT_LE(std::abs(state.plastic_strain[0] - std::sqrt(2.0 / 3.0) * p / 2.0), 1e-14) << i;
  }
}

TEST(Plasticity, TurningShearKeepsItsHistory) {
  const nlohmann::json all = reference();
  const nlohmann::json& values = all.at("uniaxial_volume_preserving");
  std::vector<Gradient> path;
  for (const auto& row : all.at("turning_shear").at("rows")) {
    const double angle = row.at("angle_deg").get<double>() * M_PI / 180.0;
    path.push_back({1, 0.08 * std::cos(angle), 0.08 * std::sin(angle), 0, 1, 0, 0, 0, 1});
  }
  const HistoryDocument history = strain_history(path, material_of(values), {values.at("gamma1"), values.at("gamma2")});
  const std::array<std::size_t, 6> place = {0, 1, 2, 3, 4, 5};
  for (std::size_t i = 0; i < path.size(); ++i)
    for (std::size_t k = 0; k < 6; ++k) {
      const double expected = all["turning_shear"]["rows"][i]["eps_p"][place[k]];
      EXPECT_LE(std::abs(2.0 * history.states[i].plastic_strain[k] - expected), 1e-14) << i << " " << k;
    }
}

TEST(Plasticity, RandomPathsStayTracelessWithinTheLimitsAndNeverGiveEnergyBack) {
  solid::Material material;
  material.lame_lambda_pa = 3.0;
  material.lame_mu_pa = 2.0;
  material.density_kg_m3 = 1.0;
  const Plasticity plasticity{0.05, 0.3};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> step(-0.05, 0.05);
  PlasticState state;
  Sym strain{};
  for (int i = 0; i < 2000; ++i) {
    for (double& entry : strain) entry = 0.98 * entry + step(random);
    const double before = state.dissipated_j_m3;
    plastic_update(strain, material, plasticity, state);
    EXPECT_LE(std::abs(trace(state.plastic_strain)), 1e-15);
    const double size = std::sqrt(inner(state.plastic_strain, state.plastic_strain));
    EXPECT_LE(size, plasticity.gamma2 * (1.0 + 1e-14));
    EXPECT_GE(state.dissipated_j_m3, before);
    Sym deviator;
    for (std::size_t k = 0; k < 6; ++k) deviator[k] = strain[k] - state.plastic_strain[k];
    const double mean = trace(deviator) / 3.0;
    for (std::size_t k = 0; k < 3; ++k) deviator[k] -= mean;
    if (size < plasticity.gamma2 * (1.0 - 1e-9)) {
      EXPECT_LE(std::sqrt(inner(deviator, deviator)), plasticity.gamma1 * (1.0 + 1e-12));
    }
  }
}

TEST(Plasticity, ZeroLimitIsElasticAndZeroOverZeroIsNothing) {
  solid::Material material;
  material.lame_lambda_pa = 3.0;
  material.lame_mu_pa = 2.0;
  material.density_kg_m3 = 1.0;
  for (const Plasticity plasticity : {Plasticity{0.0, 0.0}, Plasticity{0.01, 0.0}}) {
    PlasticState state;
    plastic_update({0.1, 0.0, -0.05, 0.02, 0.0, 0.0}, material, plasticity, state);
    EXPECT_EQ(state.dissipated_j_m3, 0.0);
    EXPECT_EQ(inner(state.plastic_strain, state.plastic_strain), 0.0);
    EXPECT_NEAR(state.stress[0], 3.0 * 0.05 + 4.0 * 0.1, 1e-15);
  }
  PlasticState state;  // erratum 22: eps_p + d = 0
  plastic_update({}, material, {0.0, 0.2}, state);
  EXPECT_EQ(inner(state.plastic_strain, state.plastic_strain), 0.0);
}

TEST(Plasticity, YieldStressIsVonMisesInTrueStress) {
  const nlohmann::json example = reference().at("yield").at("example");
  solid::Material material;
  material.lame_lambda_pa = 6e8;
  material.lame_mu_pa = example.at("mu");
  const Plasticity plasticity = plasticity_from_yield(example.at("sigma_y_pa"), 0.243, material);
  EXPECT_NEAR(plasticity.gamma1, example.at("gamma1").get<double>(), 1e-15);
  EXPECT_NEAR(plasticity.gamma2, 0.486, 1e-15);
}

TEST(Plasticity, LimitsWithoutRestShapeAreRefused) {
  for (const auto& row : reference().at("rest_volume_of_traceless_plastic_strain").at("rows")) {
    const double g = row.at("gamma2"), sign = row.at("direction") == "stretch" ? 1.0 : -1.0;
    const double det = 1.0 - g * g / 2.0 + sign * std::sqrt(6.0) * g * g * g / 18.0;
    EXPECT_NEAR(std::sqrt(det), row.at("J_rest").get<double>(), 1e-12);  // erratum 68
  }
  EXPECT_THROW((Plasticity{0.01, 1.2248}.validate()), InputError);
  EXPECT_NO_THROW((Plasticity{0.01, 1.2247}.validate()));
  solid::Material material;
  material.lame_mu_pa = 1.0;
  EXPECT_THROW(plasticity_from_yield(0.1, 0.6124, material), InputError);
  EXPECT_THROW((read_plasticity({0.1, {}, 1.0, {}}, material, {"a", "b", "c", "d"})), InputError);
  EXPECT_THROW((read_plasticity({{}, 0.1, {}, {}}, material, {"a", "b", "c", "d"})), InputError);
  EXPECT_EQ((read_plasticity({{}, {}, 0.0, {}}, material, {"a", "b", "c", "d"})).flows(), false);
}

}  // namespace
}  // namespace klang::fracture
