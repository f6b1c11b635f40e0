#include "core/physics/bubble/bubble_motion.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/rise_formulas.hpp"

namespace klang::bubble {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Age at which a bubble has risen by way_m > 0: the inverse of risen_m.
double age_of_rise(const RiseLaw<double>& law, double start_speed_m_s, double way_m) {
  const double length = law.terminal_speed_m_s * law.time_constant_s;
  double start = start_speed_m_s / law.terminal_speed_m_s, turn = 0.0;
  if (start < 0.0) {
    turn = std::atan(-start);
    way_m += 0.5 * length * std::log1p(start * start);
    start = 0.0;
  }
  // e^{way/length} = cosh x + start sinh x, quadratic in e^x; over the large exponential against overflow.
  const double x = way_m / length, fall = std::exp(-2.0 * x);
  const double root = std::sqrt(std::max(0.0, 1.0 - (1.0 - start * start) * fall));
  return law.time_constant_s * (turn + x + std::log((1.0 + root) / (1.0 + start)));
}

class AnalyticRise final : public BubbleMotion {
 public:
  AnalyticRise(const Eigen::Vector3d& position, double radius, const RiseOptions& options, const BubbleMedium& medium)
      : position_(position), options_(options), law_(rise_law(medium, radius, options.drag_coefficient)) {
    const double way = -position.z() - options.stop_depth_radii * radius;
    if (options.kind == RiseKind::kFixed || !(way > 0.0)) {
      end_ = 0.0;
    } else if (options.kind == RiseKind::kConstantSpeed) {
      end_ = options.speed_m_s > 0.0 ? way / options.speed_m_s : kInfinity;
    } else {
      end_ = age_of_rise(law_, options.speed_m_s, way);
    }
  }
  Taylor phi_m(double age_s) const override {
    if (!(age_s < end_)) return position_.z() + risen<double>(end_ > 0.0 ? end_ : 0.0);
    return Taylor(position_.z()) + risen(Taylor(std::max(age_s, 0.0), 1.0, 0.0));
  }
  Eigen::Vector3d position_m(double age_s) const override { return {position_.x(), position_.y(), phi_m(age_s).v}; }
  std::vector<double> breaks_s() const override {
    return end_ > 0.0 && std::isfinite(end_) ? std::vector<double>{end_} : std::vector<double>{};
  }

 private:
  template <class T>
  T risen(const T& age) const {
    if (end_ == 0.0) return T(0.0);
    if (options_.kind == RiseKind::kConstantSpeed) return T(options_.speed_m_s) * age;
    return bubble::risen_m(RiseLaw<T>{T(law_.terminal_speed_m_s), T(law_.time_constant_s)}, T(options_.speed_m_s), age);
  }
  Eigen::Vector3d position_;
  RiseOptions options_;
  RiseLaw<double> law_;
  double end_ = 0.0;  // age at which it rests
};

class Sampled final : public BubbleMotion {
 public:
  explicit Sampled(SampledMotion samples) {
    const auto n = static_cast<std::ptrdiff_t>(samples.times_s.size());
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      for (const Eigen::Vector3d& p : samples.positions_m) values.push_back(p[axis]);
      const bool moves = samples.positions_m.size() > 1;
      place_[static_cast<std::size_t>(axis)] =
          CubicSpline(moves ? samples.times_s : std::vector<double>{0.0}, std::move(values));
    }
    if (samples.phi_m.empty()) {
      for (std::ptrdiff_t i = 0; i < n; ++i)
        samples.phi_m.push_back(
            samples.positions_m[samples.positions_m.size() > 1 ? static_cast<std::size_t>(i) : 0].z());
    }
    phi_ = CubicSpline(samples.times_s, low_passed(samples.times_s, samples.phi_m, samples.cutoff_hz));
    if (n > 1) scale_ = (samples.times_s.back() - samples.times_s.front()) / static_cast<double>(n - 1);
  }
  Taylor phi_m(double age_s) const override {
    const Taylor phi = phi_.at(age_s);
    return phi.v < 0.0 ? phi : Taylor(0.0);  // it cannot leave the liquid
  }
  Eigen::Vector3d position_m(double age_s) const override {
    return {place_[0].at(age_s).v, place_[1].at(age_s).v, place_[2].at(age_s).v};
  }
  std::vector<double> breaks_s() const override {
    return phi_.last_s() > 0.0 ? std::vector<double>{phi_.last_s()} : std::vector<double>{};
  }
  double time_scale_s() const override { return scale_; }

 private:
  std::array<CubicSpline, 3> place_;
  CubicSpline phi_;
  double scale_ = kInfinity;
};

}  // namespace

void RiseOptions::validate() const { validate_fields("rise", *this); }

std::shared_ptr<const BubbleMotion> analytic_rise(const Eigen::Vector3d& position_m, double radius_m,
                                                  const RiseOptions& options, const BubbleMedium& medium) {
  options.validate();
  checked("bubble", "radius_m", radius_m, kSmallestRadiusM, kLargestRadiusM);
  if (!(position_m.z() <= -radius_m) || !position_m.allFinite())
    throw InputError("bubble", "is not in the liquid at its birth", "z = " + to_text(position_m.z()) + " m",
                     "up to " + to_text(-radius_m) + ", its radius below the surface");
  return std::make_shared<AnalyticRise>(position_m, radius_m, options, medium);
}

std::shared_ptr<const BubbleMotion> sampled_motion(SampledMotion samples) {
  const std::size_t n = samples.times_s.size();
  KLANG_CHECK(n > 0 && (samples.positions_m.size() == n || samples.positions_m.size() == 1),
              "a position a time, or one");
  KLANG_CHECK(samples.phi_m.empty() || samples.phi_m.size() == n, "a phi a time, or none");
  return std::make_shared<Sampled>(std::move(samples));
}

}  // namespace klang::bubble
