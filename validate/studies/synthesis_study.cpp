#include <algorithm>
#include <chrono>
#include <cmath>
#include <complex>
#include <functional>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/stage/oscillator_bank.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using Clock = std::chrono::steady_clock;
using stage::ModalImpulse;
using stage::Oscillator;

constexpr double kDuration_s = 0.25;
constexpr double kStrike_s = 0.0123456789;  // between two samples at every rate
constexpr double kContact_s = 2e-3;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// All damping regimes; frequencies below half the lowest rate.
std::vector<Oscillator> regimes() {
  const double w100 = 2.0 * kPi * 100.0;
  return {{2.0 * kPi * 440.0, 10.0, 1.0},
          {2.0 * kPi * 3690.7, 0.7, 1.0},
          {2.0 * kPi * 27.5, 32.4, 1.0},
          {w100, w100 * (1.0 - 1e-9), 1.0},
          {w100, w100, 1.0},
          {2.0 * kPi * 50.0, 6.0 * kPi * 50.0, 1.0},
          {0.0, 2.5, 1.0},
          {0.0, 0.0, 1.0}};
}

/// z(t) after a unit jump of z' at t = 0: e^(-b t) t sinc(d t), d^2 = w^2 - b^2 (sinh for d^2 < 0). Own closed form.
long double impulse_response(const Oscillator& o, long double t) {
  if (t < 0) return 0;
  const long double w = o.angular_frequency_rad_s, b = o.decay_per_s, d_sq = (w - b) * (w + b),
                    d = std::sqrt(std::abs(d_sq));
  if (d * t < 1e-4L) return std::exp(-b * t) * t * (1 - d_sq * t * t / 6);
  if (d_sq > 0) return std::exp(-b * t) * std::sin(d * t) / d;
  return (std::exp((d - b) * t) - std::exp(-(d + b) * t)) / (2 * d);
}

/// Largest |computed - exact| over the largest |exact| among samples from first on.
double relative_error(const Eigen::VectorXd& z, double rate_hz, Eigen::Index first, Eigen::Index stride,
                      const std::function<long double(long double)>& exact) {
  long double worst = 0, largest = 0;
  for (Eigen::Index i = first; i < z.size(); i += stride) {
    const long double want = exact(static_cast<long double>(i) / rate_hz);
    const long double off = std::abs(z[i] - want);
    if (!std::isnan(worst) && !(off <= worst)) worst = off;  // a NaN comes in and stays
    largest = std::max(largest, std::abs(want));
  }
  return static_cast<double>(worst / largest);
}

Eigen::VectorXd response(const Oscillator& o, const std::vector<ModalImpulse>& impulses, double rate_hz) {
  return stage::oscillation({o}, impulses, rate_hz, static_cast<Eigen::Index>(std::llround(kDuration_s * rate_hz)));
}

ModalImpulse unit_impulse(double time_s, double impulse, double contact_duration_s = 0.0) {
  return {time_s, Eigen::VectorXd::Constant(1, impulse), contact_duration_s};
}

double recurrence_error(double rate_hz) {
  double worst = 0.0;
  for (const Oscillator& o : regimes()) {
    const double error = relative_error(response(o, {unit_impulse(kStrike_s, 1.0)}, rate_hz), rate_hz, 0, 1,
                                        [&](long double t) { return impulse_response(o, t - kStrike_s); });
    if (!std::isnan(worst) && !(error <= worst)) worst = error;
  }
  return worst;
}

/// After the pulse (9 standard deviations) the response to a Gaussian force is e^(s t) e^(s^2 sigma^2 / 2), s = -b + i d.
double gaussian_error(double rate_hz) {
  constexpr double kSigma_s = 4e-4;
  double worst = 0.0;
  for (const Oscillator& o : regimes()) {
    if (!(o.decay_per_s < 0.5 * o.angular_frequency_rad_s)) continue;
    const long double d = std::sqrt(static_cast<long double>(o.angular_frequency_rad_s) * o.angular_frequency_rad_s -
                                    static_cast<long double>(o.decay_per_s) * o.decay_per_s);
    const std::complex<long double> s(-o.decay_per_s, d);
    const auto gain = std::exp(s * s * static_cast<long double>(kSigma_s * kSigma_s / 2.0));
    if (std::abs(gain) < 1e-6L) continue;  // nothing is heard of it
    const auto first = static_cast<Eigen::Index>(std::ceil((kStrike_s + 9.0 * kSigma_s) * rate_hz));
    const double error =
        relative_error(response(o, {unit_impulse(kStrike_s, 1.0, kSigma_s)}, rate_hz), rate_hz, first, 1,
                       [&](long double t) { return (std::exp(s * (t - kStrike_s)) * gain).imag() / d; });
    if (!std::isnan(worst) && !(error <= worst)) worst = error;
  }
  return worst;
}

// A contact force that is given by samples enters as one impulse f(t_k) / rate a sample (trapezoidal rule). Half a sine of
// unit area and 2 ms has corners, so the rule is of second order.
double sampled_contact_error(double rate_hz) {
  const Oscillator o{2.0 * kPi * 440.0, 10.0, 1.0};
  std::vector<ModalImpulse> train;
  const auto n = std::lround(kContact_s * rate_hz);
  for (long k = 1; k < n; ++k) {
    const double t = static_cast<double>(k) / rate_hz;
    train.push_back(unit_impulse(t, kPi / (2.0 * kContact_s) * std::sin(kPi * t / kContact_s) / rate_hz));
  }
  const long double d = std::sqrt(static_cast<long double>(o.angular_frequency_rad_s) * o.angular_frequency_rad_s -
                                  static_cast<long double>(o.decay_per_s) * o.decay_per_s);
  const std::complex<long double> s(-o.decay_per_s, d);
  const long double w = kPi / kContact_s;
  const auto spectrum = w * w / 2 * (1.0L + std::exp(-s * static_cast<long double>(kContact_s))) / (s * s + w * w);
  // Compared at the samples that every level has.
  const auto stride = static_cast<Eigen::Index>(std::lround(rate_hz / 8000.0));
  return relative_error(response(o, train, rate_hz), rate_hz, n, stride,
                        [&](long double t) { return (std::exp(s * t) * spectrum).imag() / d; });
}

