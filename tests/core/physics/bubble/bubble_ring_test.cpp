#include "core/physics/bubble/bubble_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "datasets-synthetic/oscillator_ode.hpp"

namespace klang::bubble {
namespace {

using datasets::OscillatorCoefficients;

/// Largest errors over a life (until the amplitude is 1/1000) against the order-8 implicit integration.
struct LifeError {
  double level_db = 0.0, phase_rad = 0.0, pitch_rise = 1.0;
  int n = 0;
};

OscillatorCoefficients coefficients_at(const RingingBubble& bubble, double age_s) {
  double omega = undamped_angular_frequency_rad_s(bubble.medium, bubble.theory, bubble.radius_m);
  if (bubble.motion)
    omega *= pitch_factor(bubble.pitch, bubble.radius_m, bubble.motion->phi_m(age_s).v, bubble.motion->phi_m(0.0).v);
  return {omega, bubble_damping(bubble.medium, bubble.theory, bubble.radius_m, omega).decay_per_s};
}

LifeError life_error(const RingingBubble& bubble, std::vector<double> corners = {}) {
  const RingTrack track = ring_track(bubble);
  const double step = 0.25 / coefficients_at(bubble, 0.0).omega0_rad_s;
  const auto n = static_cast<Eigen::Index>(track.faded_from_s / step);
  if (bubble.motion) {
    for (const double corner : bubble.motion->breaks_s()) corners.push_back(corner);
  }
  std::sort(corners.begin(), corners.end());
  const Eigen::MatrixXd truth = datasets::integrate_oscillator([&](double t) { return coefficients_at(bubble, t); },
                                                               bubble.onset_velocity_m_s, step, step, n, corners);
  LifeError error;
  error.n = static_cast<int>(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(i + 1) * step;
    // The same reading of (q, q') as a rotating number for both, so that only the solutions are compared.
    const OscillatorCoefficients at = coefficients_at(bubble, t);
    const double wd = std::sqrt(at.omega0_rad_s * at.omega0_rad_s - at.decay_per_s * at.decay_per_s);
    const std::complex<double> z = track.value(t), rate = track.block_at(t).rate_at(t);
    const auto rotating = [&](double q, double v) { return std::complex<double>(q, -(v + at.decay_per_s * q) / wd); };
    const std::complex<double> ratio = rotating(z.real(), (rate * z).real()) / rotating(truth(i, 0), truth(i, 1));
    error.level_db = std::max(error.level_db, std::abs(20 * std::log10(std::abs(ratio))));
    error.phase_rad = std::max(error.phase_rad, std::abs(std::arg(ratio)));
    error.pitch_rise = std::max(error.pitch_rise, at.omega0_rad_s / coefficients_at(bubble, 0.0).omega0_rad_s);
  }
  return error;
}

void expect_within_the_bar(const LifeError& error, const std::string& what) {
  EXPECT_GT(error.n, 300);
  EXPECT_LE(error.level_db, 0.01) << what;
  EXPECT_LE(error.phase_rad, 1e-4) << what;
  ::testing::Test::RecordProperty(what,
                                  std::to_string(error.level_db) + " dB, " + std::to_string(error.phase_rad) + " rad");
  std::printf("  %-40s rise x%.3f: %.2e dB, %.2e rad\n", what.c_str(), error.pitch_rise, error.level_db,
              error.phase_rad);
}

TEST(BubbleRing, ConstantPitchIsTheExactExponential) {
  for (const double radius_m : {3e-4, 1e-3, 5e-3}) {
    RingingBubble bubble;
    bubble.radius_m = radius_m;
    const LifeError error = life_error(bubble);
    EXPECT_LE(error.level_db, 1e-7);
    EXPECT_LE(error.phase_rad, 1e-8);
  }
}

TEST(BubbleRing, RisingPitchStaysWithinAHundredthOfADecibelAndATenThousandthOfARadian) {
  for (const double radius_m : {5e-4, 1e-3, 2e-3, 5e-3}) {
    for (const PitchKind kind :
         {PitchKind::kHarmonicFluids, PitchKind::kHarmonicFluidsFrozen, PitchKind::kStrasberg, PitchKind::kTwoSphere}) {
      for (const RiseKind rise : {RiseKind::kConstantSpeed, RiseKind::kTerminal}) {
        RingingBubble bubble;
        bubble.radius_m = radius_m;
        bubble.pitch.kind = kind;
        RiseOptions options;
        options.kind = rise;
        options.speed_m_s = 0.3;
        bubble.motion = analytic_rise({0, 0, -std::max(0.012, 1.5 * radius_m)}, radius_m, options);
        expect_within_the_bar(life_error(bubble), "r " + std::to_string(1e3 * radius_m) + " mm, model " +
                                                      std::to_string(static_cast<int>(kind)) + ", rise " +
                                                      std::to_string(static_cast<int>(rise)));
      }
    }
  }
}

TEST(BubbleRing, ProsperettisDampingAndASinkingStartStayWithinTheBar) {
  RingingBubble bubble;
  bubble.radius_m = 2e-3;
  bubble.theory = BubbleTheory::kProsperetti;
  RiseOptions options;
  options.kind = RiseKind::kTerminal;
  options.speed_m_s = -0.3;
  bubble.motion = analytic_rise({0, 0, -0.006}, bubble.radius_m, options);
  expect_within_the_bar(life_error(bubble), "Prosperetti, sinking");
}

TEST(BubbleRing, CornerWhereTheClampSetsInIsCarriedOver) {
  RingingBubble bubble;
  bubble.radius_m = 3e-3;
  bubble.pitch.largest_factor = 1.4;
  RiseOptions options;
  options.kind = RiseKind::kConstantSpeed;
  options.speed_m_s = 0.4;
  bubble.motion = analytic_rise({0, 0, -0.012}, bubble.radius_m, options);
  // Where the pitch reaches the clamp, by bisection of the model itself.
  double low = 0.0, high = 0.03;
  const double omega = coefficients_at(bubble, 0.0).omega0_rad_s;
  while (std::nextafter(low, high) < high) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) break;
    (coefficients_at(bubble, middle).omega0_rad_s < 1.4 * omega * (1 - 1e-15) ? low : high) = middle;
  }
  ASSERT_LT(high, 0.02);
  expect_within_the_bar(life_error(bubble, {high}), "clamped");
}

