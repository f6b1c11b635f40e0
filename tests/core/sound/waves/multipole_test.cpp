#include "core/sound/waves/multipole.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"
#include "tests/core/sound/bem/radiation_reference.hpp"
#include "tests/core/sound/waves/sphere_field.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;
const Medium kAir;

// Surface pressure of the closed form, unit normal velocity times P_n(cos theta).
SurfaceField reference_field(const ReferenceSphere& row, int n_points) {
  SurfaceField field = ellipsoid_points(Eigen::Vector3d::Constant(kReferenceRadius), n_points);
  for (Eigen::Index i = 0; i < field.points_m.cols(); ++i) {
    const double c = field.normals(2, i);
    const double p[] = {1.0, c, 0.5 * (3 * c * c - 1), 0.5 * (5 * c * c * c - 3 * c)};
    field.normal_velocity_m_s[i] = p[row.n];
    field.pressure_pa[i] = kAir.density_kg_m3 * kAir.sound_speed_m_s * row.surface_pressure * p[row.n];
  }
  return field;
}

TEST(Multipole, SpheresHaveTheReferenceCoefficientsPowerAndField) {
  for (const ReferenceSphere& row : kReferenceSpheres) {
    const double k = row.ka / kReferenceRadius;
    EXPECT_LE(std::abs(k - kAir.wavenumber_per_m(row.frequency_hz)), 1e-12 * k);
    const MultipoleResult result = multipole_from_surface(reference_field(row, 24), k, kAir, Eigen::Vector3d::Zero());
    ASSERT_EQ(result.status, MultipoleResult::Status::kDone);
    const Multipole& m = result.multipole;
    const Complex found = m.coefficients_pa[basis_index(row.n, 0)];
    EXPECT_LE(std::abs(found - row.coefficient_pa), 1e-11 * std::abs(row.coefficient_pa)) << row.name << row.ka;
    EXPECT_LE(std::abs(result.surface_power_w - row.power_w), 1e-10 * row.power_w) << row.name << row.ka;
    EXPECT_LE(std::abs(radiated_power_w(m, kAir) - row.power_w), 1e-10 * row.power_w) << row.name << row.ka;
    // The other coefficients vanish, measured by the pressure that they would make on the surface.
    const double r = 2 * kReferenceRadius;
    const Complex p = pressure_pa(truncated(m, std::max(row.n, 2)), {r * 0.5, 0.0, r * std::sqrt(0.75)});
    EXPECT_LE(std::abs(p - row.field_pa), 1e-10 * std::abs(row.field_pa)) << row.name << row.ka;
    EXPECT_GE(m.order, std::ceil(row.ka) + 2);
  }
}

TEST(Multipole, OrderIsAtLeastKaPlus2AndKeepsTheStatedFraction) {
  for (const double ka : {0.05, 1.0, 5.0, 10.0, 20.0}) {
    const double k = ka / 0.1;
    SurfaceField field = ellipsoid_points(Eigen::Vector3d::Constant(0.1), 64);
    set_field(field, monopole_field({0.03, 0.05, 0.06}, k), k, kAir);
    for (const double fraction : {0.9, 0.999, 0.9999999}) {
      OrderOptions options;
      options.kept_power_fraction = fraction;
      const MultipoleResult result = multipole_from_surface(field, k, kAir, Eigen::Vector3d::Zero(), options);
      const double exact_w = 4 * kPi / (2 * kAir.density_kg_m3 * kAir.sound_speed_m_s);  // |p| = 1 / r
      EXPECT_GE(result.multipole.order, static_cast<int>(std::ceil(ka)) + 2);
      EXPECT_GE(radiated_power_w(result.multipole, kAir), fraction * exact_w);
      EXPECT_LE(radiated_power_w(result.multipole, kAir), exact_w * (1 + 1e-9));
      EXPECT_LE(std::abs(result.surface_power_w - exact_w), 1e-9 * exact_w);
    }
  }
}

TEST(Multipole, PaperRuleLosesThePowerThatTheReferenceSays) {
  // tests/reference/radiation.json: truncation_offcentre_monopole. A monopole at distance d from the centre; L = 2 d.
  for (const ReferenceTruncation& row : kReferenceTruncations) {
    const double d = 0.1, k = row.kd / d;
    const Multipole whole{Eigen::Vector3d::Zero(), k, 40, [&] {
                            Eigen::VectorXcd r;
                            HelmholtzBasis(40).values(Wave::kRegular, k, {0.0, 0.6 * d, 0.8 * d}, r);
                            return r.conjugate().eval();
                          }()};
    const double all = radiated_power_w(whole, kAir);
    OrderOptions options;
    options.paper_rule = true;
    const int paper = lowest_order(row.kd, options);
    EXPECT_EQ(paper, row.paper_order);
    const auto lost = [&](int order) { return 1.0 - radiated_power_w(truncated(whole, order), kAir) / all; };
    EXPECT_LE(std::abs(lost(paper) - row.paper_lost_fraction), 1e-9);
    EXPECT_LE(lost(row.order_for_1_percent), 1e-2);
    EXPECT_GT(lost(row.order_for_1_percent - 1), 1e-2);
    EXPECT_LE(lost(row.order_for_1e_4), 1e-4);
    EXPECT_GT(lost(row.order_for_1e_4 - 1), 1e-4);
  }
}

