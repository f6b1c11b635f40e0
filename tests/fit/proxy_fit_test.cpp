#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "../soundbank/small_bank.hpp"
#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"
#include "core/soundbank/proxy.hpp"
#include "fit/proxy/proxy_cost.hpp"
#include "fit/proxy/proxy_fit.hpp"
#include "gradient_checker.hpp"

using namespace klang;

namespace {

/// The voice of an ellipsoid of the bank's own, damped.
fit::ProxyTarget ellipsoid_target(const Eigen::Vector3d& axes, double scale_m, int count) {
  const soundbank::Soundbank& bank = test::small_bank();
  soundbank::Proxy proxy;
  proxy.place = soundbank::locate(bank, soundbank::shape_point(axes));
  proxy.scale = scale_m;
  fit::ProxyTarget target;
  target.rayleigh_mass_per_s = 8.0;
  target.rayleigh_stiffness_s = 2e-8;
  for (const double hz : soundbank::proxy_frequencies_hz(bank, proxy, count)) {
    const double omega = 2.0 * kPi * hz;
    target.voice.push_back({hz, 0.5 * (8.0 + 2e-8 * omega * omega), 1e4 / omega});
  }
  return target;
}

}  // namespace

TEST(ProxyCost, GradientsAreTheDifferences) {
  const soundbank::Soundbank& bank = test::small_bank();
  const fit::ProxyFrequencies frequencies(bank, 4);
  const auto cost = fit::proxy_frequency_cost(frequencies, {9000.0, 9500.0, 11000.0, 12500.0}, bank.material.shear_speed_m_s());
  tests::expect_gradient(*cost, {{0.613, 0.377}, {-1.2}}, 1e-5, 1e-5);
}

TEST(ProxyFit, FindsAnEllipsoidFromItsPartialsAlone) {
  const Eigen::Vector3d axes = soundbank::unit_axes({-0.47, -0.21});
  fit::ProxyTarget target = ellipsoid_target(axes, 0.12, 8);
  target.rayleigh_mass_per_s = target.rayleigh_stiffness_s = 0.0;  // not given, as of a recording
  const fit::ProxyFitResult result = fit::fit_proxy(test::small_bank(), target);
  EXPECT_EQ(result.status, fit::ProxyFitStatus::kImproved) << result.message;
  EXPECT_LE(result.after.partial_rms_cents, 0.1);
  EXPECT_LE(result.after.decay_rms_percent, 0.1);
  EXPECT_LE((result.fitted.axes - axes).norm(), 1e-3);
  EXPECT_LE(std::abs(result.fitted.scale_m / 0.12 - 1.0), 1e-3);
}

TEST(ProxyFit, NoMeasureIsWorseThanBefore) {
  for (const double length : {0.12, 0.16}) {
    // Boxes by their inertia and partials that no ellipsoid has.
    fit::ProxyTarget target = ellipsoid_target(soundbank::unit_axes({-0.3, -0.1}), length, 8);
    for (std::size_t k = 0; k < target.voice.size(); ++k) target.voice[k].frequency_hz *= 1.0 + 0.02 * std::sin(7.0 * k + 100.0 * length);
    std::sort(target.voice.begin(), target.voice.end(), [](const auto& a, const auto& b) { return a.frequency_hz < b.frequency_hz; });
    target.moments = Eigen::Vector3d(2.0, 1.7, 1.4);
    fit::ProxyFitOptions options;
    options.duration_s = 0.2;
    const fit::ProxyFitResult result = fit::fit_proxy(test::small_bank(), target, options);
    EXPECT_TRUE(fit::no_worse(result.after, result.before));
    if (result.status == fit::ProxyFitStatus::kImproved) {
      EXPECT_LT(result.after.partial_rms_cents, result.before.partial_rms_cents);
    }
  }
}

TEST(ProxyFit, UltrasoundIsRefused) {
  EXPECT_THROW(fit::fit_proxy(test::small_bank(), ellipsoid_target(soundbank::unit_axes({-0.3, -0.1}), 0.01, 8)), InputError);
}

TEST(ProxyErrors, GainAndShiftAreWhatTheyAre) {
  const fit::Voice voice{{1000.0, 10.0, 0.5}, {1730.0, 20.0, 0.3}};
  fit::Voice other = voice;
  const fit::TargetSound target(voice, 2, 0.5, 48000.0);
  const fit::ProxyErrors none = target.errors(other);
  EXPECT_EQ(none.partial_rms_cents, 0.0);
  EXPECT_LE(none.log_spectral_distance_db, 1e-12);
  for (auto& p : other) p.amplitude *= 2.0;
  EXPECT_LE(std::abs(target.errors(other).loudness_difference_db - 20.0 * std::log10(2.0)), 1e-6);
  for (auto& p : other) p.frequency_hz *= std::exp2(30.0 / 1200.0);
  EXPECT_LE(std::abs(target.errors(other).partial_rms_cents - 30.0), 1e-9);
}