TEST(BubbleRing, SplinedPathStaysWithinTheBar) {
  RingingBubble bubble;
  bubble.radius_m = 1.5e-3;
  SampledMotion samples;
  samples.positions_m = {{0, 0, -0.01}};
  for (int i = 0; i <= 100; ++i) {
    const double t = 5e-4 * i;
    samples.times_s.push_back(t);
    samples.phi_m.push_back(-0.008 + 0.12 * t + 3e-4 * std::sin(2 * kPi * 60.0 * t));
  }
  bubble.motion = sampled_motion(samples);
  expect_within_the_bar(life_error(bubble), "path with 60 Hz wobble");
}

TEST(BubbleRing, WithoutDampingEnergyOverFrequencyStaysAlongARise) {
  RingingBubble bubble;
  bubble.radius_m = 2e-3;
  bubble.medium.liquid_viscosity_pa_s = 0.0;
  bubble.medium.liquid_sound_speed_m_s = 1e4;
  bubble.medium.gas_diffusivity_m2_s = 1e-8;  // losses of about 1e-3
  bubble.pitch.largest_factor = 100.0;        // a clamp would be a corner, which reflects 1e-4
  RiseOptions options;
  options.kind = RiseKind::kConstantSpeed;
  options.speed_m_s = 0.3;
  bubble.motion = analytic_rise({0, 0, -0.02}, bubble.radius_m, options);
  const RingTrack track = ring_track(bubble);
  double fall = 0.0, rise = 0.0;
  for (const RingBlock& block : track.blocks) {
    // Lambda's real part: -int beta - ln(w) / 2, whatever the steps.
    const double mid = block.start_s + 0.5 * block.length_s;
    if (mid > bubble.motion->breaks_s().front()) break;  // at rest, after another corner
    const double b0 = coefficients_at(bubble, block.start_s).decay_per_s, bm = coefficients_at(bubble, mid).decay_per_s,
                 b1 = coefficients_at(bubble, block.start_s + block.length_s * (1 - 1e-12)).decay_per_s;
    fall += block.length_s / 6 * (b0 + 4 * bm + b1);
    const double level = block.log_at(block.start_s + block.length_s).real() - std::log(track.amplitude_m);
    const double action = level + fall + 0.5 * std::log(block.rate_end.imag() / track.blocks.front().rate_start.imag());
    EXPECT_LE(std::abs(action), 2e-5) << mid;
    rise = std::max(rise, block.rate_end.imag() / track.blocks.front().rate_start.imag());
  }
  EXPECT_GT(rise, 1.5);
}

TEST(BubbleRing, LargeBubblesThatRiseFastStayWithinTheBar) {
  for (const double radius_m : {1e-4, 1e-2, 2e-2}) {
    RingingBubble bubble;
    bubble.radius_m = radius_m;
    bubble.pitch.phi0_m = -0.1;
    RiseOptions options;
    options.kind = RiseKind::kTerminal;
    options.speed_m_s = 0.3;
    bubble.motion = analytic_rise({0, 0, -std::max(0.012, 1.5 * radius_m)}, radius_m, options);
    expect_within_the_bar(life_error(bubble), "r " + std::to_string(1e3 * radius_m) + " mm, phi0 -100 mm");
  }
}

