#include "core/physics/bubble/bubble_ring.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_formulas.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;

constexpr double kFadeFrom = 6.907755278982137;  // ln 1000
constexpr double kFadeTo = 8.006367567650246;    // ln 3000
constexpr double kLargestPitchStep = 0.02;       // of the frequency, in a block
constexpr double kBlockError = 3e-7;             // of Lambda, in a block
constexpr double kShortestBlockS = 2e-5;
constexpr double kFastestChange =
    0.2;  // of the frequency and its slope, a radian: beyond, there is no slowly varying solution

struct Rate {
  Complex lambda, slope;
  Taylor omega0;
  double decay_per_s = 0.0;
};

class RateOfAge {
 public:
  explicit RateOfAge(const RingingBubble& bubble)
      : bubble_(bubble), omega_inf_(undamped_angular_frequency_rad_s(bubble.medium, bubble.theory, bubble.radius_m)) {
    constant_ = bubble.pitch.kind == PitchKind::kConstant || !bubble.motion;
    if (!constant_) phi_start_ = bubble.motion->phi_m(0.0).v;
  }
  bool constant() const { return constant_; }

  /// At a moment; at a corner of the motion the side is chosen by nudging the age.
  Rate at(double age_s) const {
    Taylor omega0(omega_inf_);
    if (!constant_) {
      const Taylor phi = bubble_.motion->phi_m(age_s);
      omega0 = omega0 * pitch_factor(bubble_.pitch, Taylor(bubble_.radius_m), phi, Taylor(phi_start_));
    }
    const Taylor beta = bubble_damping(bubble_.medium, bubble_.theory, Taylor(bubble_.radius_m), omega0).decay_per_s;
    const Taylor w0 = sqrt(omega0 * omega0 - beta * beta);
    const double first = (w0.d - 0.5 * beta.dd / w0.v) / w0.v, second = w0.dd / w0.v;  // W'/W, W''/W
    const double per_radian = std::max(std::abs(first) / w0.v, std::abs(second) / (w0.v * w0.v));
    if (!(per_radian <= kFastestChange)) {
      throw InputError(
          "bubble", "its distance to the surface changes too fast for a pitch, at the age of " + to_text(age_s) + " s",
          to_text(per_radian) + " of the frequency a radian", "up to " + to_text(kFastestChange));
    }
    const double w = w0.v - 0.5 * beta.d / w0.v + 0.5 * (0.75 * first * first - 0.5 * second) / w0.v;
    Rate rate;
    rate.lambda = {-beta.v - 0.5 * first, w};
    rate.slope = {-beta.d - 0.5 * (second - first * first), w0.d};
    rate.omega0 = omega0;
    rate.decay_per_s = beta.v;
    return rate;
  }

 private:
  const RingingBubble& bubble_;
  double omega_inf_, phi_start_ = 0.0;
  bool constant_ = true;
};

// Error of the block's integral of lambda, from how far its cubic is off in the middle: for a cubic Hermite of a smooth
// function (h^5 / 720) / (h^4 / 384) of that.
double block_error(const Rate& a, const Rate& middle, const Rate& b, double length) {
  const Complex cubic = 0.5 * (a.lambda + b.lambda) + 0.125 * length * (a.slope - b.slope);
  return 384.0 / 720.0 * length * std::abs(middle.lambda - cubic);
}

bool is_flat(const Rate& rate) { return rate.omega0.d == 0.0 && rate.omega0.dd == 0.0; }

// The last moment before the pitch stops changing or begins to (a clamp), or 0 when it does neither between two ages.
double switch_s(const RateOfAge& rates, double from_s, double to_s, const Rate& from, const Rate& to) {
  if (is_flat(from) == is_flat(to)) return 0.0;
  while (std::nextafter(from_s, to_s) < to_s) {
    const double middle = 0.5 * (from_s + to_s);
    if (!(middle > from_s && middle < to_s)) break;
    (is_flat(rates.at(middle)) == is_flat(from) ? from_s : to_s) = middle;
  }
  return from_s;
}

// Lambda's coefficients from lambda and its slope at both ends (cubic Hermite, integrated).
RingBlock make_block(double start_s, double length, Complex log_start, const Rate& a, const Rate& b) {
  const Complex mean = (b.lambda - a.lambda) / length;
  RingBlock block{start_s, length, log_start, a.lambda, 0.5 * a.slope, {}, {}, a.lambda, b.lambda};
  block.c3 = (3.0 * mean - 2.0 * a.slope - b.slope) / (3.0 * length);
  block.c4 = (a.slope + b.slope - 2.0 * mean) / (4.0 * length * length);
  return block;
}

