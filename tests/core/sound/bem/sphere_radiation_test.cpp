#include "core/sound/bem/sphere_radiation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace {

using namespace klang::acoustics;
using Complex = std::complex<double>;

/// One solver a mesh: what no frequency changes is done once.
SphereResult solved(int degree, double ka, int divisions) {
  static std::map<int, std::shared_ptr<const HelmholtzBem>> solvers;
  BemOptions options;
  options.allow_coarse = true;
  const SphereCase sphere{degree, 0.05, ka, divisions};
  auto& solver = solvers[divisions];
  const SphereResult result = solver ? solve_sphere(sphere, solver, options) : solve_sphere(sphere, options);
  solver = result.solver;
  EXPECT_TRUE(result.bem.usable()) << result.bem.message;
  return result;
}

// tests/reference/radiation.json, rows[].surface_p_over_rhocv and M_n0_unit_velocity_SI (a = 0.05 m).
struct Row {
  double ka;
  int degree;
  double surface_modulus;
  Complex coefficient_pa;
};
const Row kRows[] = {{0.1, 0, 0.09950371902099892, {14.568032367670732, 0.004827081410355625}},
                     {1.0, 1, 0.6324555320336759, {375.8531198039518, -40.4270105278931}},
                     {5.0, 2, 1.0987915289345411, {1418.8111592819969, 3064.899928078899}},
                     {10.0, 3, 1.0579396409884185, {-1566.9939499372665, -5452.859780043567}}};

}  // namespace

TEST(SphereRadiation, ClosedFormsAgreeWithTheReference) {
  const Medium air;
  for (const Row& row : kRows) {
    const double modulus =
        std::abs(sphere_impedance(row.degree, row.ka, air)) / (air.density_kg_m3 * air.sound_speed_m_s);
    EXPECT_LE(std::abs(modulus - row.surface_modulus), 1e-12 * row.surface_modulus) << row.ka;
    const Complex coefficient = sphere_coefficient_pa({row.degree, 0.05, row.ka, 10}, air);
    EXPECT_LE(std::abs(coefficient - row.coefficient_pa), 1e-11 * std::abs(row.coefficient_pa)) << row.ka;
  }
}

// Power by the impedance on the surface against power through the multipole, two ways that share no formula but h_n.
TEST(SphereRadiation, ExactPowerIsThatOfTheExactMultipole) {
  const Medium air;
  for (const Row& row : kRows) {
    const SphereCase sphere{row.degree, 0.05, row.ka, 10};
    Multipole multipole;
    multipole.wavenumber_per_m = row.ka / sphere.radius_m;
    multipole.order = row.degree;
    multipole.coefficients_pa = Eigen::VectorXcd::Zero((row.degree + 1) * (row.degree + 1));
    multipole.coefficients_pa[row.degree * (row.degree + 1)] = sphere_coefficient_pa(sphere, air);
    const double exact_w = sphere_radiated_power_w(sphere, air);
    EXPECT_LE(std::abs(radiated_power_w(multipole, air) / exact_w - 1.0), 1e-10) << row.ka;
  }
}

TEST(SphereRadiation, DivisionsGiveAtLeastTheElementsAskedFor) {
  EXPECT_EQ(sphere_divisions(20), 1);
  EXPECT_EQ(sphere_divisions(21), 2);
  EXPECT_EQ(sphere_divisions(2000), 10);
  EXPECT_EQ(sphere_divisions(2001), 11);
}

// The bar is 1 % on the surface and 0.5 % of coefficients and field points.
TEST(SphereRadiation, PressureAndMultipolesOfTwoThousandElementsMatchTheReference) {
  for (const Row& row : kRows) {
    const SphereResult result = solved(row.degree, row.ka, 10);
    EXPECT_EQ(result.bem.n_elements, 2000);
    EXPECT_LE(result.surface_pressure_relative_error, 0.006) << "ka " << row.ka;
    const int at = row.degree * (row.degree + 1);
    EXPECT_LE(std::abs(result.multipole.coefficients_pa[at] - row.coefficient_pa), 0.002 * std::abs(row.coefficient_pa))
        << "ka " << row.ka;
    const Eigen::Vector3d x = 0.1 * Eigen::Vector3d(std::sin(klang::kPi / 6), 0.0, std::cos(klang::kPi / 6));
    const Complex exact = sphere_pressure_pa({row.degree, 0.05, row.ka, 10}, {}, x);
    EXPECT_LE(std::abs(result.solver->pressure_at(result.bem, x)[0] - exact), 0.005 * std::abs(exact)) << row.ka;
    EXPECT_LE(*result.bem.relative_residual, 1e-9);
  }
}

TEST(SphereRadiation, PressureErrorFallsAtOrderTwo) {
  for (const int degree : {0, 2}) {
    double before = 0.0, coarser = 0.0;
    for (const int divisions : {4, 8, 12}) {
      const double error = solved(degree, 1.0, divisions).surface_pressure_relative_error;
      if (before > 0.0) {
        EXPECT_GE(std::log(before / error) / std::log(divisions / coarser), 1.7)
            << "degree " << degree << ", " << divisions << " divisions";
        EXPECT_LE(std::log(before / error) / std::log(divisions / coarser), 2.3)
            << "degree " << degree << ", " << divisions << " divisions";
      }
      before = error;
      coarser = divisions;
    }
  }
}

// pi and 4.4934 are resonances of the ball inside with pressure 0, 2.0816 and 4.4934 of the rigid one.
TEST(SphereRadiation, ResonancesOfTheInsideDoNotShow) {
  for (const double resonance : {2.0815759778, klang::kPi, 4.4934094579}) {
    for (const int degree : {0, 1}) {
      const double at = solved(degree, resonance, 4).surface_pressure_relative_error;
      const double below = solved(degree, 0.97 * resonance, 4).surface_pressure_relative_error;
      const double above = solved(degree, 1.03 * resonance, 4).surface_pressure_relative_error;
      EXPECT_LE(at, 1.02 * std::max(below, above)) << "ka " << resonance << ", degree " << degree;
    }
  }
}

TEST(SphereRadiation, PowerFromTheSurfaceIsThePowerFarAway) {
  const Medium air;
  for (const double ka : {1.0, 5.0}) {
    const SphereResult result = solved(0, ka, 10);
    const double far = radiated_power_w(result.multipole, air);
    EXPECT_LE(std::abs(result.bem.radiated_power_w[0] - far), 0.005 * far) << "ka " << ka;
    EXPECT_LE(std::abs(surface_power_w(result.solver->field(result.bem)) - result.bem.radiated_power_w[0]), 1e-9 * far);
  }
}

TEST(SphereRadiation, BadCasesAreRefused) {
  EXPECT_THROW(solve_sphere({-1, 0.1, 1.0, 4}), klang::InputError);
  EXPECT_THROW(solve_sphere({0, 0.0, 1.0, 4}), klang::InputError);
  EXPECT_THROW(solve_sphere({0, 0.1, NAN, 4}), klang::InputError);
  EXPECT_THROW(solve_sphere({0, 0.1, 10.0, 4}), klang::InputError);  // 2 elements per wavelength
}
