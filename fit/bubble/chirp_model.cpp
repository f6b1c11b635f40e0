#include "fit/bubble/chirp_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"

namespace klang::fit::bubble {
namespace {

/// Logarithm of the attack window of HF eq. (39) and its slope, x = beta t.
struct Attack {
  double log_value = 0.0, by_x = 0.0;
};
Attack attack(double x) {
  if (x > 1.0) return {};
  const double fallen = std::exp(-x), over = fallen - klang::bubble::kAttackFall;
  if (over < 0.0) return {};
  return {-over * over / klang::bubble::kAttackWidth, 2.0 * over * fallen / klang::bubble::kAttackWidth};
}

void clamp(PitchLaw::Value& value, double max_log) {
  if (std::abs(value.log_ratio) <= max_log) return;
  value = {value.log_ratio > 0.0 ? max_log : -max_log, 0.0, Eigen::Vector2d::Zero()};
}

}  // namespace

ExponentialPitch::ExponentialPitch(double max_factor) : max_log_(std::log(max_factor)) {}

PitchLaw::Value ExponentialPitch::at(double time_s, const Eigen::Vector2d& parameters) const {
  const double rate = parameters[0], growth = parameters[1], x = growth * time_s;
  Value value;
  // (e^x - 1)/x and its derivative, by series where they cancel.
  const double f = std::abs(x) < 1e-4 ? 1.0 + x * (0.5 + x / 6.0) : std::expm1(x) / x, exponential = 1.0 + x * f;
  const double df = std::abs(x) < 1e-3 ? 0.5 + x * (1.0 / 3.0 + x / 8.0) : (exponential - f) / x;
  value.log_ratio = rate * time_s * f;
  value.by_time = rate * exponential;
  value.by_parameter = {time_s * f, rate * time_s * time_s * df};
  clamp(value, max_log_);
  return value;
}

DepthPitch::DepthPitch(std::function<double(double)> depth_m, std::function<double(double)> speed_m_s,
                       double max_factor)
    : depth_m_(std::move(depth_m)), speed_m_s_(std::move(speed_m_s)), max_log_(std::log(max_factor)) {}

PitchLaw::Value DepthPitch::at(double time_s, const Eigen::Vector2d& parameters) const {
  const double p = std::exp(parameters[0]), q = std::exp(parameters[1]);
  const double d0 = depth_m_(0.0), d = depth_m_(time_s);
  const double e0 = std::exp(-q * d0), e = std::exp(-q * d);
  Value value;
  value.log_ratio = p * (e - e0);
  value.by_time = p * q * e * speed_m_s_(time_s);
  value.by_parameter = {value.log_ratio, p * q * (-d * e + d0 * e0)};
  clamp(value, max_log_);
  return value;
}

PitchLaw::Value ChirpLaw::pitch_at(double time_s, const Eigen::Vector2d& parameters) const {
  if (!rest_s || time_s < *rest_s) return pitch->at(time_s, parameters);
  PitchLaw::Value value = pitch->at(*rest_s, parameters);
  value.by_time = 0.0;
  return value;
}

Eigen::Matrix<double, Chirp::kParameters, 1> Chirp::vector() const {
  Eigen::Matrix<double, kParameters, 1> v;
  v << pitch[0], pitch[1], onset_s, log_frequency, log_decay, cosine, sine;
  return v;
}

Chirp Chirp::from(const Eigen::Matrix<double, kParameters, 1>& v) {
  return {{v[0], v[1]}, v[2], v[3], v[4], v[5], v[6]};
}

void evaluate_chirp(const ChirpLaw& law, const Chirp& chirp, double first_s, double sample_rate_hz,
                    Eigen::Ref<Eigen::VectorXd> value, Eigen::MatrixXd* jacobian) {
  const Eigen::Index n = value.size();
  value.setZero();
  if (jacobian) jacobian->setZero(n, Chirp::kParameters);
  const double omega0 = 2.0 * kPi * std::exp(chirp.log_frequency), beta0 = std::exp(chirp.log_decay);
  const double attack_rate = law.soft_attack() ? beta0 : law.quick_attack_per_s;
  const double na = law.amplitude_exponent, m = law.decay_exponent;
  double time = 0.0, theta = 0.0, loss = 0.0;
  Eigen::Vector2d theta_p = Eigen::Vector2d::Zero(), loss_p = Eigen::Vector2d::Zero();
  struct Rates {
    PitchLaw::Value pitch;
    double omega, beta;
  };
  const auto rates = [&](double t) {
    Rates r{law.pitch_at(t, chirp.pitch), 0.0, 0.0};
    r.omega = omega0 * std::exp(r.pitch.log_ratio);
    r.beta = beta0 * std::exp(m * r.pitch.log_ratio);
    return r;
  };
  Rates left = rates(0.0);
  const auto advance = [&](double t) {
    const double step = t - time;
    const Rates middle = rates(time + 0.5 * step), right = rates(t);
    theta += step / 6.0 * (left.omega + 4.0 * middle.omega + right.omega);
    loss += step / 6.0 * (left.beta + 4.0 * middle.beta + right.beta);
    if (jacobian) {
      theta_p += step / 6.0 *
                 (left.omega * left.pitch.by_parameter + 4.0 * middle.omega * middle.pitch.by_parameter +
                  right.omega * right.pitch.by_parameter);
      loss_p += step / 6.0 * m *
                (left.beta * left.pitch.by_parameter + 4.0 * middle.beta * middle.pitch.by_parameter +
                 right.beta * right.pitch.by_parameter);
    }
    time = t;
    left = right;
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const double t = first_s + static_cast<double>(k) / sample_rate_hz - chirp.onset_s;
    if (t < 0.0) continue;
    if (law.rest_s && time < *law.rest_s && t > *law.rest_s)
      advance(*law.rest_s);  // Simpson's rule wants no corner within
    advance(t);
    const Rates& right = left;
    const Attack begin = attack(attack_rate * t);
    const double weight = std::exp(na * right.pitch.log_ratio - loss + begin.log_value);
    const double c = weight * std::cos(theta), s = weight * std::sin(theta);
    const double in_phase = chirp.cosine * c + chirp.sine * s, quadrature = -chirp.cosine * s + chirp.sine * c;
    value[k] = in_phase;
    if (jacobian) {
      auto row = jacobian->row(k);
      row.head<2>() = (in_phase * (na * right.pitch.by_parameter - loss_p) + quadrature * theta_p).transpose();
      row[2] =
          -(in_phase * (na * right.pitch.by_time - right.beta + begin.by_x * attack_rate) + quadrature * right.omega);
      row[3] = quadrature * theta;
      row[4] = in_phase * ((law.soft_attack() ? begin.by_x * beta0 * t : 0.0) - loss);
      row[5] = c;
      row[6] = s;
    }
  }
}

std::vector<ChirpPoint> chirp_track(const ChirpLaw& law, const Chirp& chirp, const std::vector<double>& times_s) {
  const double f0 = std::exp(chirp.log_frequency), beta0 = std::exp(chirp.log_decay);
  const double amplitude = std::hypot(chirp.cosine, chirp.sine);
  std::vector<ChirpPoint> track;
  double time = 0.0, loss = 0.0;
  for (const double t : times_s) {
    // Pitch changes by little within a millisecond.
    const int n = std::max(1, static_cast<int>(std::ceil((t - time) / 1e-3)));
    const double step = (t - time) / n;
    const auto beta = [&](double at) {
      return beta0 * std::exp(law.decay_exponent * law.pitch_at(at, chirp.pitch).log_ratio);
    };
    for (int i = 0; i < n; ++i)
      loss +=
          step / 6.0 * (beta(time + i * step) + 4.0 * beta(time + (i + 0.5) * step) + beta(time + (i + 1.0) * step));
    time = t;
    const double log_ratio = law.pitch_at(t, chirp.pitch).log_ratio;
    track.push_back(
        {t, f0 * std::exp(log_ratio), amplitude * std::exp(law.amplitude_exponent * log_ratio - loss), beta(t)});
  }
  return track;
}

}  // namespace klang::fit::bubble
