#include "core/physics/modal/constraints/modal_step.hpp"

#include <Eigen/QR>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::modal {
namespace {

/// sin(x)/x or sinh(x)/x of a squared argument of either sign, and the cosine that belongs to it.
struct Waves {
  double cosine = 1.0, sine_over = 1.0;
};
Waves waves(double squared) {
  if (std::abs(squared) < 1e-8) return {1.0 + squared / 2.0, 1.0 + squared / 6.0};
  const double x = std::sqrt(std::abs(squared));
  return squared > 0.0 ? Waves{std::cosh(x), std::sinh(x) / x} : Waves{std::cos(x), std::sin(x) / x};
}

Eigen::MatrixXd solved(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& right) {
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(matrix);
  return decomposition.solve(right);
}

}  // namespace

ModalStep modal_step(double lambda, double damping, double dt_s) {
  if (!(lambda >= 0.0 && damping >= 0.0 && dt_s > 0.0))
    throw InputError("modal step", "is out of range", to_text(lambda) + ", " + to_text(damping) + ", " + to_text(dt_s),
                     "lambda >= 0, damping >= 0, dt > 0");
  const double half = 0.5 * damping, squared = (half * half - lambda) * dt_s * dt_s;
  ModalStep step;
  double h_slope = 0.0;
  if (squared > 1.0) {  // strongly damped: both exponentials by themselves, no overflow
    const double root = std::sqrt(half * half - lambda), slow = -lambda / (half + root), fast = -half - root;
    const double es = std::exp(slow * dt_s), ef = std::exp(fast * dt_s);
    step.h = (es - ef) / (2.0 * root);
    h_slope = (slow * es - fast * ef) / (2.0 * root);
  } else {
    const Waves w = waves(squared);
    const double decay = std::exp(-half * dt_s);
    step.h = decay * w.sine_over * dt_s;
    h_slope = decay * (w.cosine - half * dt_s * w.sine_over);
  }
  step.z_v = step.h;
  step.v_v = h_slope;
  step.z_z = h_slope + damping * step.h;
  step.v_z = -lambda * step.h;
  // 1 - z_z = lambda H; where that cancels, the series of H to the fifth power of the step.
  if (lambda * dt_s * dt_s > 1e-4) {
    step.h_integral = (1.0 - step.z_z) / lambda;
  } else if (damping * dt_s > 1e-2) {
    const double e = -std::expm1(-damping * dt_s), t = dt_s;  // lambda = 0, and lambda to first order
    const double c = damping, h0 = t / c - e / (c * c);
    const double h1 = (t * t / 2.0 - 2.0 * t / c + 3.0 * e / (c * c) - t * (1.0 - e) / c) / (c * c);
    step.h_integral = h0 - lambda * h1;
  } else {
    const double t = dt_s, c = damping, l = lambda;
    step.h_integral = t * t *
                      (0.5 - c * t / 6.0 + (c * c - l) * t * t / 24.0 - (c * c * c - 2.0 * c * l) * t * t * t / 120.0 +
                       (c * c * c * c - 3.0 * c * c * l + l * l) * t * t * t * t / 720.0);
  }
  return step;
}

ModalState::ModalState(const Eigen::VectorXd& lambda, const Eigen::VectorXd& damping)
    : z(Eigen::VectorXd::Zero(lambda.size())), v(z), lambda_(lambda), damping_(damping) {}

void ModalState::set_step(double dt_s) {
  if (dt_s == dt_s_) return;
  dt_s_ = dt_s;
  const Eigen::Index n = lambda_.size();
  for (Eigen::VectorXd* values : {&z_z_, &z_v_, &v_z_, &v_v_, &h_, &h_integral_}) values->resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const ModalStep step = modal_step(lambda_[i], damping_[i], dt_s);
    z_z_[i] = step.z_z;
    z_v_[i] = step.z_v;
    v_z_[i] = step.v_z;
    v_v_[i] = step.v_v;
    h_[i] = step.h;
    h_integral_[i] = step.h_integral;
  }
}

Eigen::VectorXd ModalState::free_z() const { return z_z_.cwiseProduct(z) + z_v_.cwiseProduct(v); }
Eigen::VectorXd ModalState::free_v() const { return v_z_.cwiseProduct(z) + v_v_.cwiseProduct(v); }

void ModalState::advance(const Eigen::VectorXd& g) {
  const Eigen::VectorXd end_z = free_z() + h_integral_.cwiseProduct(g);
  v = free_v() + h_.cwiseProduct(g);
  z = end_z;
}

double ModalState::energy_j() const { return 0.5 * (v.squaredNorm() + z.dot(lambda_.cwiseProduct(z))); }

Eigen::VectorXd position_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target_m) {
  return solved(w * state.h_integral().asDiagonal() * w.transpose(), target_m - w * state.free_z());
}

Eigen::VectorXd velocity_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target_m_s) {
  return solved(w * state.h().asDiagonal() * w.transpose(), target_m_s - w * state.free_v());
}

Eigen::VectorXd acceleration_forces(const ModalState& state, const Eigen::MatrixXd& w, const Eigen::VectorXd& target,
                                    const Eigen::VectorXd& g) {
  const Eigen::VectorXd own = g - state.lambda().cwiseProduct(state.z) - state.damping().cwiseProduct(state.v);
  return solved(w * w.transpose(), target - w * own);
}

Eigen::VectorXd position_impulse_forces(const ModalState& state, const Eigen::MatrixXd& w,
                                        const Eigen::VectorXd& target_m) {
  return solved(w * state.h().asDiagonal() * w.transpose(), target_m - w * state.free_z()) / state.step_s();
}

std::vector<int> kept_modes(const Eigen::MatrixXd& shapes, const Eigen::VectorXd& lambda, double least_m_per_n) {
  std::vector<int> kept;
  for (Eigen::Index k = 0; k < shapes.cols(); ++k) {
    double largest = 0.0;
    for (Eigen::Index i = 0; i + 2 < shapes.rows(); i += 3)
      largest = std::max(largest, shapes.block(i, k, 3, 1).squaredNorm());
    if (!(lambda[k] > 0.0) || largest / lambda[k] >= least_m_per_n) kept.push_back(static_cast<int>(k));
  }
  return kept;
}

}  // namespace klang::modal
