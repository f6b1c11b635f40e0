#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/math/taylor.hpp"
#include "core/physics/bubble/pitch_formulas.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "core/physics/bubble/rise_formulas.hpp"
#include "tests/core/physics/bubble/pitch_reference.hpp"

namespace klang::bubble {
namespace {

double relative(double value, double reference) { return std::abs(value / reference - 1.0); }

TEST(PlanePitch, TwoSphereSeriesIsTheReferencesExactFactor) {
  for (const auto& row : test::plane_pitches()) {
    EXPECT_LE(relative(two_sphere_factor(row.depth_over_radius), row.exact_release), 1e-12) << row.depth_over_radius;
    EXPECT_LE(relative(rigid_wall_factor(row.depth_over_radius), row.exact_rigid), 1e-11) << row.depth_over_radius;
  }
}

TEST(PlanePitch, StrasbergsFormulaIsTheReferencesAndFallsShortNearTheSurface) {
  for (const auto& row : test::plane_pitches()) {
    EXPECT_LE(relative(strasberg_factor(row.depth_over_radius), row.strasberg_release), 1e-12) << row.depth_over_radius;
  }
  EXPECT_NEAR(strasberg_factor(1.0), 1.511857892036909, 1e-12);
  EXPECT_NEAR(two_sphere_factor(1.05) / strasberg_factor(1.05), 1.08, 0.005);
}

TEST(PlanePitch, SeriesAndExpansionMeetWhereTheyChange) {
  const double a = 0.5;
  EXPECT_NEAR(detail::sinh_series(std::nextafter(a, 0.0)), detail::sinh_series(a), 1e-13);
}

TEST(Equation6, ClosedFormIsTheReferences) {
  for (const auto& row : test::equation6_pitches()) {
    EXPECT_LE(relative(harmonic_fluids_factor(0.0, row.phi_start_m, 72.95, 1.24, row.phi0_m), row.factor), 1e-12);
    EXPECT_LE(relative(harmonic_fluids_factor(0.0, row.phi_start_m, 72.95, 1.24, row.phi0_m, true), row.frozen_factor),
              1e-12);
  }
}

TEST(Equation6, IncrementsAddUpToTheClosedForm) {
  const double phi0 = -0.012, start = -0.02, k = 72.95, eta = 1.24;
  double omega = 1.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double step = -start / n, middle = start + (i + 0.5) * step;
    omega += k * omega * (1.0 + 0.5 * k * std::exp(-eta * (middle / phi0 - 1)) * step) *
             std::exp(-eta * (middle / phi0 - 1)) * step;
  }
  EXPECT_LE(relative(omega, harmonic_fluids_factor(0.0, start, k, eta, phi0)), 1e-6);
}

TEST(Equation6, IsClamped) {
  PitchModel model;
  model.phi0_m = -0.025;
  EXPECT_EQ(pitch_factor(model, 1e-3, -1e-4, -1.0), 3.0);
  model.largest_factor = 1000.0;
  EXPECT_GT(pitch_factor(model, 1e-3, -1e-4, -1.0), 150.0);
  model.eta = 0.0;
  EXPECT_THROW(model.validate(), InputError);
}

TEST(Equation6, OnlyTwoCombinationsOfItsThreeConstantsMatter) {
  const double k = 72.95, eta = 1.24, phi0 = -0.01, c = 1.3;
  // eta and phi0 scaled together, K so that K e^eta phi0 / eta stays
  const double k2 = k * std::exp(eta - c * eta);
  for (const double phi : {-0.02, -0.01, -0.003, 0.0}) {
    EXPECT_NEAR(harmonic_fluids_factor(phi, -0.03, k, eta, phi0),
                harmonic_fluids_factor(phi, -0.03, k2, c * eta, c * phi0), 1e-12);
  }
}

TEST(Taylor, DerivativesOfThePitchAreThoseOfFiniteDifferences) {
  const BubbleMedium medium;
  const double omega = undamped_angular_frequency_rad_s(medium, BubbleTheory::kLeighton, 1e-3);
  for (const PitchKind kind :
       {PitchKind::kHarmonicFluids, PitchKind::kHarmonicFluidsFrozen, PitchKind::kStrasberg, PitchKind::kTwoSphere}) {
    for (const BubbleTheory theory : {BubbleTheory::kLeighton, BubbleTheory::kProsperetti}) {
      PitchModel model;
      model.kind = kind;
      const auto decay = [&](auto t) {
        using T = decltype(t);
        const auto law = rise_law(medium, T(1e-3), T(0.2));
        const T phi = T(-0.006) + risen_m(law, T(-0.05), t);
        return bubble_damping(medium, theory, T(1e-3), T(T(omega) * pitch_factor(model, T(1e-3), phi, T(-0.006))))
            .decay_per_s;
      };
      for (const double t : {0.001, 0.02}) {  // while it sinks, while it rises
        const Taylor exact = decay(Taylor(t, 1.0, 0.0));
        const double h = 1e-4;
        const double first = (decay(t - 2 * h) - 8 * decay(t - h) + 8 * decay(t + h) - decay(t + 2 * h)) / (12 * h);
        const double second =
            (-decay(t - 2 * h) + 16 * decay(t - h) - 30 * decay(t) + 16 * decay(t + h) - decay(t + 2 * h)) /
            (12 * h * h);
        ASSERT_GT(std::abs(first), 0.1);
        EXPECT_LE(std::abs(exact.d - first), 1e-5 * std::abs(first)) << t;
        EXPECT_LE(std::abs(exact.dd - second), 1e-4 * std::abs(second)) << t;
      }
    }
  }
}

TEST(Rise, ObeysItsEquationOfMotionFromSinkingToTerminalSpeed) {
  const BubbleMedium medium;
  const double radius = 1.5e-3, volume = 4.0 / 3.0 * kPi * radius * radius * radius;
  const double rho = medium.liquid_density_kg_m3, gas = medium.gas_density_kg_m3;
  for (const double start : {-0.2, 0.0, 0.1, 0.6}) {
    for (const double t : {0.001, 0.008, 0.03, 0.2}) {
      const Taylor way = risen_m(rise_law(medium, Taylor(radius), Taylor(0.2)), Taylor(start), Taylor(t, 1.0, 0.0));
      const double force =
          (rho - gas) * volume * kGravityMS2 - 0.5 * 0.2 * rho * 4 * kPi * radius * radius * way.d * std::abs(way.d);
      EXPECT_NEAR((gas + 0.5 * rho) * volume * way.dd, force, 1e-9 * rho * volume * kGravityMS2) << start << " " << t;
    }
  }
  const auto law = rise_law(medium, radius, 0.2);
  EXPECT_NEAR(law.terminal_speed_m_s, 0.2213, 1e-4);
  EXPECT_GT(risen_m(law, 0.0, 0.05), 0.0);  // the printed weight of the liquid's mass would sink it
}

TEST(Attack, WindowIsSmoothAndStartsNearSilence) {
  const double beta = 400.0, end = -std::log(0.85) / beta;
  EXPECT_NEAR(attack_window(beta, 0.0), 0.00033546262790251185, 1e-15);
  EXPECT_NEAR(end * beta, 0.1625189294977749, 1e-15);
  EXPECT_NEAR(attack_window(beta, end), 1.0, 1e-12);
  EXPECT_NEAR((attack_window(beta, end) - attack_window(beta, end - 1e-7)) / 1e-7, 0.0, 5.0);  // of 0.85 beta / 0.04
  EXPECT_EQ(attack_window(beta, 1.01 * end), 1.0);
}

}  // namespace
}  // namespace klang::bubble