TEST(BubbleRing, BubbleThatJumpsIsRefused) {
  RingingBubble bubble;
  SampledMotion samples;
  samples.cutoff_hz = std::numeric_limits<double>::infinity();
  samples.positions_m = {{0, 0, -0.01}};
  for (int i = 0; i < 100; ++i) {
    samples.times_s.push_back(1e-4 * i);
    samples.phi_m.push_back(i == 30 ? -0.001 : -0.01);
  }
  bubble.motion = sampled_motion(samples);
  EXPECT_THROW(ring_track(bubble), InputError);
}

TEST(BubbleRing, LifeEndsWhereTheAmplitudeIsAThreeThousandth) {
  const RingTrack track = ring_track({});
  EXPECT_NEAR(std::abs(track.value(track.faded_from_s)) / track.amplitude_m, 1e-3, 1e-9);
  EXPECT_NEAR(std::abs(track.value(track.end_s)) / track.amplitude_m, 1.0 / 3000, 1e-9);
  EXPECT_EQ(track.value(1.01 * track.end_s), 0.0);
  EXPECT_EQ(track.value(-1e-9), 0.0);
}

TEST(RingdownFormulas, FirstOrderSolutionIsWithinItsStatedErrors) {
  const BubbleMedium medium;
  const double radius = 1.5e-3, omega = undamped_angular_frequency_rad_s(medium, BubbleTheory::kLeighton, radius);
  PitchModel pitch;
  const auto rate = [&](double t) {
    return ring_rate(medium, BubbleTheory::kLeighton, radius, omega,
                     pitch_factor(pitch, radius, -0.012 + 0.3 * t, -0.012));
  };
  std::vector<double> times, phase(30), decay(30);
  for (int i = 1; i <= 30; ++i) times.push_back(1e-3 * i);
  integrate_rates<double>(times, rate, phase, decay);
  const Eigen::MatrixXd truth = datasets::integrate_oscillator(
      [&](double t) {
        return OscillatorCoefficients{rate(t).omega0_rad_s, rate(t).decay_per_s};
      },
      rate(0.0).omega_d_rad_s, 1e-3, 1e-3, 30);
  double worst = 0.0, rise = 0.0;
  for (int i = 0; i < 30; ++i) {
    const auto now = rate(times[static_cast<std::size_t>(i)]);
    const double envelope =
        std::sqrt(rate(0.0).omega_d_rad_s / now.omega_d_rad_s) * std::exp(-decay[static_cast<std::size_t>(i)]);
    worst = std::max(worst, std::abs(truth(i, 0) - envelope * std::sin(phase[static_cast<std::size_t>(i)])) / envelope);
    rise = now.omega0_rad_s / omega;
  }
  EXPECT_GT(rise, 2.0);
  EXPECT_LE(worst, 2e-2);
  EXPECT_GT(worst, 1e-6);
}

TEST(CubicSpline, ErrorFallsAtOrderFour) {
  std::vector<double> errors;
  for (const int n : {10, 20, 40, 80}) {
    std::vector<double> t, y;
    for (int i = 0; i <= n; ++i) {
      t.push_back(static_cast<double>(i) / n);
      y.push_back(std::sin(5 * t.back()));
    }
    const CubicSpline spline(t, y);
    double worst = 0.0;
    for (int i = 0; i < 1000; ++i)
      worst = std::max(worst, std::abs(spline.at(i / 1000.0).v - std::sin(5 * i / 1000.0)));
    errors.push_back(worst);
  }
  for (std::size_t i = 1; i < errors.size(); ++i) {
    const double order = std::log2(errors[i - 1] / errors[i]);
    EXPECT_GE(order, 3.6);
    EXPECT_LE(order, 4.8);
  }
}

TEST(LowPass, TakesNoiseOutAndLeavesAStraightLine) {
  std::vector<double> t, line, noisy;
  for (int i = 0; i < 400; ++i) {
    t.push_back(5e-4 * i);
    line.push_back(-0.01 + 0.1 * t.back());
    noisy.push_back(line.back() + 1e-4 * std::cos(2 * kPi * 800.0 * t.back()));
  }
  const auto smooth = low_passed(t, noisy, 200.0), same = low_passed(t, line, 200.0);
  for (std::size_t i = 0; i < t.size(); ++i) EXPECT_NEAR(same[i], line[i], 1e-12);
  for (std::size_t i = 10; i + 10 < t.size(); ++i) EXPECT_NEAR(smooth[i], line[i], 1e-6);
}

}  // namespace
}  // namespace klang::bubble