/// z'' + 2 b z' + w^2 z = 0 from z = 0, z' = 1 by steps; the last 50 ms count.
double stepped_error(double rate_hz, bool central) {
  const Oscillator o{2.0 * kPi * 440.0, 10.0, 1.0};
  const double h = 1.0 / rate_hz, w_sq = o.angular_frequency_rad_s * o.angular_frequency_rad_s, b = o.decay_per_s;
  Eigen::VectorXd z(std::llround(kDuration_s * rate_hz));
  z[0] = 0.0;
  if (central) {  // Stoermer-Verlet: (z+ - 2 z + z-) / h^2 + b (z+ - z-) / h + w^2 z = 0
    z[1] = h - b * h * h + (4.0 * b * b - w_sq) * h * h * h / 6.0;
    for (Eigen::Index i = 2; i < z.size(); ++i)
      z[i] = ((2.0 - w_sq * h * h) * z[i - 1] - (1.0 - b * h) * z[i - 2]) / (1.0 + b * h);
  } else {  // symplectic Euler
    double v = 1.0;
    for (Eigen::Index i = 1; i < z.size(); ++i) {
      v += h * (-w_sq * z[i - 1] - 2.0 * b * v);
      z[i] = z[i - 1] + h * v;
    }
  }
  return relative_error(z, rate_hz, static_cast<Eigen::Index>(std::llround((kDuration_s - 0.05) * rate_hz)), 1,
                        [&](long double t) { return impulse_response(o, t); });
}

}  // namespace

/// The oscillator bank against closed forms, and beside step-by-step integrators.
Study synthesis_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "The oscillator bank against closed forms";
  study.question =
      "The sound of a strike is a sum of damped oscillators, stepped from sample to sample by the exact solution. Does "
      "it "
      "stay at round-off at every sample rate and in every damping regime, and how fast does a contact force converge "
      "that "
      "is given by samples only?";
  const std::vector<double> rates = {8000, 11025, 16000, 22050, 32000, 44100, 48000, 96000, 192000, 384000};
  const std::vector<double> doubled = {8000, 16000, 32000, 64000, 128000, 256000};
  const std::vector<double> fine = {88200, 176400, 352800, 705600, 1411200};
  const std::string closed = "closed form in extended precision";
  struct Plan {
    Series series;
    const std::vector<double>& rates;
    std::function<double(double)> error;
  };
  std::vector<Plan> plans;
  const auto add = [&](std::string id, std::string title, Convergence kind, double order, double tolerance, bool counts,
                       const std::vector<double>& at, std::function<double(double)> error) {
    if (!wanted(options, id)) return;
    Series s;
    s.id = std::move(id);
    s.title = std::move(title);
    s.reference = closed;
    s.step_words = "sample rate [Hz]";
    s.error_words = "largest error over largest response";
    s.kind = kind;
    s.expected_order = order;
    s.order_tolerance = 0.1;
    s.error_tolerance = tolerance;
    s.error_floor = 1e-12;
    s.floor_words = "round-off over 0.25 s";
    s.counts = counts;
    plans.push_back({std::move(s), at, std::move(error)});
  };
  add("sampled-contact", "Contact force given by samples (half sine, 2 ms)", Convergence::kAlgebraic, 2.0, 1e-5, true,
      doubled, sampled_contact_error);
  add("recurrence", "Exact recurrence, all damping regimes", Convergence::kRoundOff, 0.0, 1e-13, true, rates,
      recurrence_error);
  add("gaussian-contact", "Gaussian contact of 0.4 ms", Convergence::kRoundOff, 0.0, 1e-13, true, rates,
      gaussian_error);
  add("central-differences", "For comparison: central differences (Störmer-Verlet)", Convergence::kAlgebraic, 2.0, 1.0,
      false, fine, [](double rate_hz) { return stepped_error(rate_hz, true); });
  add("symplectic-euler", "For comparison: symplectic Euler", Convergence::kAlgebraic, 1.0, 1.0, false, fine,
      [](double rate_hz) { return stepped_error(rate_hz, false); });

  for (std::size_t k = 0; k < plans.size(); ++k) {
    Plan& plan = plans[k];
    const std::size_t n_levels = level_count(options, plan.rates.size());
    if (plan.series.kind == Convergence::kAlgebraic) {
      plan.series.error_tolerance *= std::pow(plan.rates.back() / plan.rates[n_levels - 1], plan.series.expected_order);
    }
    for (std::size_t i = 0; i < n_levels; ++i) {
      monitor.throw_if_stopped();
      monitor.progress(plan.series.title,
                       (static_cast<double>(k) + static_cast<double>(i) / static_cast<double>(n_levels)) /
                           static_cast<double>(plans.size()));
      const auto start = Clock::now();
      Level level;
      level.n = plan.rates[i];
      level.error = plan.error(plan.rates[i]);
      level.n_unknowns = kDuration_s * plan.rates[i];
      level.wall_time_s = seconds_since(start);
      plan.series.levels.push_back(level);
    }
    study.series.push_back(std::move(plan.series));
  }
  return study;
}

}  // namespace klang::validate
