#include "core/physics/modal/damping/damping_laws.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/physics/modal/damping/rayleigh.hpp"

namespace klang::damping {
namespace {

/// Of the size that they have in the middle of the audible range.
std::vector<double> usual_parameters(const DampingLaw& law) {
  std::vector<double> values;
  for (const LawParameter& parameter : law.parameters()) {
    const std::string_view name = parameter.name;
    values.push_back(name.ends_with("_per_s")    ? 5.0
                     : name.ends_with("_time_s") ? 6e-5
                     : name.ends_with("_s")      ? 2e-7
                                                 : 2e-3);
  }
  return values;
}

TEST(DampingLaws, DerivativesOfLogDecayMatchDifferences) {
  for (const DampingLaw* law : damping_laws()) {
    const std::vector<double> p = usual_parameters(*law);
    for (const double omega : {3e3, 2e4, 6e4}) {
      std::vector<double> gradient(p.size());
      law->log_gradient(omega, p.data(), gradient.data());
      for (std::size_t j = 0; j < p.size(); ++j) {
        ASSERT_NE(gradient[j], 0.0);
        auto high = p, low = p;
        const double h = 1e-5 * p[j];
        high[j] += h;
        low[j] -= h;
        const double slope =
            std::log(law->decay_per_s(omega, high.data()) / law->decay_per_s(omega, low.data())) / (2.0 * h);
        EXPECT_LE(std::abs(gradient[j] / slope - 1.0), 1e-6) << law->name() << " parameter " << j;
      }
    }
  }
}

TEST(DampingLaws, DecayOfManyFrequenciesIsThatOfEach) {
  const Eigen::VectorXd omega = Eigen::VectorXd::LinSpaced(7, 100.0, 1e5);
  for (const DampingLaw* law : damping_laws()) {
    const std::vector<double> p = usual_parameters(*law);
    const Eigen::VectorXd all = law->decay_per_s(omega, p.data());
    for (Eigen::Index i = 0; i < omega.size(); ++i)
      EXPECT_LE(std::abs(all[i] / law->decay_per_s(omega[i], p.data()) - 1.0), 1e-15) << law->name();
  }
}

TEST(DampingLaws, StartsReproduceTheMeanOfTheLawsOwnDecays) {
  const Eigen::ArrayXd omega = Eigen::ArrayXd::LinSpaced(9, 4e3, 6e4);
  for (const DampingLaw* law : damping_laws()) {
    const std::vector<double> p = usual_parameters(*law);
    const Eigen::ArrayXd decay = law->decay_per_s(omega.matrix(), p.data()).array();
    for (const Eigen::VectorXd& start : law->starts(omega, decay)) {
      ASSERT_EQ(start.size(), static_cast<Eigen::Index>(p.size()));
      EXPECT_GT(start.minCoeff(), 0.0) << law->name();
      const double mean = geometric_mean(law->decay_per_s(omega.matrix(), start.data()).array());
      EXPECT_LE(std::abs(std::log(mean / geometric_mean(decay))), 1.0) << law->name();
    }
  }
}

TEST(DampingLaws, NamesTellLawsAndParametersApart) {
  std::set<std::string_view> names;
  for (const DampingLaw* law : damping_laws()) {
    EXPECT_TRUE(names.insert(law->name()).second) << law->name();
    EXPECT_EQ(find_law(law->name()), law);
    EXPECT_LE(law->parameters().size(), kMostLawParameters);
    std::vector<std::string> parameters;
    for (const LawParameter& parameter : law->parameters()) {
      EXPECT_LT(parameter.low, parameter.high);
      EXPECT_TRUE(is_law_parameter(parameter.name));
      parameters.insert(parameters.begin(), std::string(parameter.name));
    }
    EXPECT_EQ(law_of_parameters(parameters), law) << "in any order";
  }
  EXPECT_EQ(find_law("friction"), nullptr);
  EXPECT_EQ(law_of_parameters({"loss_factor", "zener_strength"}), nullptr);
  EXPECT_FALSE(is_law_parameter("youngs_modulus_pa"));
  EXPECT_EQ(law_names(LawUse::kRecipes), "rayleigh, loss_factor, zener");
  EXPECT_EQ(find_law("mass_only", LawUse::kRecipes), nullptr);
}

TEST(Rayleigh, StiffnessStandsBeforeMassEverywhere) {
  const RayleighDamping damping{.stiffness_s = 2e-6, .mass_per_s = 3.0};
  const double in_order[] = {2e-6, 3.0};
  EXPECT_EQ(rayleigh_law().parameters()[0].name, "rayleigh_stiffness_s");
  EXPECT_EQ(rayleigh_law().parameters()[1].name, "rayleigh_mass_per_s");
  for (const double omega : {0.0, 1000.0, 2000.0})
    EXPECT_EQ(rayleigh_law().decay_per_s(omega, in_order), damping.decay_per_s(omega));
}

TEST(Rayleigh, DecayIsHalfOfStiffnessTimesOmegaSquaredPlusMass) {
  const RayleighDamping damping{.stiffness_s = 2e-6, .mass_per_s = 3.0};
  EXPECT_DOUBLE_EQ(damping.decay_per_s(1000.0), 2.5);
  const Eigen::VectorXd decay = damping.decay_per_s(Eigen::VectorXd(Eigen::Vector2d(1000.0, 2000.0)));
  EXPECT_DOUBLE_EQ(decay[0], 2.5);
  EXPECT_DOUBLE_EQ(decay[1], 5.5);
}

}  // namespace
}  // namespace klang::damping
