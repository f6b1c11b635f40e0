#pragma once
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "core/physics/bubble/bubble_formulas.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::tests {

/// A bubble that rises at an even speed towards the surface, HF eq. (6).
struct Drop {
  double radius_m = 0.002, onset_s = 0.05, depth_m = 0.012, speed_m_s = 0.2, level = 1.0;
  double k_per_m = 72.95, eta = 1.24, phi0_m = 0.01;

  double depth(double since_s) const { return depth_m - speed_m_s * since_s; }
  double log_ratio(double since_s) const {
    const double q = eta / phi0_m;
    return k_per_m * std::exp(eta) / q * (std::exp(-q * depth(since_s)) - std::exp(-q * depth_m));
  }
  double frequency_hz(double since_s) const {
    const double omega0 = omega(since_s), beta = decay_per_s(since_s);
    return std::sqrt(omega0 * omega0 - beta * beta) / (2.0 * kPi);
  }
  double omega(double since_s) const {
    return bubble::undamped_angular_frequency_rad_s(bubble::BubbleMedium{}, bubble::BubbleTheory::kLeighton, radius_m) *
           std::exp(log_ratio(since_s));
  }
  double decay_per_s(double since_s) const {
    return bubble::bubble_damping(bubble::BubbleMedium{}, bubble::BubbleTheory::kLeighton, radius_m, omega(since_s))
        .decay_per_s;
  }
};

/// The drops' sound: q'' + 2 beta q' + omega^2 q = 0 after a blow, by Runge and Kutta's rule in eight steps per sample; pressure
/// omega^2 q under the soft attack of HF eq. (39); white noise snr_db below the power of the first e-folding of the weakest
/// drop's envelope.
inline audio::Signal drop_sound(const std::vector<Drop>& drops, double duration_s, double rate, double snr_db,
                                unsigned seed) {
  audio::Signal signal;
  signal.sample_rate_hz = rate;
  signal.origin = "synthetic drops";
  const auto n = static_cast<Eigen::Index>(duration_s * rate);
  signal.samples = Eigen::MatrixXd::Zero(n, 1);
  double weakest = 1e300;
  for (const Drop& drop : drops) {
    double q = 0.0, v = drop.omega(0.0) * drop.level, x_blend = drop.decay_per_s(0.0), power = 0.0;
    const double scale = 1.0 / std::pow(drop.omega(0.0), 2);
    const auto first = static_cast<Eigen::Index>(std::ceil(drop.onset_s * rate));
    int n_power = 0;
    double since = 0.0;
    const auto slope = [&](double t, double q1, double v1) {
      const double w = drop.omega(t), b = drop.decay_per_s(t);
      return -2.0 * b * v1 - w * w * q1;
    };
    for (Eigen::Index i = first; i < n; ++i) {
      const double until = static_cast<double>(i) / rate - drop.onset_s;
      if (until * x_blend > 9.0 || drop.depth(until) < drop.radius_m) break;
      const int steps = 8;
      const double h = (until - since) / steps;
      for (int s = 0; s < steps; ++s) {
        const double t = since + s * h;
        const double q1 = v, v1 = slope(t, q, v);
        const double q2 = v + 0.5 * h * v1, v2 = slope(t + 0.5 * h, q + 0.5 * h * q1, v + 0.5 * h * v1);
        const double q3 = v + 0.5 * h * v2, v3 = slope(t + 0.5 * h, q + 0.5 * h * q2, v + 0.5 * h * v2);
        const double q4 = v + h * v3, v4 = slope(t + h, q + h * q3, v + h * v3);
        q += h / 6.0 * (q1 + 2.0 * q2 + 2.0 * q3 + q4);
        v += h / 6.0 * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
      }
      since = until;
      const double e = std::exp(-x_blend * until);
      const double blend = e >= 0.85 ? std::exp(-(e - 0.85) * (e - 0.85) / 0.0028125) : 1.0;
      const double p = std::pow(drop.omega(until), 2) * q * scale * blend;
      signal.samples(i, 0) += p;
      if (until * x_blend < 1.0) {
        power += p * p;
        ++n_power;
      }
    }
    weakest = std::min(weakest, power / n_power);
  }
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, std::sqrt(weakest) * std::pow(10.0, -snr_db / 20.0));
  for (Eigen::Index i = 0; i < n; ++i) signal.samples(i, 0) += normal(random);
  return signal;
}

}  // namespace klang::tests
