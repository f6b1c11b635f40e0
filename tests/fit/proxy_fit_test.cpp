#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "fit/proxy/proxy_cost.hpp"
#include "fit/proxy/proxy_fit.hpp"
#include "tests/core/sound/soundbank/small_bank.hpp"
#include "tests/fit/gradient_checker.hpp"

using namespace klang;

namespace {

/// The voice of an ellipsoid of the bank's own, damped.
fit::ProxyTarget ellipsoid_target(const Eigen::Vector3d& axes, double scale_m, int count) {
  const soundbank::Soundbank& bank = test::small_bank();
  soundbank::Proxy proxy;
  proxy.place = soundbank::locate(bank, soundbank::shape_point(axes));
  proxy.scale = scale_m;
  fit::ProxyTarget target;
  target.damping = {.stiffness_s = 2e-8, .mass_per_s = 8.0};
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
  const auto cost =
      fit::proxy_frequency_cost(frequencies, {9000.0, 9500.0, 11000.0, 12500.0}, bank.material.shear_speed_m_s());
  tests::expect_gradient(*cost, {{0.613, 0.377}, {-1.2}}, 1e-5, 1e-5);
}

TEST(ProxyFrequencies, AreThoseOfTheBank) {
  const soundbank::Soundbank& bank = test::small_bank();
  const fit::ProxyFrequencies frequencies(bank, 12);
  std::vector<fit::ProxyFrequencies::Line> lines;
  for (const auto& [s, t] : {std::pair{0.9, 0.1}, {0.31, 0.77}, {0.0, 0.5}, {1.0, 1.0}}) {
    soundbank::Proxy proxy;
    proxy.place = soundbank::locate(bank, fit::shape_of_square(bank, s, t));
    const Eigen::VectorXd expected = soundbank::proxy_frequencies_hz(bank, proxy, 12);
    frequencies.lowest(proxy.place, lines);
    ASSERT_EQ(static_cast<Eigen::Index>(lines.size()), expected.size());
    for (std::size_t k = 0; k < lines.size(); ++k) {
      const double hz = std::exp(lines[k].ln_frequency) * bank.material.shear_speed_m_s() / (2.0 * kPi);
      EXPECT_LE(std::abs(hz / expected[static_cast<Eigen::Index>(k)] - 1.0), 1e-12);
    }
  }
}

TEST(ProxyFit, FindsAnEllipsoidFromItsPartialsAlone) {
  const Eigen::Vector3d axes = soundbank::unit_axes({-0.47, -0.21});
  fit::ProxyTarget target = ellipsoid_target(axes, 0.12, 8);
  target.damping = {};  // not given, as of a recording
  fit::ProxyFitOptions options;
  options.duration_s = 0.2;
  options.search.n_scan = 32;
  options.search.n_generations = 2;
  const fit::ProxyFitResult result = fit::fit_proxy(test::small_bank(), target, options);
  EXPECT_EQ(result.status, fit::ProxyFitStatus::kImproved) << result.message;
  EXPECT_LE(result.after.partial_rms_cents, 0.1);
  EXPECT_LE(result.after.decay_rms_percent, 0.1);
  EXPECT_LE((result.fitted.axes - axes).norm(), 1e-3);
  EXPECT_LE(std::abs(result.fitted.scale_m / 0.12 - 1.0), 1e-3);
}

TEST(ProxyFit, OfThreeBoxesNoMeasureIsWorseAndThePartialsAreNearer) {
  for (const Eigen::Vector3d& edges : {Eigen::Vector3d(0.16, 0.13, 0.10), {0.16, 0.11, 0.09}, {0.15, 0.10, 0.09}}) {
    mesh::ShapeMeshOptions coarse;
    coarse.max_edge_m = 0.05;
    const mesh::TetMesh box =
        mesh::mesh_shape({"box", {{"length_m", edges[0]}, {"width_m", edges[1]}, {"height_m", edges[2]}}, {}}, coarse);
    modal::EigenOptions eigen;
    eigen.count = 8;
    eigen.prove_none_missing = false;
    const modal::EigenResult modes = modal::solve_modes(box, solid::assemble(box), test::glass(), {}, eigen);
    ASSERT_TRUE(modes.usable()) << modes.message;
    fit::ProxyFitOptions options;
    options.duration_s = 0.1;
    options.n_partials = 8;
    options.search.n_scan = 200;
    options.search.n_generations = 3;
    const fit::ProxyFitResult result = fit::fit_proxy(
        test::small_bank(), fit::target_of_model(modes.model, {.stiffness_s = 1e-7, .mass_per_s = 10.0}), options);
    SCOPED_TRACE(edges[0]);
    EXPECT_TRUE(fit::no_worse(result.after, result.before));
    EXPECT_EQ(result.status, fit::ProxyFitStatus::kImproved);
    EXPECT_LT(result.after.partial_rms_cents, result.before.partial_rms_cents);
    EXPECT_LE(result.least_cents, result.after.partial_rms_cents * (1.0 + 1e-9));
    RecordProperty("before_and_after_cents", std::to_string(result.before.partial_rms_cents) + " " +
                                                 std::to_string(result.after.partial_rms_cents));
  }
}

TEST(ProxyFit, PartialsThatCannotBeHeardDoNotCountButThreeAlwaysDo) {
  fit::ProxyTarget target = ellipsoid_target(soundbank::unit_axes({-0.3, -0.1}), 0.13, 8);
  fit::ProxyFitOptions options;
  options.duration_s = 0.05;
  options.search.n_scan = 16;
  options.search.n_generations = 0;
  options.highest_hz = 0.5 * (target.voice[4].frequency_hz + target.voice[5].frequency_hz);
  const fit::ProxyFitResult found = fit::fit_proxy(test::small_bank(), target, options);
  EXPECT_EQ(found.n_partials, 5);
  target.voice[6].frequency_hz *= 1.05;
  EXPECT_EQ(fit::fit_proxy(test::small_bank(), target, options).before.partial_rms_cents,
            found.before.partial_rms_cents);
  options.highest_hz = 100.0;
  EXPECT_EQ(fit::fit_proxy(test::small_bank(), target, options).n_partials, 3);
}

TEST(ProxyFit, SameBitsOnAnyNumberOfThreads) {
  fit::ProxyTarget target = ellipsoid_target(soundbank::unit_axes({-0.3, -0.1}), 0.13, 8);
  target.moments = Eigen::Vector3d(2.0, 1.7, 1.4);
  fit::ProxyFitOptions options;
  options.duration_s = 0.05;
  options.search.n_scan = 32;
  options.search.n_generations = 2;
  set_thread_count(1);
  const fit::ProxyFitResult one = fit::fit_proxy(test::small_bank(), target, options);
  set_thread_count(3);
  const fit::ProxyFitResult three = fit::fit_proxy(test::small_bank(), target, options);
  set_thread_count(0);
  EXPECT_EQ(one.after.partial_rms_cents, three.after.partial_rms_cents);
  EXPECT_EQ(one.after.log_spectral_distance_db, three.after.log_spectral_distance_db);
  EXPECT_EQ(one.fitted.axes, three.fitted.axes);
  EXPECT_EQ(one.n_refused, three.n_refused);
}

// A cell's own shape: the proxy's power is the cell's, at the scale, in a lighter gas, of a heavier solid.
TEST(ProxyModel, RadiationIsTheCellsScaled) {
  soundbank::Soundbank bank = test::small_bank();
  for (soundbank::Cell& cell : bank.cells)
    for (soundbank::CellMode& mode : cell.modes) mode.radiated_power_w = 3.0 + mode.id.mode_class + 0.1 * mode.id.index;
  const soundbank::Cell& cell = bank.cells.front();
  const double scale = 0.2;
  fit::ProxyTarget target = ellipsoid_target(soundbank::unit_axes(cell.shape), scale, 4);
  acoustics::Medium gas = bank.medium;
  gas.density_kg_m3 *= 0.5;
  target.radiation = {gas, 4.0 * bank.material.density_kg_m3};
  const fit::ProxyModel model(bank, target, 4);
  fit::ProxyPoint point = model.at_axes(soundbank::unit_axes(cell.shape));
  const fit::Voice voice = model.voice(point, {.stiffness_s = 0.0, .mass_per_s = 8.0});
  ASSERT_EQ(voice.size(), 4U);
  for (std::size_t k = 0; k < voice.size(); ++k) {
    const double power = cell.modes[k].radiated_power_w * 0.125 / scale;
    EXPECT_LE(std::abs(voice[k].decay_per_s / (4.0 + power) - 1.0), 1e-6);
    const double pressure = std::sqrt(2.0 * gas.density_kg_m3 * gas.sound_speed_m_s * power / (4.0 * kPi));
    EXPECT_LE(std::abs(voice[k].amplitude / pressure - 1.0), 1e-6);
  }
  EXPECT_THROW(fit::ProxyModel(test::small_bank(), target, 4), InputError);  // a bank without sound
  // Solid and gas both twice as fast: the same ka at twice the frequency, P = 1/2 rho c sigma int v^2 dS twice as large.
  fit::ProxyTarget fast = target;
  fast.shear_speed_m_s = 2.0 * bank.material.shear_speed_m_s();
  fast.radiation->medium.sound_speed_m_s *= 2.0;
  for (fit::VoicePartial& partial : fast.voice) partial.frequency_hz *= 2.0;
  const fit::ProxyModel fast_model(bank, fast, 4);
  const fit::Voice fast_voice =
      fast_model.voice(fast_model.at_axes(soundbank::unit_axes(cell.shape)), {.stiffness_s = 0.0, .mass_per_s = 8.0});
  for (std::size_t k = 0; k < voice.size(); ++k)
    EXPECT_LE(std::abs((fast_voice[k].decay_per_s - 4.0) / (2.0 * (voice[k].decay_per_s - 4.0)) - 1.0), 1e-6);
  gas.sound_speed_m_s *= 1.05;
  target.radiation->medium = gas;
  EXPECT_THROW(fit::ProxyModel(bank, target, 4), InputError);
}

TEST(ProxyFit, UltrasoundIsRefused) {
  EXPECT_THROW(fit::fit_proxy(test::small_bank(), ellipsoid_target(soundbank::unit_axes({-0.3, -0.1}), 0.01, 8)),
               InputError);
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
