#include "fit/damping/damping.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/math/statistics.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"
#include "core/physics/modal/damping/rayleigh.hpp"

namespace klang::fit {
namespace {

std::vector<double> frequencies() {
  return {588, 660, 782, 878, 983, 1167, 1575, 1770, 2100, 2350, 2969, 3330, 3900, 4681, 6630, 8750};
}

/// A law with its true parameters.
struct Truth {
  const damping::DampingLaw* law;
  std::vector<double> parameters;
  double decay_per_s(double frequency_hz) const {
    return law->decay_per_s(2.0 * kPi * frequency_hz, parameters.data());
  }
};

const Truth kRayleigh{&damping::rayleigh_law(), {1e-7, 3.0}};
const Truth kStiffnessOnly{damping::find_law("stiffness_only"), {2e-7}};

std::vector<Truth> truths() {
  return {kRayleigh,
          {damping::find_law("loss_factor"), {4e-4}},
          {damping::find_law("mass_only"), {6.0}},
          kStiffnessOnly,
          {damping::find_law("zener"), {2e-3, 6e-5}}};
}

std::vector<DecayPoint> sample(const Truth& truth, double relative_std, double scatter, std::uint64_t seed) {
  RandomStream random(seed, 7);
  std::vector<DecayPoint> points;
  for (const double f : frequencies()) {
    const double clean = truth.decay_per_s(f);
    const double decay = clean * std::exp(scatter * random.normal()) * (1.0 + relative_std * random.normal());
    points.push_back({f, decay, relative_std * decay});
  }
  return points;
}

TEST(Damping, EachModelIsRecognisedFromItsOwnDecays) {
  ASSERT_EQ(truths().size(), damping::damping_laws().size());
  for (const Truth& truth : truths()) {
    std::vector<std::string> warnings;
    const DampingResult result = fit_damping(sample(truth, 0.01, 0.0, 3), warnings);
    ASSERT_EQ(result.candidates.size(), truths().size());
    EXPECT_EQ(result.candidates.front().law, truth.law) << "found " << result.model << " for " << truth.law->name();
    double sum = 0.0;
    for (const auto& candidate : result.candidates) sum += candidate.aicc_weight.value_or(0.0);
    EXPECT_NEAR(sum, 1.0, 1e-9);
    for (const double f : frequencies()) {
      const double model = result.candidates.front().decay_per_s(2.0 * kPi * f);
      EXPECT_NEAR(model / truth.decay_per_s(f), 1.0, 0.02) << truth.law->name() << " at " << f << " Hz";
    }
  }
}

TEST(Damping, RayleighIntervalsCoverTheTruthInNinetyToNinetyNineOfHundredSeeds) {
  // With clean decays, and with the 20 % that radiation and supports add.
  for (const double scatter : {0.0, 0.2}) {
    int stiffness = 0, mass = 0;
    constexpr int kSeeds = 200;
    for (int seed = 0; seed < kSeeds; ++seed) {
      std::vector<std::string> warnings;
      const auto points = sample(kRayleigh, 0.01, scatter, 100u + static_cast<unsigned>(seed));
      const DampingResult result = fit_damping(points, warnings);
      const DampingCandidate* rayleigh = find_candidate(result, damping::rayleigh_law());
      ASSERT_NE(rayleigh, nullptr);
      const auto& a = rayleigh->parameters[0];
      const auto& b = rayleigh->parameters[1];
      ASSERT_TRUE(a.ci95 && b.ci95);
      stiffness += (*a.ci95)[0] <= 1e-7 && 1e-7 <= (*a.ci95)[1];
      mass += (*b.ci95)[0] <= 3.0 && 3.0 <= (*b.ci95)[1];
    }
    EXPECT_GE(stiffness, 0.90 * kSeeds) << "scatter " << scatter;
    EXPECT_LE(stiffness, 0.99 * kSeeds) << "scatter " << scatter;
    EXPECT_GE(mass, 0.90 * kSeeds) << "scatter " << scatter;
    EXPECT_LE(mass, 0.99 * kSeeds) << "scatter " << scatter;
  }
}

TEST(Damping, ParameterThatTheDecaysDoNotNeedIsReportedSo) {
  std::vector<std::string> warnings;
  const DampingResult result = fit_damping(sample(kStiffnessOnly, 0.02, 0.0, 5), warnings);
  const DampingCandidate* rayleigh = find_candidate(result, damping::rayleigh_law());
  ASSERT_NE(rayleigh, nullptr);
  EXPECT_TRUE(rayleigh->parameters[0].identifiable);
  EXPECT_FALSE(rayleigh->parameters[1].identifiable);
  EXPECT_FALSE(rayleigh->parameters[1].why.empty());
}

TEST(Damping, OneDecayGivesNoConfidentPair) {
  std::vector<std::string> warnings;
  const DampingResult result = fit_damping({{588.0, 1.0, 0.01}}, warnings);
  const DampingCandidate* rayleigh = find_candidate(result, damping::rayleigh_law());
  ASSERT_NE(rayleigh, nullptr);
  for (const auto& parameter : rayleigh->parameters) {
    EXPECT_FALSE(parameter.identifiable);
    EXPECT_FALSE(parameter.std.has_value());
  }
  EXPECT_FALSE(result.candidates.front().aicc.has_value());
  EXPECT_FALSE(warnings.empty());
}

TEST(Damping, NothingMeasuredGivesNoModel) {
  std::vector<std::string> warnings;
  EXPECT_TRUE(fit_damping({}, warnings).candidates.empty());
  EXPECT_TRUE(fit_damping({{100.0, -1.0, 0.0}, {100.0, std::nan(""), 0.0}}, warnings).model.empty());
}

TEST(Damping, KnownRadiationIsTakenOffAndTheSplitIsPreferred) {
  // Stiffness damping with what a small plate radiates: rises until the waves in it are as fast as sound, then falls.
  RandomStream random(8, 0);
  std::vector<DecayPoint> points;
  for (const double f : {400.0, 900.0, 1700.0, 2600.0, 3900.0, 5600.0, 7500.0, 9800.0, 12000.0}) {
    const double omega = 2.0 * kPi * f, radiation = 20.0 * std::pow(f / 5000.0, 4) / (1.0 + std::pow(f / 5000.0, 5));
    const double decay = 0.5 * 3e-9 * omega * omega + radiation;
    points.push_back({f, decay * (1.0 + 0.02 * random.normal()), 0.02 * decay, radiation});
  }
  std::vector<std::string> warnings;
  const DampingResult result = fit_damping(points, warnings);
  EXPECT_EQ(result.model, "stiffness_only_and_radiation");
  const DampingCandidate& best = result.candidates.front();
  ASSERT_TRUE(best.with_radiation);
  ASSERT_TRUE(best.parameters[0].ci95.has_value());
  EXPECT_LE((*best.parameters[0].ci95)[0], 3e-9);
  EXPECT_GE((*best.parameters[0].ci95)[1], 3e-9);
  EXPECT_LE(std::abs(best.parameters[0].value / 3e-9 - 1.0), 0.1);
  EXPECT_LE(std::abs(best.decay_per_s(1e4, 5.0) / (best.decay_per_s(1e4) + 5.0) - 1.0), 1e-12);
  // Without it the same points keep their five models.
  for (DecayPoint& point : points) point.radiation_per_s = 0.0;
  EXPECT_EQ(fit_damping(points, warnings).candidates.size(), 5u);
}

TEST(Damping, MountsAreToldFromTheMaterialAndOnlyWhereTheyAct) {
  // Constant loss factor; a damper of 0.4 N s/m that sits near some modes' antinodes and others' nodes.
  const std::vector<double> per_kg = {9.4, 0.7, 0.06, 1.0, 0.07, 4.4, 10.3, 0.0003, 1.1, 15.9};
  for (const double damper : {0.4, 0.0}) {
    RandomStream random(9, 0);
    std::vector<DecayPoint> points;
    double f = 2600.0;
    for (const double g : per_kg) {
      const double decay = 0.5 * 1.2e-3 * 2.0 * kPi * f + damper * g;
      points.push_back({f, decay * (1.0 + 0.01 * random.normal()), 0.01 * decay, 0.0, g});
      f *= 1.25;
    }
    std::vector<std::string> warnings;
    const DampingResult result = fit_damping(points, warnings);
    EXPECT_EQ(result.candidates.size(), 10u);
    EXPECT_EQ(result.model, damper > 0.0 ? "loss_factor_and_mount" : "loss_factor");
    if (damper == 0.0) continue;
    const auto& parameters = result.candidates.front().parameters;
    ASSERT_EQ(parameters.size(), 2u);
    EXPECT_EQ(parameters[1].name, "mount_damping_n_s_per_m");
    ASSERT_TRUE(parameters[1].ci95.has_value());
    EXPECT_LE((*parameters[1].ci95)[0], damper);
    EXPECT_GE((*parameters[1].ci95)[1], damper);
    EXPECT_LE(std::abs(parameters[0].value / 1.2e-3 - 1.0), 0.02);
  }
}

TEST(Damping, DerivativesBesideRadiationAndMountsMatchDifferences) {
  const std::array<double, 3> p = {2e-7, 5.0, 0.3};
  for (const double radiation : {0.0, 12.0}) {
    for (const double mount : {1e-4, 8.0}) {
      std::array<double, 3> gradient{}, unused{};
      log_total_decay(damping::rayleigh_law(), p.data(), 2e4, {radiation, mount}, gradient.data());
      for (std::size_t j = 0; j < 3; ++j) {
        auto high = p, low = p;
        const double h = 1e-4 * p[j];
        high[j] += h;
        low[j] -= h;
        const double slope =
            (log_total_decay(damping::rayleigh_law(), high.data(), 2e4, {radiation, mount}, unused.data()) -
             log_total_decay(damping::rayleigh_law(), low.data(), 2e4, {radiation, mount}, unused.data())) /
            (2.0 * h);
        EXPECT_LE(std::abs(gradient[j] / slope - 1.0), 1e-4) << "parameter " << j;
      }
    }
  }
}

TEST(Statistics, StudentQuantilesMatchTables) {
  // Abramowitz and Stegun 1964, table 26.10.
  EXPECT_NEAR(student_t_975(1.5), 6.016663104431, 1e-9);
  EXPECT_NEAR(student_t_975(1), 12.706, 1e-3);
  EXPECT_NEAR(student_t_975(2), 4.303, 1e-3);
  EXPECT_NEAR(student_t_975(3), 3.182446305284263, 1e-9);
  EXPECT_NEAR(student_t_975(5), 2.571, 1e-3);
  EXPECT_NEAR(student_t_975(10), 2.228, 1e-3);
  EXPECT_NEAR(student_t_975(1e9), 1.960, 1e-3);
}

TEST(Statistics, ScatterMakesTheReducedChiSquaredOne) {
  Eigen::VectorXd residual(6), sigma = Eigen::VectorXd::Constant(6, 0.5), weight = Eigen::VectorXd::Ones(6);
  residual << 1, -2, 3, -1, 2, -3;
  const double s = scatter_estimate(residual, sigma, weight, 1, 0.0, 0.0);
  EXPECT_NEAR((residual.array().square() / (0.25 + s * s)).sum(), 5.0, 1e-6);
  EXPECT_EQ(scatter_estimate(0.1 * residual, sigma, weight, 1, 0.0, 0.0), 0.0);
  EXPECT_EQ(scatter_estimate(residual.head(1), sigma.head(1), weight.head(1), 1, 0.7, 0.0), 0.7);
}

}  // namespace
}  // namespace klang::fit
