#include "core/sound/stage/detail/contact_pulse.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::stage::detail {
namespace {

constexpr double kReach = 8.5;  // standard deviations

// Gauss-Legendre on [-1, 1], 10 points (Abramowitz & Stegun 25.4.30), positive half.
constexpr std::array<double, 5> kAbscissae = {0.148874338981631211, 0.433395394129247191, 0.679409568299024406,
                                              0.865063366688984511, 0.973906528517171720};
constexpr std::array<double, 5> kWeights = {0.295524224714752870, 0.269266719309996355, 0.219086362515982044,
                                            0.149451349150580593, 0.066671344308688138};

struct Point {
  double offset_s, weight_s;
};

void add_panel(double begin_s, double end_s, std::vector<Point>& points) {
  const double middle = 0.5 * (begin_s + end_s), half = 0.5 * (end_s - begin_s);
  for (std::size_t i = 0; i < kAbscissae.size(); ++i) {
    points.push_back({middle - half * kAbscissae[i], half * kWeights[i]});
    points.push_back({middle + half * kAbscissae[i], half * kWeights[i]});
  }
}

std::vector<Point> panels(double begin_s, double end_s, double longest_s) {
  std::vector<Point> points;
  const auto n = static_cast<int>(std::ceil((end_s - begin_s) / longest_s));
  for (int i = 0; i < n; ++i) {
    add_panel(begin_s + (end_s - begin_s) * i / n, begin_s + (end_s - begin_s) * (i + 1) / n, points);
  }
  return points;
}

// Gauss-Legendre on [0, 1], 6 points (Abramowitz & Stegun 25.4.30).
constexpr std::array<double, 6> kNodes = {0.033765242898423989, 0.169395306766867743, 0.380690406958401546,
                                          0.619309593041598454, 0.830604693233132257, 0.966234757101576011};
constexpr std::array<double, 6> kNodeWeights = {0.085662246189585173, 0.180380786524069304, 0.233956967286345524,
                                                0.233956967286345524, 0.180380786524069304, 0.085662246189585173};

/// Lagrange's polynomials of the nodes at a place of [0, 1].
std::array<double, 6> lagrange(double x) {
  std::array<double, 6> value{};
  for (std::size_t j = 0; j < kNodes.size(); ++j) {
    value[j] = 1.0;
    for (std::size_t k = 0; k < kNodes.size(); ++k)
      if (k != j) value[j] *= (x - kNodes[k]) / (kNodes[j] - kNodes[k]);
  }
  return value;
}

}  // namespace

ContactPulse::ContactPulse(const ForceHistory& history, double sample_rate_hz) : step_s_(1.0L / sample_rate_hz) {
  const double step = static_cast<double>(step_s_);
  const std::vector<double>& force = history.force_per_s;
  const auto n_sides = static_cast<double>(force.size()) - 1.0;
  first_sample_ = static_cast<long>(std::floor(history.begin_s * sample_rate_hz));
  const long last = static_cast<long>(std::ceil((history.begin_s + n_sides * history.step_s) * sample_rate_hz));
  std::vector<double>& left = rules_.emplace_back();
  for (const double node : kNodes) left.push_back(step * (1.0 - node));
  for (long n = first_sample_; n < last; ++n) {
    Step weights{0, std::vector<double>(kNodes.size(), 0.0)};
    // In steps of the history, from its begin: the part of it that lies in this sample step, side by side.
    const double begin = (static_cast<double>(n * step_s_) - history.begin_s) / history.step_s;
    const double width = step / history.step_s, end = std::min(begin + width, n_sides);
    for (double from = std::max(begin, 0.0); from < end;) {
      const double side = std::floor(from), to = std::min(side + 1.0, end);
      const auto k = static_cast<std::size_t>(side);
      for (std::size_t g = 0; g < kNodes.size(); ++g) {
        const double at = from + (to - from) * kNodes[g];
        const double value = force[k] + (at - side) * (force[k + 1] - force[k]);
        const auto basis = lagrange((at - begin) / width);
        for (std::size_t j = 0; j < basis.size(); ++j)
          weights.weights[j] += value * basis[j] * kNodeWeights[g] * (to - from) * history.step_s;
      }
      from = to;
    }
    steps_.push_back(std::move(weights));
  }
  find_moments();
}

ContactPulse::ContactPulse(double time_s, double standard_deviation_s, double sample_rate_hz)
    : step_s_(1.0L / sample_rate_hz) {
  const double step = static_cast<double>(step_s_);
  const double s = standard_deviation_s;
  first_sample_ = static_cast<long>(std::floor((time_s - kReach * s) * sample_rate_hz));
  const long last = static_cast<long>(std::ceil((time_s + kReach * s) * sample_rate_hz));
  // A pulse of many samples uses the same points in every step; a short one only where the force is.
  const bool same_points = s >= 0.25 * step;
  std::vector<Point> points;
  if (same_points) points = panels(0.0, step, s);
  for (long n = first_sample_; n < last; ++n) {
    const double from_centre = static_cast<double>(n * step_s_ - time_s);
    if (!same_points) {
      const double begin = std::max(0.0, -kReach * s - from_centre), end = std::min(step, kReach * s - from_centre);
      points = begin < end ? panels(begin, end, s) : std::vector<Point>{};
    }
    if (!same_points || rules_.empty()) {
      std::vector<double> left;
      for (const Point& p : points) left.push_back(step - p.offset_s);
      rules_.push_back(std::move(left));
    }
    Step step_weights{rules_.size() - 1, {}};
    for (const Point& p : points) {
      const double u = (from_centre + p.offset_s) / s;
      step_weights.weights.push_back(std::exp(-0.5 * u * u) / (s * std::sqrt(2.0 * kPi)) * p.weight_s);
    }
    steps_.push_back(std::move(step_weights));
  }
  find_moments();
}

