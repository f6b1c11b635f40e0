#include "core/sound/stage/held_force.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/foundation/base/conventions.hpp"

namespace klang::stage {
namespace {

constexpr double kRateHz = 10000.0, kStepS = 1.0 / kRateHz;

/// One body that is held by force(t) along z, step by step.
events::EventLog held(const std::function<double(double)>& force, double begin_s, double end_s) {
  events::EventLog log;
  log.bodies = {{"body", -1}};
  for (int i = static_cast<int>(std::lround(begin_s * kRateHz)); i < std::lround(end_s * kRateHz); ++i) {
    events::Impulse impulse;
    impulse.time_s = i * kStepS;
    impulse.duration_s = kStepS;
    impulse.shape = events::PulseShape::kHeld;
    impulse.kind = events::ImpulseKind::kLasting;
    impulse.impulse_n_s = {0.0, 0.0, kStepS * force((i + 0.5) * kStepS)};
    log.impulses.push_back(impulse);
  }
  return log;
}

Eigen::VectorXd unit_push(const Eigen::Vector3d&, const Eigen::Vector3d& impulse_n_s) {
  return Eigen::VectorXd::Constant(1, impulse_n_s.z());
}

PushedModes mode(double frequency_hz, double decay_per_s) {
  return {{0}, Eigen::VectorXd::Constant(1, 2.0 * kPi * frequency_hz), Eigen::VectorXd::Constant(1, decay_per_s)};
}

/// q - f / w^2 of q'' + 2 b q' + w^2 q = f at a time, by steps of 1/20 of a step (classical Runge-Kutta) from rest before the force.
double ringing(const std::function<double(double)>& polygon, double omega, double decay, double until_s) {
  const double h = kStepS / 20.0;
  double q = 0.0, v = 0.0;
  const auto acceleration = [&](double t, double x, double u) {
    return polygon(t) - 2.0 * decay * u - omega * omega * x;
  };
  for (double t = -kStepS; t < until_s - 0.5 * h; t += h) {
    const double a1 = acceleration(t, q, v), v2 = v + 0.5 * h * a1, a2 = acceleration(t + 0.5 * h, q + 0.5 * h * v, v2);
    const double v3 = v + 0.5 * h * a2, a3 = acceleration(t + 0.5 * h, q + 0.5 * h * v2, v3), v4 = v + h * a3;
    const double a4 = acceleration(t + h, q + h * v3, v4);
    q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return q - polygon(until_s) / (omega * omega);
}

double sum_of(const std::vector<ModalImpulse>& impulses, double omega, double decay, double until_s) {
  const double damped = std::sqrt(omega * omega - decay * decay);
  double sum = 0.0;
  for (const ModalImpulse& impulse : impulses) {
    const double age = until_s - impulse.time_s;
    if (age > 0.0) sum += impulse.impulse[0] * std::exp(-decay * age) * std::sin(damped * age) / damped;
  }
  return sum;
}

TEST(HeldForce, ABodyThatRestsFromBeginToEndIsSilentToTheLastBit) {
  EXPECT_TRUE(held_impulses(held([](double) { return 9.81; }, 0.0, 0.5), 0, unit_push, mode(3000.0, 10.0)).empty());
}

TEST(HeldForce, RingsAsTheOscillatorUnderThePolygonLessItsBending) {
  // A push of 4 ms from 5 ms on; corners in the middles of the steps.
  const auto force = [](double t) {
    return t < 0.005 || t > 0.009 ? 0.0 : std::pow(std::sin(kPi * (t - 0.005) / 0.004), 2);
  };
  events::EventLog log = held(force, 0.003, 0.011);
  const auto polygon = [&](double t) {
    const double at = t * kRateHz - 0.5, first = std::floor(at), share = at - first;
    return (1.0 - share) * force((first + 0.5) * kStepS) + share * force((first + 1.5) * kStepS);
  };
  for (const double frequency_hz : {100.0, 250.0, 1000.0, 4000.0}) {
    const double omega = 2.0 * kPi * frequency_hz, decay = 40.0;
    const std::vector<ModalImpulse> impulses = held_impulses(log, 0, unit_push, mode(frequency_hz, decay));
    double worst = 0.0, largest = 0.0;
    for (const double until_s : {0.0065, 0.0072, 0.0081, 0.0115, 0.0131, 0.0172}) {
      const double expected = ringing(polygon, omega, decay, until_s);
      worst = std::max(worst, std::abs(sum_of(impulses, omega, decay, until_s) - expected));
      largest = std::max(largest, std::abs(expected));
    }
    // Drag is taken at the ends of the sides, which shows where a period is as short as two or three steps.
    EXPECT_LE(worst, (frequency_hz < 2000.0 ? 2e-3 : 2e-2) * largest) << frequency_hz;
  }
}

TEST(HeldForce, AForceThatVariesSlowlyDoesNotSingAtTheRateOfTheSteps) {
  // Sliding: 5 % of swing at 50 Hz. Played as Dirac pulses the mode at the rate of the steps grows with every step.
  const events::EventLog log = held([](double t) { return 10.0 + 0.5 * std::sin(2.0 * kPi * 50.0 * t); }, 0.0, 0.2);
  const double omega = 2.0 * kPi * kRateHz;
  const double ring = std::abs(sum_of(held_impulses(log, 0, unit_push, mode(kRateHz, 1.0)), omega, 1.0, 0.1999));
  double diracs = 0.0;
  for (const events::Impulse& impulse : log.impulses)
    diracs += impulse.impulse_n_s.z() * std::cos(omega * (0.1999 - impulse.time_s)) / omega;
  EXPECT_LE(ring, 1e-5 * std::abs(diracs));
}

TEST(HeldForce, AContactThatEndsIsHeardAndOneThatLastsToTheEndOfTheLogIsNot) {
  events::EventLog log = held([](double) { return 1.0; }, 0.0, 0.1);
  log.bodies.push_back({"other", -1});
  EXPECT_TRUE(held_impulses(log, 0, unit_push, mode(500.0, 1.0)).empty());
  events::Impulse later = log.impulses.back();  // another body is held for longer
  later.body = 1;
  later.time_s = 0.2;
  log.impulses.push_back(later);
  EXPECT_FALSE(held_impulses(log, 0, unit_push, mode(500.0, 1.0)).empty());
}

TEST(HeldForce, PointsOfOneStepAddUpAndStepsThatAreApartAreTwoContacts) {
  events::EventLog log = held([](double) { return 1.0; }, 0.01, 0.02);
  const auto half = log.impulses;
  for (events::Impulse& impulse : log.impulses) impulse.impulse_n_s *= 0.5;
  for (events::Impulse impulse : half) {
    impulse.impulse_n_s *= 0.5;
    log.impulses.push_back(impulse);
  }
  events::EventLog whole;
  whole.bodies = log.bodies;
  whole.impulses = half;
  const auto both = held_impulses(log, 0, unit_push, mode(500.0, 1.0));
  const auto one = held_impulses(whole, 0, unit_push, mode(500.0, 1.0));
  ASSERT_EQ(both.size(), one.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(both[i].impulse, one[i].impulse);
  const std::size_t n_of_one_contact = one.size();
  for (events::Impulse impulse : half) {
    impulse.time_s += 0.05;
    whole.impulses.push_back(impulse);
  }
  EXPECT_GE(held_impulses(whole, 0, unit_push, mode(500.0, 1.0)).size(), n_of_one_contact + 1);
}

TEST(HeldForce, ContactsInStepsOfDifferentLengthsDoNotShareAPolygon) {
  // A body that rests under two others, one of which is moved in steps half as long: silent, as under each alone.
  events::EventLog log = held([](double) { return 9.81; }, 0.0, 0.2);
  log.bodies = {{"body", -1}, {"first", -1}, {"second", -1}};
  for (events::Impulse& impulse : log.impulses) impulse.other = 1;
  for (int i = 0; i < std::lround(2 * 0.2 * kRateHz); ++i) {
    events::Impulse impulse = log.impulses.front();
    impulse.other = 2;
    impulse.time_s = 0.5 * i * kStepS;
    impulse.duration_s = 0.5 * kStepS;
    impulse.impulse_n_s = {0.0, 0.0, 0.5 * kStepS * 3.0};
    log.impulses.push_back(impulse);
  }
  EXPECT_TRUE(held_impulses(log, 0, unit_push, mode(3000.0, 10.0)).empty());
}

TEST(HeldForce, AConstantForceInStepsOfChangingLengthIsSilent) {
  events::EventLog log;
  log.bodies = {{"body", -1}, {"other", -1}};
  double time_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    events::Impulse impulse = held([](double) { return 1.0; }, 0.0, 0.001).impulses.front();
    impulse.other = 1;
    impulse.time_s = time_s;
    impulse.duration_s = i % 2 == 0 ? 1e-3 : 2e-3;
    impulse.impulse_n_s = {0.0, 0.0, 9.81 * impulse.duration_s};
    time_s += impulse.duration_s;
    log.impulses.push_back(impulse);
  }
  // Scaled as -(change of slope) / w^2 they stand beside what one step of the force alone would make.
  const double omega = 2.0 * kPi * 3000.0, bound = 1e-9 * (9.81 / 1e-3) / (omega * omega);
  for (const ModalImpulse& impulse : held_impulses(log, 0, unit_push, mode(3000.0, 10.0)))
    EXPECT_LE(std::abs(impulse.impulse[0]), bound);
}

}  // namespace
}  // namespace klang::stage
