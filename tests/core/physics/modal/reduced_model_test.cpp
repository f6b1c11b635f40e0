#include "core/physics/modal/reduced_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using klang::InputError;
using klang::test::box_mesh;
using namespace klang::modal;
namespace solid = klang::solid;

const auto kBody = box_mesh(0.1, 0.07, 0.03, 4, 3, 1, 2);
const solid::Material kMaterial{4.98e10, 2.57e10, 2700, "", ""};

const ReducedModel& reduced() {
  static const ReducedModel model = [] {
    ReducedModelOptions options;
    options.count = 12;
    return reduce(kBody, solid::assemble(kBody), kMaterial, {}, options);
  }();
  return model;
}

TEST(ReducedModel, GivesTheFullSolveOverTheRangeOfPoissonsRatio) {
  ASSERT_TRUE(reduced().nominal.usable()) << reduced().nominal.message;
  EXPECT_LE(reduced().max_relative_error, 1e-5);
  EXPECT_GT(reduced().max_relative_error, 0);
  const auto assembled = solid::assemble(kBody);
  EigenOptions options;
  options.count = 12;
  for (const double ratio : {0.05, 0.12, 0.25, 0.33, 0.42}) {
    const auto material = solid::from_youngs_modulus(50e9, ratio, 3000);
    const EigenResult full = solve_modes(kBody, assembled, material, {}, options);
    const auto small = reduced_eigenvalues(reduced(), material.lame_lambda_pa, material.lame_mu_pa, 3000);
    ASSERT_EQ(small.angular_frequency_sq.size(), 12);
    for (int k = 0; k < 12; ++k) {
      const double exact = std::pow(full.model.angular_frequency_rad_s[k], 2);
      EXPECT_NEAR(small.angular_frequency_sq[k] / exact, 1, 1e-5) << ratio << " " << k;
    }
  }
}

TEST(ReducedModel, IsHomogeneousInTheLameParameters) {
  const auto one = reduced_eigenvalues(reduced(), 4e10, 2e10, 2000);
  const auto two = reduced_eigenvalues(reduced(), 8e10, 4e10, 4000);
  for (int k = 0; k < 12; ++k) {
    EXPECT_NEAR(two.angular_frequency_sq[k] / one.angular_frequency_sq[k], 1, 1e-12);
    // Euler: lambda d/dlambda + mu d/dmu gives omega^2 back.
    EXPECT_NEAR((4e10 * one.derivative(k, 0) + 2e10 * one.derivative(k, 1)) / one.angular_frequency_sq[k], 1, 1e-10);
  }
}

TEST(ReducedModel, DerivativesMatchDifferences) {
  const double lambda = 4.1e10, mu = 2.9e10, density = 2700;
  const auto at = reduced_eigenvalues(reduced(), lambda, mu, density);
  for (int parameter = 0; parameter < 2; ++parameter) {
    const double step = 1e-4 * mu;
    const double l = parameter == 0 ? step : 0, m = parameter == 1 ? step : 0;
    const auto plus = reduced_eigenvalues(reduced(), lambda + l, mu + m, density);
    const auto minus = reduced_eigenvalues(reduced(), lambda - l, mu - m, density);
    for (int k = 0; k < 12; ++k) {
      const double scale = at.angular_frequency_sq[k] / mu;
      ASSERT_GT(at.derivative(k, parameter), 1e-4 * scale);
      const double difference = (plus.angular_frequency_sq[k] - minus.angular_frequency_sq[k]) / (2 * step);
      EXPECT_LE(std::abs(at.derivative(k, parameter) - difference), 1e-6 * scale) << k << " " << parameter;
    }
  }
}

TEST(ReducedModel, AClusterSharesTheDerivativeOfItsMean) {
  ReducedModel pair;  // two equal eigenvalues with derivatives 1 and 3 by lambda: any rotation of the basis
                      // must give 2
  pair.n_modes = 2;
  for (const double angle : {0.0, 0.4, 1.1}) {
    Eigen::Matrix2d turn;
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    pair.stiffness_lambda = turn * Eigen::Vector2d(1, 3).asDiagonal() * turn.transpose();
    pair.stiffness_mu = turn * Eigen::Vector2d(3, 1).asDiagonal() * turn.transpose();
    const auto at = reduced_eigenvalues(pair, 1e10, 1e10, 1000);
    EXPECT_NEAR(at.angular_frequency_sq[0], 4e7, 1);
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(at.derivative(k, 0), 2e-3, 1e-12);
  }
}

TEST(ReducedModel, IsSmoothInTheDimensions) {
  // Second differences of omega^2 over a change of length by parts in 1e4 stay of the size of its second
  // derivative: no branch of the reduction flips between neighbouring bodies.
  ReducedModelOptions options;
  options.count = 6;
  options.measure_error = false;
  std::vector<Eigen::VectorXd> values;
  for (const double stretch : {1 - 2e-4, 1 - 1e-4, 1.0, 1 + 1e-4, 1 + 2e-4}) {
    auto mesh = kBody;
    mesh.nodes_m.col(0) *= stretch;
    const auto model = reduce(mesh, solid::assemble(mesh), kMaterial, {}, options);
    values.push_back(reduced_eigenvalues(model, 4.1e10, 2.9e10, 2700).angular_frequency_sq);
  }
  for (int k = 0; k < 6; ++k) {
    for (std::size_t i = 1; i + 1 < values.size(); ++i) {
      const double second = values[i - 1][k] - 2 * values[i][k] + values[i + 1][k];
      EXPECT_LE(std::abs(second), 100 * 1e-8 * values[i][k]) << k;
    }
  }
}

TEST(ReducedModel, RefusesAnchorsOutsideTheElasticRange) {
  ReducedModelOptions options;
  options.anchor_poissons_ratios = {0.1, 0.5};
  EXPECT_THROW(reduce(kBody, solid::assemble(kBody), kMaterial, {}, options), InputError);
  options.anchor_poissons_ratios = {};
  EXPECT_THROW(reduce(kBody, solid::assemble(kBody), kMaterial, {}, options), InputError);
}

}  // namespace
