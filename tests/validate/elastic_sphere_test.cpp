#include "validate/studies/elastic_sphere.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "core/foundation/base/errors.hpp"

namespace klang::validate {
namespace {

constexpr auto kT = SphereModeKind::kTorsional;
constexpr auto kS = SphereModeKind::kSpheroidal;

TEST(ElasticSphere, RootsMatchTheReferenceToThirteenDigits) {
  // tests/reference/sphere_lamb.json: cases[0].modes (nu = 0.29)
  const std::vector<std::tuple<double, SphereModeKind, int>> reference = {
      {2.501132620409397, kT, 2}, {2.64500665425552, kS, 2},  {3.509495880385619, kS, 1}, {3.864699778223047, kT, 3},
      {3.933378897104085, kS, 3}, {4.86995540349663, kS, 0},  {4.979266373405847, kS, 2}, {5.038887801390728, kS, 4},
      {5.094615632407945, kT, 4}, {5.76345919689455, kT, 1},  {6.07365850709576, kS, 5},  {6.265767845274791, kT, 5},
      {6.578593247412572, kS, 3}, {7.044406283070326, kS, 1}, {7.074240554299812, kS, 6}, {7.136008792190122, kT, 2},
      {7.403596927319171, kT, 6}, {7.981079051769928, kS, 1}, {8.055617519567779, kS, 7}, {8.185240342931794, kS, 4}};
  const std::vector<SphereMode> modes = elastic_sphere_modes(0.29, 8.19);
  ASSERT_EQ(modes.size(), reference.size());
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const auto& [x, kind, degree] = reference[i];
    EXPECT_LE(std::abs(modes[i].wavenumber_a / x - 1.0), 1e-13) << x;
    EXPECT_EQ(modes[i].kind, kind) << x;
    EXPECT_EQ(modes[i].degree, degree) << x;
  }
}

TEST(ElasticSphere, FrequenciesRepeatByMultiplicity) {
  // tests/reference/sphere_lamb.json: cases[0].example
  const auto steel = solid::from_youngs_modulus(200e9, 0.29, 7850.0);
  const Eigen::VectorXd f = elastic_sphere_frequency_hz(0.03, steel, 14);
  for (int i = 0; i < 5; ++i) EXPECT_LE(std::abs(f[i] / 41697.10601444799 - 1.0), 1e-12);
  for (int i = 5; i < 10; ++i) EXPECT_LE(std::abs(f[i] / 44095.671685478315 - 1.0), 1e-12);
  for (int i = 10; i < 13; ++i) EXPECT_LE(std::abs(f[i] / 58507.821851427754 - 1.0), 1e-12);
  EXPECT_LE(std::abs(f[13] / 64429.528866887034 - 1.0), 1e-12);
}

TEST(ElasticSphere, TorsionalDisplacementIsDivergenceFreeAndSolvesTheWaveEquation) {
  const double x = 2.501132620409397, a = 0.7, k = x / a, h = 1e-3;
  const Eigen::Vector3d at(0.21, -0.13, 0.34);
  const auto u = [&](const Eigen::Vector3d& p) { return torsional_displacement(2, x, a, p); };
  Eigen::Vector3d laplacian = -6.0 * u(at);
  double divergence = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(axis);
    laplacian += u(at + step) + u(at - step);
    divergence += (u(at + step)[axis] - u(at - step)[axis]) / (2.0 * h);
  }
  EXPECT_LE((laplacian / (h * h) + k * k * u(at)).norm(), 1e-5 * k * k * u(at).norm());
  EXPECT_LE(std::abs(divergence), 1e-6 * k * u(at).norm());
}

TEST(ElasticSphere, BadArgumentsAreInputErrors) {
  EXPECT_THROW(elastic_sphere_modes(0.5, 5.0), InputError);
  EXPECT_THROW(elastic_sphere_modes(0.3, -1.0), InputError);
  EXPECT_THROW(elastic_sphere_modes(0.3, 41.0), InputError);
  EXPECT_THROW(elastic_sphere_frequency_hz(0.03, solid::from_youngs_modulus(2e11, 0.3, 7800.0), 0), InputError);
}

}  // namespace
}  // namespace klang::validate