// The same q and q' with another rate: Re Z and Re(lambda Z) are carried over.
Complex carried_over(Complex log_z, Complex before, Complex after) {
  const double angle = log_z.imag(), re = std::cos(angle), im = std::sin(angle);
  const double velocity = before.real() * re - before.imag() * im;
  return Complex(log_z.real(), 0.0) + std::log(Complex(re, (after.real() * re - velocity) / after.imag()));
}

}  // namespace

void RingOptions::validate() const { validate_fields("ring", *this); }

RingTrack ring_track(const RingingBubble& bubble, const RingOptions& options) {
  options.validate();
  bubble.medium.validate();
  bubble.pitch.validate();
  checked("bubble", "radius_m", bubble.radius_m, kSmallestRadiusM, kLargestRadiusM);
  if (!std::isfinite(bubble.onset_velocity_m_s) || bubble.onset_velocity_m_s == 0.0)
    throw InputError("bubble", "is not hit", to_text(bubble.onset_velocity_m_s) + " m/s", "finite, not 0");
  const RateOfAge rates(bubble);
  std::vector<double> corners = rates.constant() ? std::vector<double>{} : bubble.motion->breaks_s();
  corners.push_back(options.longest_life_s);
  // Data may turn within a sample of theirs.
  const double longest =
      rates.constant() ? options.longest_block_s
                       : std::min(options.longest_block_s, std::max(bubble.motion->time_scale_s(), kShortestBlockS));

  RingTrack track;
  Rate now = rates.at(0.0);
  track.decay_start_per_s = now.decay_per_s;
  track.amplitude_m = std::abs(bubble.onset_velocity_m_s) / now.lambda.imag();
  // q = 0, q' = v: Z = -i v / w
  Complex log_z(std::log(track.amplitude_m), bubble.onset_velocity_m_s < 0.0 ? 0.5 * kPi : -0.5 * kPi);
  const double log_first = log_z.real();
  double age = 0.0, wanted = rates.constant() ? longest : 0.2 * longest;
  std::size_t corner = 0;
  while (corner < corners.size() && corners[corner] <= 0.0) ++corner;
  while (corner < corners.size()) {
    const double left = corners[corner] - age;
    double length = std::min(wanted, longest), error = 0.0;
    bool to_corner = false;
    Rate next;
    for (;;) {
      to_corner = length > 0.75 * left;
      if (to_corner) length = left;
      // The side before a corner is meant at its end.
      next = rates.at(to_corner ? std::nextafter(corners[corner], 0.0) : age + length);
      if (rates.constant()) break;
      error = block_error(now, rates.at(age + 0.5 * length), next, length);
      const bool fine =
          std::abs(next.omega0.v - now.omega0.v) <= kLargestPitchStep * now.omega0.v && error <= kBlockError;
      if (fine || length <= kShortestBlockS) break;
      length *= 0.5;
    }
    wanted = length * std::clamp(0.9 * std::pow(kBlockError / std::max(error, 1e-300), 0.2), 0.3, 3.0);
    const double switched = switch_s(rates, age, age + length, now, next);
    const bool at_switch = switched > age + 1e-3 * kShortestBlockS;
    if (at_switch) {
      length = switched - age;
      to_corner = false;
      next = rates.at(switched);
    }
    track.blocks.push_back(make_block(age, length, log_z, now, next));
    age = to_corner ? corners[corner] : age + length;
    const double before = log_z.real();
    log_z = track.blocks.back().log_at(track.blocks.back().start_s + length);
    const auto reached = [&](double fall) {  // where the level crosses log_first - fall, in this block
      return age - length * (log_first - fall - log_z.real()) / (before - log_z.real());
    };
    if (track.faded_from_s == 0.0 && log_z.real() <= log_first - kFadeFrom) track.faded_from_s = reached(kFadeFrom);
    if (log_z.real() <= log_first - kFadeTo) {
      track.end_s = reached(kFadeTo);
      return track;
    }
    if (to_corner) ++corner;
    if (to_corner || at_switch) {
      const Rate after = rates.at(std::nextafter(age, 2.0 * age));
      log_z = carried_over(log_z, next.lambda, after.lambda);
      next = after;
    }
    now = next;
  }
  track.end_s = age;
  if (track.faded_from_s == 0.0) track.faded_from_s = 0.98 * age;
  return track;
}

const RingBlock& RingTrack::block_at(double age_s) const {
  KLANG_CHECK(!blocks.empty(), "a track has blocks");
  const auto after = std::upper_bound(blocks.begin() + 1, blocks.end(), age_s,
                                      [](double age, const RingBlock& block) { return age < block.start_s; });
  return *std::prev(after);
}

std::complex<double> RingTrack::value(double age_s) const {
  if (!(age_s >= 0.0) || age_s > end_s) return {};
  return std::exp(block_at(age_s).log_at(age_s));
}

}  // namespace klang::bubble
