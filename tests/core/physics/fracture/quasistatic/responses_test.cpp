#include "core/physics/fracture/quasistatic/contact_responses.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using klang::InputError;
using klang::test::box_mesh;
using klang::test::reference_glass;

const std::vector<NodeForce> kForces = {{3, {1, -2, 3}}, {17, {0, 5, 0}}, {40, {-4, 0, 2}}, {3, {0.5, 0, 0}}};

class Responses : public testing::TestWithParam<int> {
 protected:
  FreeBodySolver solver_{box_mesh(0.04, 0.02, 0.02, 4, 2, 2, GetParam()), reference_glass()};
};
INSTANTIATE_TEST_SUITE_P(Elements, Responses, testing::Values(1, 2));

TEST_P(Responses, CachedFieldIsThatOfADirectSolve) {
  ContactResponses responses(solver_);
  const StressField cached = responses.field(kForces);
  const QuasistaticSolution solution = solver_.solve(nodal_force_n(solver_.mesh(), kForces));
  const StressField direct = solver_.stresses().field(solution.displacement_m.col(0));
  EXPECT_LE((cached.stress_pa - direct.stress_pa).cwiseAbs().maxCoeff(),
            1e-12 * direct.stress_pa.cwiseAbs().maxCoeff());
  EXPECT_LE(std::abs(cached.strain_energy_j / direct.strain_energy_j - 1.0), 1e-12);
  EXPECT_LE(std::abs(responses.strain_energy_j(kForces) / direct.strain_energy_j - 1.0), 1e-12);
  EXPECT_EQ(responses.n_nodes_solved(), 3);
  EXPECT_LE(responses.largest_residual(), 1e-12);
}

TEST_P(Responses, ALoadOnManyNodesIsSolvedWholeAndIsTheSumOfItsParts) {
  ContactResponses responses(solver_);
  std::vector<NodeForce> many, first, second;
  const int n = static_cast<int>(ContactResponses::kMostNodes) + 6;
  ASSERT_GE(solver_.mesh().n_nodes(), n / 2);
  for (int i = 0; i < std::min(n, solver_.mesh().n_nodes()); ++i) {
    many.push_back({i, {std::sin(i), std::cos(2.0 * i), 0.1 * i}});
    (i % 2 == 0 ? first : second).push_back(many.back());
  }
  const Eigen::VectorXd whole = responses.displacement_m(many);
  if (many.size() > ContactResponses::kMostNodes) EXPECT_EQ(responses.n_nodes_kept(), 0u);
  const Eigen::VectorXd parts = responses.displacement_m(first) + responses.displacement_m(second);
  EXPECT_LE((whole - parts).cwiseAbs().maxCoeff(), 1e-10 * whole.cwiseAbs().maxCoeff());
  const QuasistaticSolution direct = solver_.solve(nodal_force_n(solver_.mesh(), many));
  EXPECT_LE(std::abs(responses.strain_energy_j(many) / direct.strain_energy_j[0] - 1.0), 1e-10);
}

TEST_P(Responses, BitsDoNotDependOnWhatWasAskedBefore) {
  ContactResponses fresh(solver_), used(solver_);
  used.field({{40, {1, 1, 1}}});
  used.field({{5, {1, 0, 0}}, {6, {0, 1, 0}}, {7, {0, 1, 0}}, {17, {1, 0, 1}}});
  EXPECT_EQ(fresh.displacement_m(kForces), used.displacement_m(kForces));
}

TEST_P(Responses, WhatWasUsedLongestAgoIsDroppedAboveTheLimit) {
  const std::size_t per_node = 72 * static_cast<std::size_t>(solver_.mesh().n_nodes());
  ContactResponses responses(solver_, 2 * per_node);
  const Eigen::VectorXd first = responses.displacement_m({{1, {1, 0, 0}}});
  responses.displacement_m({{2, {1, 0, 0}}});
  responses.displacement_m({{1, {0, 1, 0}}});
  EXPECT_EQ(responses.n_nodes_solved(), 2);
  responses.displacement_m({{3, {1, 0, 0}}});
  EXPECT_EQ(responses.n_nodes_kept(), 2u);
  EXPECT_EQ(responses.displacement_m({{1, {1, 0, 0}}}), first);
  EXPECT_EQ(responses.n_nodes_solved(), 3);  // 1 was kept, 2 was dropped
  responses.field(kForces);
  EXPECT_EQ(responses.n_nodes_kept(), 3u);  // as many as one load needs
}

TEST_P(Responses, NodesThatAreNotThereAndNaNAreRefused) {
  ContactResponses responses(solver_);
  EXPECT_THROW(responses.field({{-1, {1, 0, 0}}}), InputError);
  EXPECT_THROW(responses.field({{solver_.mesh().n_nodes(), {1, 0, 0}}}), InputError);
  EXPECT_THROW(responses.field({{0, {std::nan(""), 0, 0}}}), InputError);
}

}  // namespace