void ContactPulse::find_moments() {
  const double step = static_cast<double>(step_s_);
  double moment = 0.0;
  for (std::size_t n = 0; n < steps_.size(); ++n) {
    double area = 0.0, first = 0.0;
    for (std::size_t i = 0; i < steps_[n].weights.size(); ++i) {
      area += steps_[n].weights[i];
      first += steps_[n].weights[i] * (static_cast<double>(n + 1) * step - rules_[steps_[n].rule][i]);
    }
    step_area_.push_back(area);
    step_time_s_.push_back(area != 0.0 ? first / area : (static_cast<double>(n) + 0.5) * step);
    area_ += area;
    moment += first;
  }
  centre_s_ = area_ != 0.0 ? moment / area_ : 0.0;
}

double ContactPulse::slow_share(const OscillatorResponse& response, const State& state, double impulse) const {
  const auto omega_sq = static_cast<double>(response.omega_sq()), decay = 0.5 * static_cast<double>(response.damping());
  const double damped = std::sqrt(std::max(0.0, omega_sq - decay * decay));
  const double whole = std::abs(impulse * area_);
  const double since_s = static_cast<double>(steps_.size()) * static_cast<double>(step_s_) - centre_s_;
  if (!(damped > 0.5 * std::sqrt(omega_sq) && whole > 0.0 && decay * since_s < 1.0)) return 0.0;
  const auto z = static_cast<double>(state.z), zd = static_cast<double>(state.zd);
  const double left = std::hypot(damped * z, zd + decay * z) * std::exp(decay * since_s) / whole;
  return 1.0 - std::min(1.0, left * left);
}

long ContactPulse::add_bending(const OscillatorResponse& response, double impulse, std::vector<double>& bending) const {
  constexpr double kReachOfBending = 4.0;  // standard deviations
  constexpr double kFewSamples = 2.0;      // from here on a step's force counts as one at its centre
  const double step = static_cast<double>(step_s_), omega = std::sqrt(static_cast<double>(response.omega_sq()));
  const double width = 1.0 / (omega * step), scale = impulse / (omega * std::sqrt(2.0 * kPi));
  const auto reach = static_cast<long>(std::ceil(kReachOfBending * width));
  const auto n_samples = static_cast<long>(steps_.size()) + 1 + 2 * reach;
  bending.assign(static_cast<std::size_t>(n_samples), 0.0);
  const auto add = [&](double area, double time_s) {
    const double at = time_s / step + static_cast<double>(reach);  // in samples from bending[0]
    const long low = std::max(0L, static_cast<long>(std::ceil(at - kReachOfBending * width)));
    const long high = std::min(n_samples - 1, static_cast<long>(std::floor(at + kReachOfBending * width)));
    for (long n = low; n <= high; ++n) {
      const double u = (static_cast<double>(n) - at) / width;
      bending[static_cast<std::size_t>(n)] += scale * area * std::exp(-0.5 * u * u);
    }
  };
  for (std::size_t n = 0; n < steps_.size(); ++n) {
    if (width >= kFewSamples) {
      add(step_area_[n], step_time_s_[n]);
      continue;
    }
    for (std::size_t i = 0; i < steps_[n].weights.size(); ++i)
      add(steps_[n].weights[i], static_cast<double>(n + 1) * step - rules_[steps_[n].rule][i]);
  }
  return reach;
}

ContactPulse::State ContactPulse::drive(const OscillatorResponse& response, double impulse,
                                        std::vector<double>* z) const {
  const auto one = response.impulse(step_s_);
  State state;
  std::vector<OscillatorResponse::Impulse> kernel;
  std::size_t kernel_rule = rules_.size();
  if (z) z->clear();
  for (const Step& step : steps_) {
    if (step.rule != kernel_rule) {
      kernel_rule = step.rule;
      kernel.clear();
      for (double left_s : rules_[kernel_rule]) kernel.push_back(response.impulse(left_s));
    }
    if (z) z->push_back(static_cast<double>(state.z));
    State next{state.z * (one.zd + response.damping() * one.z) + state.zd * one.z,
               state.zd * one.zd - response.omega_sq() * one.z * state.z};
    for (std::size_t i = 0; i < kernel.size(); ++i) {
      next.z += impulse * step.weights[i] * kernel[i].z;
      next.zd += impulse * step.weights[i] * kernel[i].zd;
    }
    state = next;
  }
  return state;
}

}  // namespace klang::stage::detail

namespace klang::stage {

std::shared_ptr<const detail::ContactPulse> sampled(const ForceHistory& history, double sample_rate_hz) {
  return std::make_shared<const detail::ContactPulse>(history, sample_rate_hz);
}

}  // namespace klang::stage
