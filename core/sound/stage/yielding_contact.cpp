#include "core/sound/stage/yielding_contact.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/sound/stage/impact_pulses.hpp"

namespace klang::stage {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kStepsOfHertz = 100.0;  // of the shortest contact time
constexpr double kStepOfFastest = 0.25;  // times the inverse angular frequency of the stiffest oscillation
constexpr double kHertzTimes =
    3.218065459721568;  // contact time over (m / (k sqrt(v)))^(2/5): contact.md's 2.868266 in these units

void check(const YieldingContact& c) {
  const Index n = c.approach_m_s.size(), n_modes = c.angular_frequency_rad_s.size();
  if (n < 1 || c.mobility_per_kg.rows() != n || c.mobility_per_kg.cols() != n || c.stiffness_n_m32.size() != n ||
      c.residual_m_n.size() != n || c.shapes.rows() != n_modes || (n_modes > 0 && c.shapes.cols() != n))
    throw InputError("contact", "has parts of different sizes", std::to_string(n) + " places");
  if (!c.mobility_per_kg.allFinite() || !c.shapes.allFinite() || !(c.approach_m_s.minCoeff() > 0.0) ||
      !(c.stiffness_n_m32.minCoeff() > 0.0) || !(c.residual_m_n.minCoeff() >= 0.0) ||
      !(n_modes == 0 || c.angular_frequency_rad_s.minCoeff() > 0.0) || !c.approach_m_s.allFinite() ||
      !c.stiffness_n_m32.allFinite() || !c.residual_m_n.allFinite() || !(c.mobility_per_kg.diagonal().minCoeff() > 0.0))
    throw InputError("contact", "has values out of range", "", "positive speeds, stiffnesses, masses and frequencies");
}

/// F = k x^(3/2), x + c F = depth: by Newton in the root of x, from above, where the cubic is convex.
double force_n(double depth_m, double k, double c) {
  if (!(depth_m > 0.0)) return 0.0;
  double root = std::sqrt(depth_m);
  if (c > 0.0) {
    for (int i = 0; i < 60; ++i) {
      const double change = (root * root * (c * k * root + 1.0) - depth_m) / (root * (3.0 * c * k * root + 2.0));
      root -= change;
      if (!(std::abs(change) > 1e-14 * root)) break;
    }
  }
  return k * root * root * root;
}

/// So short that Hertz' half wave, the fastest mode and the stiffest spring against all that can yield at once are resolved.
double step_of(const YieldingContact& c) {
  double step_s = HUGE_VAL;
  for (Index i = 0; i < c.approach_m_s.size(); ++i) {
    const double k = c.stiffness_n_m32[i], v = c.approach_m_s[i], rigid = c.mobility_per_kg(i, i);
    step_s = std::min(step_s, kHertzTimes * std::pow(1.0 / (rigid * k * std::sqrt(v)), 0.4) / kStepsOfHertz);
    const double depth_m = std::pow(1.25 * v * v / (rigid * k), 0.4);
    const double softness = 1.0 / (1.5 * k * std::sqrt(depth_m)) + c.residual_m_n[i];
    const double yield = rigid + (c.shapes.rows() > 0 ? c.shapes.col(i).squaredNorm() : 0.0);
    step_s = std::min(step_s, kStepOfFastest * std::sqrt(softness / yield));
  }
  if (c.angular_frequency_rad_s.size() > 0)
    step_s = std::min(step_s, kStepOfFastest / c.angular_frequency_rad_s.maxCoeff());
  return step_s;
}

/// Modes as complex amplitudes u = omega q + i q', which turn by e^(-i omega dt) and which a push kicks along i.
class Modes {
 public:
  Modes(const YieldingContact& c, double step_s)
      : shapes_(c.shapes),
        inverse_(c.angular_frequency_rad_s.cwiseInverse()),
        cosine_((step_s * c.angular_frequency_rad_s.array()).cos()),
        sine_((step_s * c.angular_frequency_rad_s.array()).sin()),
        real_(Eigen::ArrayXd::Zero(inverse_.size())),
        imaginary_(real_) {}
  void kick(const VectorXd& impulse_n_s) { imaginary_ += (shapes_ * impulse_n_s).array(); }
  void turn() {
    const Eigen::ArrayXd before = real_;
    real_ = cosine_ * before + sine_ * imaginary_;
    imaginary_ = cosine_ * imaginary_ - sine_ * before;
  }
  VectorXd displacement_m() const { return shapes_.transpose() * (real_ * inverse_.array()).matrix(); }
  double energy_j() const { return 0.5 * (real_.square() + imaginary_.square()).sum(); }

