#include "core/sound/stage/detail/oscillator_response.hpp"

#include <cmath>

namespace klang::stage::detail {
namespace {

// Below this |delta t|^2 four terms of the series leave 1e-21.
constexpr long double kSeriesLimit = 1e-4L;

}  // namespace

OscillatorResponse::OscillatorResponse(double angular_frequency_rad_s, double decay_per_s)
    : decay_(decay_per_s),
      omega_sq_(static_cast<long double>(angular_frequency_rad_s) * angular_frequency_rad_s),
      // As a product: the difference of the squares loses every digit near critical damping.
      delta_sq_((static_cast<long double>(angular_frequency_rad_s) - decay_per_s) *
                (static_cast<long double>(angular_frequency_rad_s) + decay_per_s)) {}

OscillatorResponse::Impulse OscillatorResponse::impulse(long double t) const {
  const long double x = delta_sq_ * t * t;
  if (std::abs(x) < kSeriesLimit) {
    const long double sinc = 1 - x / 6 * (1 - x / 20 * (1 - x / 42 * (1 - x / 72)));
    const long double cosine = 1 - x / 2 * (1 - x / 12 * (1 - x / 30 * (1 - x / 56)));
    const long double envelope = std::exp(-decay_ * t);
    return {envelope * t * sinc, envelope * (cosine - decay_ * t * sinc)};
  }
  if (x > 0) {
    const long double delta = std::sqrt(delta_sq_);
    const long double envelope = std::exp(-decay_ * t);
    const long double sine = std::sin(delta * t) / delta;
    return {envelope * sine, envelope * (std::cos(delta * t) - decay_ * sine)};
  }
  // Over-damped: two real poles; the slow one from the product of the roots, the difference from expm1.
  const long double gamma = std::sqrt(-delta_sq_);
  const long double fast = decay_ + gamma;
  const long double slow = omega_sq_ / fast;
  const long double slow_decay = std::exp(-slow * t);
  const long double one_minus_ratio = -std::expm1(-2 * gamma * t);
  const long double z = slow_decay * one_minus_ratio / (2 * gamma);
  return {z, slow_decay - fast * z};
}

long double OscillatorResponse::step(long double t) const {
  // H'' + c H' + omega^2 H = 1 by its power series where the closed form would cancel.
  const long double c = damping();
  if (std::sqrt(omega_sq_) * t < 0.5L && c * t < 0.5L) {
    long double before = 0, term = t * t / 2, sum = term;  // a_n t^n
    for (int n = 3; n < 60 && std::abs(term) > 1e-25L * std::abs(sum); ++n) {
      const long double next =
          -(c * t * term / n + omega_sq_ * t * t * before / (static_cast<long double>(n) * (n - 1)));
      before = term;
      term = next;
      sum += term;
    }
    return sum;
  }
  const Impulse r = impulse(t);
  if (omega_sq_ * t < 1e-6L * c) {
    // Nearly rigid and strongly damped: h + c H + omega^2 int H = t; the last term is tiny, so one correction
    // is exact to (omega^2 t / c)^2.
    const long double first = (t - r.z) / c;
    const long double area = (t * t / 2 - first) / c;  // int H where omega = 0
    return (t - r.z - omega_sq_ * area) / c;
  }
  return (1 - r.zd - c * r.z) / omega_sq_;
}

}  // namespace klang::stage::detail
