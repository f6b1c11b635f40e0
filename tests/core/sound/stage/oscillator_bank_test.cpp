#include "core/sound/stage/oscillator_bank.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/stage/detail/contact_pulse.hpp"
#include "core/sound/stage/detail/oscillator_response.hpp"
#include "tests/core/sound/stage/oscillator_reference.hpp"

namespace klang::stage {
namespace {

using detail::OscillatorResponse;

constexpr double kRate = 44100.0;

ModalImpulse impulse_of(double time_s, std::initializer_list<double> values, double contact_s = 0.0) {
  ModalImpulse impulse{time_s, Eigen::VectorXd(static_cast<Eigen::Index>(values.size())), contact_s};
  Eigen::Index i = 0;
  for (double v : values) impulse.impulse[i++] = v;
  return impulse;
}

// omega is not always the square root of a double: the reference gives omega^2.
Oscillator oscillator_of(const ReferenceOscillator& r) { return {std::sqrt(r.omega_sq), 0.5 * r.damping, 1.0}; }

// Rounding omega to a double turns the phase by up to omega t 1e-16; 2e-12 covers it at 15 kHz and half a
// second, and is what "exact" means below, relative to the largest value of the response.
constexpr double kExact = 2e-12;

double largest(const std::vector<double>& values) {
  double top = 0.0;
  for (double v : values) top = std::max(top, std::abs(v));
  return top;
}

TEST(OscillatorResponse, MatchesReferenceInEveryDampingRegime) {
  for (const auto& r : reference_oscillators()) {
    const OscillatorResponse response(std::sqrt(r.omega_sq), 0.5 * r.damping);
    for (std::size_t i = 0; i < r.n.size(); ++i) {
      const long double t = r.n[i] / static_cast<long double>(kRate);
      const auto h = response.impulse(t);
      EXPECT_LE(std::abs(static_cast<double>(h.z) - r.z_impulse[i]), kExact * largest(r.z_impulse)) << r.name << i;
      EXPECT_LE(std::abs(static_cast<double>(h.zd) - r.zd_impulse[i]), kExact * largest(r.zd_impulse)) << r.name << i;
      EXPECT_LE(std::abs(static_cast<double>(response.step(t)) - r.z_step[i]), kExact * largest(r.z_step))
          << r.name << i;
    }
  }
}

TEST(OscillatorResponse, OneStepMatrixMatchesReference) {
  for (const auto& r : reference_oscillators()) {
    const OscillatorResponse response(std::sqrt(r.omega_sq), 0.5 * r.damping);
    const auto h = response.impulse(1.0L / kRate);
    const double c = r.damping;
    const auto z = static_cast<double>(h.z), zd = static_cast<double>(h.zd);
    const std::array<double, 4> a = {static_cast<double>(h.zd + c * h.z), z, static_cast<double>(-r.omega_sq * h.z),
                                     zd};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LE(std::abs(a[i] - r.one_step[i]), 1e-14 * std::abs(r.one_step[i])) << r.name << " entry " << i;
    }
  }
}

TEST(OscillatorBank, ImpulseResponseMatchesReferenceInEveryDampingRegime) {
  for (const auto& r : reference_oscillators()) {
    const Eigen::VectorXd z = oscillation({oscillator_of(r)}, {impulse_of(0.0, {1.0})}, kRate, 22051);
    for (std::size_t i = 0; i < r.n.size(); ++i) {
      EXPECT_LE(std::abs(z[r.n[i]] - r.z_impulse[i]), kExact * largest(r.z_impulse)) << r.name << " n " << r.n[i];
    }
  }
}

TEST(OscillatorBank, ThreeImpulsesMatchReference) {
  // tests/reference/oscillator.json: three_impulses_440Hz
  const auto& r = reference_oscillators().front();
  const Eigen::VectorXd z = oscillation(
      {oscillator_of(r)}, {impulse_of(0.0, {1.0}), impulse_of(100 / kRate, {-0.5}), impulse_of(441 / kRate, {0.25})},
      kRate, 1001);
  EXPECT_NEAR(z[50], 2.5550665211620974e-06, 1e-16);
  EXPECT_NEAR(z[150], 6.215298175023805e-06, 1e-16);
  EXPECT_NEAR(z[500], -6.079103050782289e-05, 1e-16);
  EXPECT_NEAR(z[1000], -5.9329202052831606e-05, 1e-16);
}

TEST(OscillatorImpulse, AmplitudeHasNoFactorTwo) {
  // Errata 2: an impulse J gives J / omega_d exp(-b t) sin(omega_d t); S02 (16)-(18) print twice that.
  const double omega = 2 * kPi * 441.0;  // a quarter period is exactly 25 samples
  const Eigen::VectorXd z = oscillation({{omega, 0.0, 1.0}}, {impulse_of(0.0, {3.0})}, kRate, 101);
  EXPECT_NEAR(z[25] * omega / 3.0, 1.0, 1e-13);
  EXPECT_NEAR(z[75] * omega / 3.0, -1.0, 1e-13);
}

TEST(OscillatorBank, TenSecondsStayAtRoundOffOfTheClosedForm) {
  const double rate = 48000.0;
  for (const auto& [hz, decay] : std::vector<std::pair<double, double>>{{20.0, 0.01}, {997.0, 0.1}, {19999.0, 0.2}}) {
    const Oscillator o{2 * kPi * hz, decay, 1.0};
    const Eigen::VectorXd z = oscillation({o}, {impulse_of(0.0, {1.0})}, rate, 480001);
    const OscillatorResponse exact(o.angular_frequency_rad_s, o.decay_per_s);
    double worst = 0.0;
    for (Eigen::Index n = 0; n < z.size(); n += 7) {
      worst = std::max(worst, std::abs(z[n] - static_cast<double>(exact.impulse(n / 48000.0L).z)));
    }
    EXPECT_LE(worst * o.angular_frequency_rad_s, 1e-13) << hz;  // of the first peak
  }
}

TEST(OscillatorBank, ImpulsesBetweenSamplesAreExact) {
  const Oscillator ring{2 * kPi * 5000.0, 30.0, 2.0}, over{300.0, 900.0, -1.0}, rigid{0.0, 0.0, 0.5};
  const double time = 1234.37 / kRate;
  const Eigen::VectorXd z = oscillation({ring, over, rigid}, {impulse_of(time, {1.0, 2.0, 3.0})}, kRate, 6000);
  EXPECT_EQ(z.head(1235).cwiseAbs().maxCoeff(), 0.0);
  double worst = 0.0;
  for (Eigen::Index n = 1235; n < z.size(); ++n) {
    const long double t = n / static_cast<long double>(kRate) - time;
    long double sum = 0.0;
    const std::array<Oscillator, 3> all = {ring, over, rigid};
    for (std::size_t i = 0; i < 3; ++i) {
      const OscillatorResponse r(all[i].angular_frequency_rad_s, all[i].decay_per_s);
      sum += all[i].output_gain * static_cast<double>(i + 1) * r.impulse(t).z;
    }
    worst = std::max(worst, std::abs(z[n] - static_cast<double>(sum)));
  }
  EXPECT_LE(worst, 1e-14 * z.cwiseAbs().maxCoeff());
}

TEST(OscillatorBank, ImpulseBeforeTheFirstSampleRingsOnFromIt) {
  const Oscillator o{2 * kPi * 440.0, 10.0, 1.0};
  const Eigen::VectorXd late = oscillation({o}, {impulse_of(0.0, {1.0})}, kRate, 1000);
  const Eigen::VectorXd early = oscillation({o}, {impulse_of(-100 / kRate, {1.0})}, kRate, 900);
  EXPECT_LE((early - late.tail(900)).cwiseAbs().maxCoeff(), 1e-15 * late.cwiseAbs().maxCoeff() + 1e-18);
}

// After the pulse the motion is the impulse response times the transform of the pulse at the pole: for a
// Gaussian Re(... exp(p (t - t0) + p^2 s^2 / 2)) / omega_d, p = -b + i omega_d.
TEST(ContactPulse, AfterItTheResponseIsScaledByTheGaussiansTransform) {
  for (double s : {1e-6, 8e-6, 40e-6, 300e-6, 1.3e-3}) {
    for (double hz : {50.0, 1200.0, 9000.0}) {
      const Oscillator o{2 * kPi * hz, 12.0, 1.0};
      const double t0 = 0.03 + 0.3 / kRate;
      const Eigen::VectorXd z = oscillation({o}, {impulse_of(t0, {1.0}, s)}, kRate, 8000);
      const double wd = std::sqrt(o.angular_frequency_rad_s * o.angular_frequency_rad_s - 144.0);
      // In extended precision: a double loses 4e-13 rad of the phase at 9 kHz.
      const std::complex<long double> p(
          -12.0L, std::sqrt(static_cast<long double>(o.angular_frequency_rad_s) * o.angular_frequency_rad_s - 144.0L));
      double worst = 0.0;
      for (Eigen::Index n = static_cast<Eigen::Index>((t0 + 9 * s) * kRate) + 2; n < z.size(); ++n) {
        const long double t = n / static_cast<long double>(kRate) - t0;
        const long double exact = std::exp(p * t + p * p * (0.5L * s * s)).imag() / p.imag();
        worst = std::max(worst, std::abs(z[n] - static_cast<double>(exact)));
      }
      EXPECT_LE(worst * wd, 1e-13) << "s " << s << " hz " << hz;  // of the peak of a Dirac pulse
    }
  }
}

TEST(ContactPulse, DuringItARigidBodyFollowsTheGaussiansDoubleIntegral) {
  const double s = 0.5e-3, t0 = 0.02;
  const Eigen::VectorXd z = oscillation({{0.0, 0.0, 1.0}}, {impulse_of(t0, {2.0}, s)}, kRate, 2000);
  double worst = 0.0;
  for (Eigen::Index n = 0; n < z.size(); ++n) {
    const double u = (n / kRate - t0) / s;
    const double exact =
        2.0 * s * (u * 0.5 * std::erfc(-u / std::sqrt(2.0)) + std::exp(-0.5 * u * u) / std::sqrt(2 * kPi));
    worst = std::max(worst, std::abs(z[n] - exact));
  }
  EXPECT_LE(worst, 1e-13 * z.maxCoeff());
}

TEST(ContactPulse, NearCriticalDampingIsContinuous) {
  const double omega = 600.0, s = 0.4e-3;
  const auto at = [&](double decay) {
    return oscillation({{omega, decay, 1.0}}, {impulse_of(0.01, {1.0}, s)}, kRate, 1500);
  };
  const Eigen::VectorXd below = at(omega * (1 - 1e-12)), critical = at(omega), above = at(omega * (1 + 1e-12));
  EXPECT_LE((below - critical).cwiseAbs().maxCoeff(), 1e-11 * critical.maxCoeff());
  EXPECT_LE((above - critical).cwiseAbs().maxCoeff(), 1e-11 * critical.maxCoeff());
}

TEST(ContactPulse, BecomesADiracPulseAsItGetsShorter) {
  const Oscillator o{2 * kPi * 3000.0, 20.0, 1.0};
  const Eigen::VectorXd hard = oscillation({o}, {impulse_of(0.0101, {1.0})}, kRate, 2000);
  double before = 1.0;
  for (double s : {4e-6, 2e-6, 1e-6}) {  // error (omega s)^2 / 2
    const Eigen::VectorXd soft = oscillation({o}, {impulse_of(0.0101, {1.0}, s)}, kRate, 2000);
    const double error = (soft - hard).tail(1500).cwiseAbs().maxCoeff() / hard.cwiseAbs().maxCoeff();
    const double expected = 0.5 * std::pow(o.angular_frequency_rad_s * s, 2);
    EXPECT_NEAR(error / expected, 1.0, 0.05);
    EXPECT_LT(error, before);
    before = error;
  }
}

TEST(ContactPulse, BendingUnderASlowForceIsNotHeardAndTheRingIs) {
  const Oscillator o{2 * kPi * 8000.0, 30.0, 1.0};
  const auto motion_and_ringing = [&](double s) {
    const std::vector<ModalImpulse> blow = {impulse_of(0.01, {1.0}, s)};
    return std::make_pair(oscillation({o}, blow, kRate, 2000), oscillation({o}, blow, kRate, 2000, Heard::kRinging));
  };
  const Eigen::Index after = 480 + 60;
  for (const double s : {5e-6, 2e-5, 4e-5, 1e-4}) {
    const auto [motion, ringing] = motion_and_ringing(s);
    const double largest = motion.cwiseAbs().maxCoeff();
    EXPECT_LE((motion - ringing).tail(2000 - after).cwiseAbs().maxCoeff(), 1e-5 * largest) << s;
    EXPECT_TRUE(ringing.allFinite());
  }
  // omega s = 5: the force is f / omega^2 in the motion, of which (f'' + ...) / omega^4, 1.5 / (omega s)^2, is left.
  const auto [motion, ringing] = motion_and_ringing(1e-4);
  EXPECT_NEAR(motion.cwiseAbs().maxCoeff() * std::pow(o.angular_frequency_rad_s, 2) * 1e-4 * std::sqrt(2 * kPi), 1.0,
              0.1);
  EXPECT_LE(ringing.cwiseAbs().maxCoeff(), 0.08 * motion.cwiseAbs().maxCoeff());
  // omega s = 0.25: nearly all of its spectrum reaches the mode, which is heard as it moves.
  const auto [fast, fast_ringing] = motion_and_ringing(5e-6);
  EXPECT_LE((fast - fast_ringing).cwiseAbs().maxCoeff(), 0.05 * fast.cwiseAbs().maxCoeff());
}

struct RandomBank {
  std::vector<Oscillator> oscillators;
  std::vector<ModalImpulse> impulses;
};

RandomBank random_bank(std::size_t n_modes) {
  RandomStream random(7, 0);
  RandomBank bank;
  for (std::size_t i = 0; i < n_modes; ++i) {
    bank.oscillators.push_back({2 * kPi * random.uniform(30.0, 15000.0), random.uniform(0.5, 200.0), random.normal()});
  }
  for (int k = 0; k < 5; ++k) {
    ModalImpulse impulse{random.uniform(0.0, 0.2), Eigen::VectorXd(static_cast<Eigen::Index>(n_modes)),
                         k % 2 ? 2e-4 : 0.0};
    for (Eigen::Index i = 0; i < impulse.impulse.size(); ++i) impulse.impulse[i] = random.normal();
    bank.impulses.push_back(std::move(impulse));
  }
  return bank;
}

TEST(OscillatorBank, SameBitsOnAnyNumberOfThreads) {
  const RandomBank bank = random_bank(1300);  // more than one wave of chunks
  set_thread_count(1);
  const Eigen::VectorXd one = oscillation(bank.oscillators, bank.impulses, kRate, 10000);
  set_thread_count(0);
  const Eigen::VectorXd many = oscillation(bank.oscillators, bank.impulses, kRate, 10000);
  ASSERT_GT(one.cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((one - many).cwiseAbs().maxCoeff(), 0.0);
}

TEST(OscillatorBank, ManyStrikesSuperpose) {
  const RandomBank bank = random_bank(70);
  const Eigen::VectorXd all = oscillation(bank.oscillators, bank.impulses, kRate, 9001);
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(9001);
  for (const auto& impulse : bank.impulses) sum += oscillation(bank.oscillators, {impulse}, kRate, 9001);
  EXPECT_LE((all - sum).cwiseAbs().maxCoeff(), 1e-13 * all.cwiseAbs().maxCoeff());
}

TEST(OscillatorBank, LongSilenceCostsNothingAndStaysFinite) {
  // Decays to below the smallest double within the sound: must end in zeros, not in subnormals or NaN.
  const Eigen::VectorXd z =
      oscillation({{2 * kPi * 1000.0, 5000.0, 1.0}, {10.0, 4e5, 1.0}}, {impulse_of(0.0, {1.0, 1e-5})}, kRate, 100000);
  EXPECT_TRUE(z.allFinite());
  EXPECT_EQ(z.cwiseAbs().minCoeff(), 0.0);
}

TEST(OscillatorBank, BadInputIsNamed) {
  const Oscillator good{100.0, 1.0, 1.0};
  const double nan = std::nan("");
  EXPECT_THROW(oscillation({{nan, 1.0, 1.0}}, {impulse_of(0.0, {1.0})}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({{100.0, -1.0, 1.0}}, {impulse_of(0.0, {1.0})}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(0.0, {1.0, 2.0})}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(nan, {1.0})}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(0.0, {nan})}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(0.0, {1.0}, -1.0)}, kRate, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(0.0, {1.0})}, 0.0, 10), InputError);
  EXPECT_THROW(oscillation({good}, {impulse_of(0.0, {1.0})}, kRate, -1), InputError);
}

TEST(OscillatorBank, NothingInGivesSilence) {
  EXPECT_EQ(oscillation({}, {}, kRate, 10).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(oscillation({{100.0, 1.0, 1.0}}, {impulse_of(5.0, {1.0})}, kRate, 10).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ(oscillation({{100.0, 1.0, 1.0}}, {impulse_of(0.0, {1.0})}, kRate, 0).size(), 0);
}

}  // namespace
}  // namespace klang::stage
