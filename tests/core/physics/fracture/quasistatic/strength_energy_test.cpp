#include "core/physics/fracture/quasistatic/strength_energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/physics/fracture/quasistatic/contact_responses.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using klang::test::box_mesh;
using klang::test::reference_glass;

class StrengthEnergy : public testing::TestWithParam<int> {
 protected:
  FreeBodySolver solver_{box_mesh(0.04, 0.02, 0.02, 4, 2, 2, GetParam()), reference_glass()};
};
INSTANTIATE_TEST_SUITE_P(Elements, StrengthEnergy, testing::Values(1, 2));

TEST_P(StrengthEnergy, NoElementsStressIsAboveTheBound) {
  ContactResponses responses(solver_);
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> node(0, solver_.mesh().n_nodes() - 1);
  double nearest = 0.0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<NodeForce> forces;
    for (int k = 0; k < 1 + trial % 4; ++k)
      forces.push_back({node(random), 1e3 * Eigen::Vector3d(normal(random), normal(random), normal(random))});
    const StressField field = responses.field(forces);
    const StressExtreme largest = largest_principal_stress(solver_.mesh(), field);
    for (int e = 0; e < field.n_elements(); ++e) {
      const double stress_pa = principal_stresses_pa(field.stress_pa.col(e))[0];
      const double bound_pa = principal_stress_bound_pa(reference_glass(), field.energy_density_j_m3[e]);
      ASSERT_LE(stress_pa, (1.0 + 1e-12) * bound_pa) << trial << " " << e;
      nearest = std::max(nearest, stress_pa / bound_pa);
      // A body whose strength is this element's stress cannot have less energy than is asked for.
      const Eigen::VectorXd strength = Eigen::VectorXd::Constant(field.n_elements(), std::max(1.0, stress_pa));
      if (stress_pa > 1.0)
        ASSERT_LE(strength_energy_j(reference_glass(), field.volume_m3, strength), field.strain_energy_j) << trial;
    }
    ASSERT_TRUE(std::isfinite(largest.stress_pa));
  }
  EXPECT_GE(nearest, 0.8);  // it is no idle bound: strains along one axis reach it
}

TEST(StrengthEnergyOfAStrain, IsReachedByAStrainAlongOneAxis) {
  const klang::solid::Material glass = reference_glass();
  const double modulus_pa = glass.lame_lambda_pa + 2.0 * glass.lame_mu_pa, strain = 1e-4;
  const double density = 0.5 * modulus_pa * strain * strain;
  EXPECT_LE(std::abs(principal_stress_bound_pa(glass, density) / (modulus_pa * strain) - 1.0), 1e-14);
  const Eigen::VectorXd volumes = Eigen::Vector3d(2e-6, 1e-6, 4e-6),
                        strengths = Eigen::Vector3d(modulus_pa * strain, 2.0 * modulus_pa * strain, 1e12);
  EXPECT_LE(std::abs(strength_energy_j(glass, volumes, strengths) / (density * 2e-6) - 1.0), 2e-9);
}

}  // namespace