// A body that is not a sphere, with sources off its centre: the field outside must be that of the sources.
TEST(Multipole, EllipsoidWithInnerSourcesRadiatesTheExactField) {
  const double k = 40.0;
  SurfaceField field = ellipsoid_points({0.06, 0.09, 0.12}, 60);
  const ExactField one = monopole_field({0.01, -0.04, 0.05}, k, {1.0, 0.5}),
                   two = monopole_field({-0.02, 0.03, -0.06}, k, {0.0, -1.2});
  const ExactField sum = [&](const Eigen::Vector3d& x, Eigen::Vector3cd& gradient) {
    Eigen::Vector3cd other;
    const Complex p = one(x, gradient) + two(x, other);
    gradient += other;
    return p;
  };
  set_field(field, sum, k, kAir);
  OrderOptions options;
  options.fixed_order = 30;
  const Multipole m = multipole_from_surface(field, k, kAir, {0.0, 0.01, 0.0}, options).multipole;
  for (const Eigen::Vector3d& x :
       {Eigen::Vector3d(0.3, 0.1, -0.2), Eigen::Vector3d(0.0, 0.0, 0.4), Eigen::Vector3d(-1.0, 2.0, 0.5)}) {
    Eigen::Vector3cd exact_gradient, gradient;
    const Complex exact = sum(x, exact_gradient), p = pressure_pa(m, x, gradient);
    EXPECT_LE(std::abs(p - exact), 1e-8 * std::abs(exact));
    EXPECT_LE((gradient - exact_gradient).norm(), 1e-8 * exact_gradient.norm());
  }
  // Far field: exp(-ik|x - y|) / |x - y| -> exp(ik s.y) e^{-ikr} / r.
  const Eigen::Vector3d s = Eigen::Vector3d(0.2, -0.5, 0.8).normalized();
  Multipole at_origin = m;
  const Complex far = far_field_pa_m(m, s) * std::exp(Complex(0, k * s.dot(m.centre_m)));
  const Complex exact = Complex(1.0, 0.5) * std::exp(Complex(0, k * s.dot(Eigen::Vector3d(0.01, -0.04, 0.05)))) +
                        Complex(0.0, -1.2) * std::exp(Complex(0, k * s.dot(Eigen::Vector3d(-0.02, 0.03, -0.06))));
  EXPECT_LE(std::abs(far - exact), 1e-8 * std::abs(exact));
}

TEST(Multipole, FarFieldPowerIsTheSumOfSquares) {
  const double k = 30.0;
  SurfaceField field = ellipsoid_points(Eigen::Vector3d::Constant(0.1), 40);
  set_field(field, monopole_field({0.02, 0.03, 0.04}, k), k, kAir);
  const Multipole m = multipole_from_surface(field, k, kAir, Eigen::Vector3d::Zero()).multipole;
  const SurfaceField unit = ellipsoid_points(Eigen::Vector3d::Ones(), 30);
  double power = 0.0;
  for (Eigen::Index i = 0; i < unit.points_m.cols(); ++i)
    power += unit.weights_m2[i] * std::norm(far_field_pa_m(m, unit.points_m.col(i)));
  power /= 2 * kAir.density_kg_m3 * kAir.sound_speed_m_s;
  EXPECT_LE(std::abs(power - radiated_power_w(m, kAir)), 1e-12 * power);
}

TEST(Multipole, SameBitsOnOneAndOnTwoThreads) {
  const double k = 50.0;
  SurfaceField field = ellipsoid_points(Eigen::Vector3d::Constant(0.1), 40);
  set_field(field, monopole_field({0.02, 0.03, 0.04}, k), k, kAir);
  set_thread_count(1);
  const Eigen::VectorXcd one = multipole_coefficients(field, k, kAir, Eigen::Vector3d::Zero(), 12);
  set_thread_count(2);
  const Eigen::VectorXcd two = multipole_coefficients(field, k, kAir, Eigen::Vector3d::Zero(), 12);
  set_thread_count(0);
  EXPECT_EQ((one - two).cwiseAbs().maxCoeff(), 0.0);
}

TEST(Multipole, BadOptionsAreBadInput) {
  OrderOptions options;
  options.kept_power_fraction = 1.0;
  EXPECT_THROW(options.validate(), InputError);
  options = {};
  options.fixed_order = -1;
  EXPECT_THROW(options.validate(), InputError);
}

}  // namespace
}  // namespace klang::acoustics