 private:
  const Eigen::MatrixXd& shapes_;
  VectorXd inverse_;
  Eigen::ArrayXd cosine_, sine_, real_, imaginary_;
};

}  // namespace

ContactForces yielding_forces(const YieldingContact& c, double limit_s) {
  check(c);
  const Index n = c.approach_m_s.size();
  const bool yields = c.angular_frequency_rad_s.size() > 0;
  const double dt = step_of(c);
  Modes modes(c, dt);
  VectorXd depth_m = VectorXd::Zero(n), speed_m_s = c.approach_m_s, force = VectorXd::Zero(n);
  std::vector<VectorXd> rows = {force};
  std::size_t last_touch = 0;
  const auto most = static_cast<std::size_t>(std::ceil(limit_s / dt));
  while (rows.size() < most) {
    speed_m_s -= 0.5 * dt * (c.mobility_per_kg * force);
    if (yields) {
      modes.kick(0.5 * dt * force);
      modes.turn();
    }
    depth_m += dt * speed_m_s;
    const VectorXd closed_m = yields ? VectorXd(depth_m - modes.displacement_m()) : depth_m;
    for (Index i = 0; i < n; ++i) force[i] = force_n(closed_m[i], c.stiffness_n_m32[i], c.residual_m_n[i]);
    speed_m_s -= 0.5 * dt * (c.mobility_per_kg * force);
    if (yields) modes.kick(0.5 * dt * force);
    rows.push_back(force);
    if (force.maxCoeff() > 0.0) {
      last_touch = rows.size();
    } else if (speed_m_s.maxCoeff() < 0.0 && (!yields || rows.size() > 2 * last_touch)) {
      break;
    }
  }
  rows.resize(std::min(rows.size(), last_touch));
  rows.push_back(VectorXd::Zero(n));
  ContactForces forces;
  forces.step_s = dt;
  forces.force_n.resize(static_cast<Index>(rows.size()), n);
  for (std::size_t r = 0; r < rows.size(); ++r) forces.force_n.row(static_cast<Index>(r)) = rows[r].transpose();
  forces.impulse_n_s = dt * forces.force_n.colwise().sum().transpose();
  return forces;
}

double vibration_j(const YieldingContact& contact, const ContactForces& forces) {
  Modes modes(contact, forces.step_s);
  for (Index r = 0; r < forces.force_n.rows(); ++r) {
    modes.turn();
    modes.kick(forces.step_s * forces.force_n.row(r).transpose());
  }
  return modes.energy_j();
}

double hertz_stiffness_n_m32(double mass_kg, double approach_m_s, double duration_s) {
  return mass_kg / (std::sqrt(approach_m_s) * std::pow(duration_s / kHertzTimes, 2.5));
}

ForceHistory hertz_history(double begin_s, double duration_s) {
  constexpr int kSides = 256;
  // d'' = -d^(3/2), d' = 1 at d = 0: by Störmer's rule; its force at the sides' ends, over its own contact time.
  static const std::vector<double> shape = [] {
    constexpr int kFine = 40;
    const double step = kHertzTimes / (kSides * kFine);
    std::vector<double> force = {0.0};
    double depth = 0.0, speed = 1.0, before = 0.0;
    for (int i = 1; i < kSides * kFine; ++i) {
      depth += step * (speed - 0.5 * step * before);
      const double now = std::pow(std::max(depth, 0.0), 1.5);
      speed -= 0.5 * step * (before + now);
      before = now;
      if (i % kFine == 0) force.push_back(now);
    }
    force.push_back(0.0);
    double sum = 0.0;
    for (const double f : force) sum += f / kSides;
    for (double& f : force) f /= sum;
    return force;
  }();
  ForceHistory history{begin_s, duration_s / kSides, shape};
  for (double& f : history.force_per_s) f /= duration_s;
  return history;
}

VectorXd residual_of_higher_modes_m_n(const VectorXd& angular_frequency_rad_s, const Eigen::MatrixXd& shapes) {
  const Index n = angular_frequency_rad_s.size();
  if (n == 0) return VectorXd::Zero(shapes.cols());
  const double highest = angular_frequency_rad_s[n - 1];
  const auto* const first =
      std::lower_bound(angular_frequency_rad_s.data(), angular_frequency_rad_s.data() + n, 0.5 * highest);
  const Index in_octave = angular_frequency_rad_s.data() + n - first;
  return shapes.bottomRows(in_octave).colwise().squaredNorm().transpose() / (0.5 * highest * highest);
}

}  // namespace klang::stage
