#include "core/sound/bem/equivalent_sources.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/sphere_quadrature.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"
#include "tests/core/sound/waves/sphere_field.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;
const Medium kAir;

SurfaceField sphere_with_monopole(double k, const Eigen::Vector3d& at) {
  SurfaceField field = ellipsoid_points(Eigen::Vector3d::Constant(0.1), 24);
  set_field(field, monopole_field(at, k), k, kAir);
  return field;
}

TEST(SphereQuadrature, IntegratesProductsOfHarmonicsExactly) {
  const int order = 16;
  const SphereQuadrature rule = sphere_quadrature(2 * order);
  const SphericalHarmonics harmonics(order);
  Eigen::MatrixXcd y(rule.weights.size(), basis_size(order));
  Eigen::VectorXcd row(basis_size(order));
  for (Eigen::Index i = 0; i < y.rows(); ++i) {
    harmonics.evaluate(rule.directions.col(i), row.data());
    y.row(i) = row.transpose();
  }
  Eigen::MatrixXcd gram = y.adjoint() * rule.weights.asDiagonal() * y;
  gram.diagonal().array() -= 1.0;
  EXPECT_LE(gram.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(EquivalentSources, OneMonopoleAtTheSourceIsExact) {
  const double k = 50.0;
  const Eigen::Vector3d at(0.03, -0.02, 0.05);
  const EquivalentSources fit = fit_equivalent_sources(sphere_with_monopole(k, at), k, kAir, {at}, {.order = 0});
  ASSERT_EQ(fit.status, EquivalentSources::Status::kDone);
  EXPECT_LE(fit.velocity_residual, 1e-9);
  EXPECT_LE(fit.pressure_residual.value(), 1e-9);
  EXPECT_LE(fit.far_field_error.value(), 1e-9);
  EXPECT_LE(std::abs(fit.lost_power_fraction.value()), 1e-9);
  // e^{-ikr} / r = -ik h_0, and Y_0^0 = 1 / sqrt(4 pi)
  const Complex expected(0.0, -k * std::sqrt(4 * kPi));
  EXPECT_LE(std::abs(fit.sources[0].coefficients_pa[0] - expected), 1e-9 * std::abs(expected));
}

TEST(EquivalentSources, FitAtTheCentreAgreesWithTheIntegral) {
  const double k = 50.0;  // ka = 5
  const SurfaceField field = sphere_with_monopole(k, {0.03, -0.02, 0.05});
  const EquivalentSources fit =
      fit_equivalent_sources(field, k, kAir, {Eigen::Vector3d::Zero()}, {.order = 16, .regularisation = 1e-13});
  const Eigen::VectorXcd integral = multipole_coefficients(field, k, kAir, Eigen::Vector3d::Zero(), 8);
  EXPECT_LE((fit.sources[0].coefficients_pa.head(integral.size()) - integral).norm(), 1e-5 * integral.norm());
}

TEST(EquivalentSources, ErrorsFallWithOrderAndAreThoseOfTheFieldOutside) {
  const double k = 80.0;
  const SurfaceField field = sphere_with_monopole(k, {0.03, -0.02, 0.05});
  double before = 1e300;
  for (const int order : {3, 7, 11, 15}) {
    const EquivalentSources fit = fit_equivalent_sources(field, k, kAir, {Eigen::Vector3d::Zero()}, {.order = order});
    EXPECT_LT(fit.far_field_error.value(), 0.5 * before) << order;
    before = fit.far_field_error.value();
    // far_field_error against the exact far field e^{ik s.y}.
    const SphereQuadrature rule = sphere_quadrature(60);
    double error = 0.0;
    for (Eigen::Index i = 0; i < rule.weights.size(); ++i) {
      const Eigen::Vector3d s = rule.directions.col(i);
      error += rule.weights[i] * std::norm(far_field_pa_m(fit.sources, s) -
                                           std::polar(1.0, k * s.dot(Eigen::Vector3d(0.03, -0.02, 0.05))));
    }
    EXPECT_LE(std::abs(std::sqrt(error / (4 * kPi)) - before), 1e-6 + 1e-6 * before) << order;
  }
  EXPECT_LE(before, 1e-3);
}

TEST(EquivalentSources, SeveralPointsServeAnOblongBodyBetterThanOneOfAsManyTerms) {
  // A slender ellipsoid, ka = 12, with sources near both ends: 16 points of order 1 (64 terms) against one of order 7 (64).
  const double k = 60.0;
  SurfaceField field = ellipsoid_points({0.04, 0.05, 0.2}, 40);
  const ExactField one = monopole_field({0.01, 0.0, 0.15}, k), two = monopole_field({0.0, -0.02, -0.14}, k, {0.3, 0.8});
  set_field(
      field,
      [&](const Eigen::Vector3d& x, Eigen::Vector3cd& gradient) {
        Eigen::Vector3cd other;
        const Complex p = one(x, gradient) + two(x, other);
        gradient += other;
        return p;
      },
      k, kAir);
  const EquivalentSources single = fit_equivalent_sources(field, k, kAir, {Eigen::Vector3d::Zero()}, {.order = 7});
  const std::vector<Eigen::Vector3d> points = inner_points(field, 16);
  ASSERT_EQ(points.size(), 16u);
  const EquivalentSources several = fit_equivalent_sources(field, k, kAir, points, {.order = 1});
  EXPECT_LE(several.far_field_error.value(), 0.3 * single.far_field_error.value());
  // Also better than the integral's multipole cut at order 7, whose far-field error is the root of the lost power.
  const Multipole cut = {Eigen::Vector3d::Zero(), k, 7,
                         multipole_coefficients(field, k, kAir, Eigen::Vector3d::Zero(), 7)};
  const double lost = 1.0 - radiated_power_w(cut, kAir) / surface_power_w(field);
  EXPECT_LE(several.far_field_error.value(), 0.5 * std::sqrt(lost));
}

TEST(InnerPoints, LieInsideAndTheFirstOfASphereIsItsCentre) {
  const SurfaceField sphere = ellipsoid_points(Eigen::Vector3d::Constant(0.1), 30, {1.0, 2.0, 3.0});
  EXPECT_LE((inner_points(sphere, 1)[0] - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  const SurfaceField flat = ellipsoid_points({0.2, 0.1, 0.01}, 60);
  const std::vector<Eigen::Vector3d> points = inner_points(flat, 9);
  EXPECT_EQ(points.size(), 9u);
  for (const Eigen::Vector3d& p : points) EXPECT_LT(p.cwiseQuotient(Eigen::Vector3d(0.2, 0.1, 0.01)).norm(), 1.0);
}

TEST(EquivalentSources, PointOutsideTheBodyIsBadInput) {
  const SurfaceField field = sphere_with_monopole(10.0, Eigen::Vector3d::Zero());
  EXPECT_THROW(fit_equivalent_sources(field, 10.0, kAir, {{0.0, 0.0, 0.3}}), InputError);
  EXPECT_THROW(fit_equivalent_sources(field, 10.0, kAir, {}), InputError);
}

}  // namespace
}  // namespace klang::acoustics
