// Against tests/reference/quasistatic.json, which is made by dense linear algebra without this program.
#include <gtest/gtest.h>

#include <Eigen/QR>

#include "core/physics/fracture/quasistatic/free_body_solver.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"

namespace {

using namespace klang::fracture;
using nlohmann::json;

struct ReliefCase {
  Relief relief;
  const char* key;
};

class QuasistaticReference : public testing::TestWithParam<ReliefCase> {};
INSTANTIATE_TEST_SUITE_P(Reliefs, QuasistaticReference,
                         testing::Values(ReliefCase{Relief::kConsistentMass, "inertia_relief_consistent"},
                                         ReliefCase{Relief::kLumpedMass, "inertia_relief_lumped"},
                                         ReliefCase{Relief::kEuclidean, "euclidean_projection_as_printed"}),
                         [](const auto& one) { return std::string(one.param.key); });

TEST_P(QuasistaticReference, EnergyDisplacementAndLargestStressAreThoseOfThePseudoInverse) {
  const json reference = klang::test::quasistatic_reference();
  FreeBodySolver solver(klang::test::reference_mesh(reference), klang::test::reference_glass(), GetParam().relief);
  ASSERT_TRUE(solver.usable()) << solver.message();
  const Eigen::MatrixXd rigid = klang::test::rigid_motions(solver.mesh());
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(rigid);
  ASSERT_EQ(reference["mesh"]["cases"].size(), 2u);
  for (const json& load : reference["mesh"]["cases"]) {
    const json& right = load[GetParam().key];
    const QuasistaticSolution solution = solver.solve(klang::test::nodal_force(solver.mesh(), load["force_n"]));
    const double energy = right["energy_j"];
    EXPECT_LE(std::abs(solution.strain_energy_j[0] - energy), 1e-10 * energy) << load["name"];
    EXPECT_LE(solution.relative_residual[0], 1e-12);

    // Both have some rigid part of their own choice.
    Eigen::VectorXd difference = solution.displacement_m.col(0);
    double scale = 0.0;
    for (Eigen::Index i = 0; i < difference.size(); ++i) {
      const double value = right["displacement_m"][static_cast<std::size_t>(i)];
      scale = std::max(scale, std::abs(value));
      difference[i] -= value;
    }
    difference -= rigid * qr.solve(difference);
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), 1e-10 * scale) << load["name"];

    const StressField field = solver.stresses().field(solution.displacement_m.col(0));
    const StressExtreme largest = largest_principal_stress(solver.mesh(), field);
    const double stress = right["largest_principal_stress_pa"];
    EXPECT_LE(std::abs(largest.stress_pa - stress), 1e-10 * stress) << load["name"];
    EXPECT_EQ(largest.element, right["its_element"].get<int>());
    EXPECT_LE(std::abs(field.strain_energy_j - energy), 1e-10 * energy);
    if (!right.contains("element_stress_pa_xx_yy_zz_xy_yz_zx")) continue;
    const json& stresses = right["element_stress_pa_xx_yy_zz_xy_yz_zx"];
    ASSERT_EQ(static_cast<int>(stresses.size()), field.n_elements());
    for (int e = 0; e < field.n_elements(); ++e)
      for (int k = 0; k < 6; ++k)
        EXPECT_LE(std::abs(field.stress_pa(k, e) -
                           stresses[static_cast<std::size_t>(e)][static_cast<std::size_t>(k)].get<double>()),
                  1e-10 * stress)
            << "element " << e << ", component " << k;
  }
}

TEST(Quasistatic, PrintedProjectionGivesTheWrongEnergyWhereNodalMassesDiffer) {
  const json reference = klang::test::quasistatic_reference();
  const auto mesh = klang::test::reference_mesh(reference);
  const Eigen::VectorXd force = klang::test::nodal_force(mesh, reference["mesh"]["cases"][0]["force_n"]);
  FreeBodySolver printed(mesh, klang::test::reference_glass(), Relief::kEuclidean);
  FreeBodySolver right(mesh, klang::test::reference_glass());
  const double ratio = printed.solve(force).strain_energy_j[0] / right.solve(force).strain_energy_j[0];
  // tests/reference/quasistatic.json: euclidean_over_right_energy_corner
  EXPECT_LE(std::abs(ratio / 0.7677224903214179 - 1.0), 1e-10);
}

}  // namespace
